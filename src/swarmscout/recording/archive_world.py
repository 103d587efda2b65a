"""The world of a run: named by its generator's parameters if possible, else kept in ``world/``."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from swarmscout.core.errors import RunError, WorldError
from swarmscout.mission.scenario import Scenario
from swarmscout.recording.decisions import plain
from swarmscout.worlds.arrays import with_places
from swarmscout.worlds.catalogue import NAMED_TUBES
from swarmscout.worlds.folder import load_folder, save_world
from swarmscout.worlds.tube import generate_tube
from swarmscout.worlds.tube_parameters import TubeParameters
from swarmscout.worlds.world import World

__all__ = ["give_world_back", "keep_world"]

_FOLDER = "world"


def keep_world(
    world: World, scenario: Scenario, folder: Path, *, whole: bool = False
) -> tuple[Scenario, dict[str, Any]]:
    """Keep what is needed to load a mission's world again.

    Args:
        world: the mission's world.
        scenario: the mission's scenario.
        folder: the run's folder.
        whole: keep rasters even of a world that the scenario seems to name.

    Returns:
        The scenario to write into the run, and the facts about the world for ``run.json``. A world
        that is kept whole is named by its folder, so that the run can be moved.

    Raises:
        RunError: the world cannot be written.
    """
    facts = {
        "name": world.name,
        "source": plain(world.source),
        "start_m": plain(world.start_m),
        "stations_m": plain(world.stations_m),
    }
    if world.mesh is not None and scenario.sensor.sensing == "raster":
        world = dataclasses.replace(world, mesh=None)  # Often many megabytes that no ray met.
    if not whole and _is_named_by(scenario, world):
        return scenario, {"kept_as": "recipe", **facts}
    try:
        save_world(world, folder / _FOLDER)
    except OSError as error:
        raise RunError(f"cannot write '{folder / _FOLDER}': {error.strerror or error}") from error
    named = scenario.model_copy(update={"world": _FOLDER, "world_seed": None})
    return named, {"kept_as": "folder", **facts}


def give_world_back(folder: Path, facts: Mapping[str, Any]) -> World:
    """The world that a run was recorded in.

    Args:
        folder: the run's folder.
        facts: the content of its ``run.json``.

    Raises:
        RunError: it is missing or damaged, or the installed generator makes another one.
    """
    kept = facts.get("world")
    try:
        if not isinstance(kept, Mapping):
            raise KeyError("world")
        if kept["kept_as"] == "folder":
            return load_folder(folder / _FOLDER)
        source = kept["source"]
        world = generate_tube(TubeParameters.of(source), kept["name"])
        same = world.digest == source["digest"]
        world = with_places(world, kept["start_m"], kept["stations_m"])
    except WorldError as error:
        raise RunError(f"the world of run '{folder}' cannot be loaded: {error}") from None
    except (KeyError, TypeError, AttributeError) as error:
        raise RunError(f"'{folder / 'run.json'}' is damaged: world: {error}") from None
    if not same:
        raise RunError(
            f"the world of run '{folder}' cannot be made again: this version of swarmscout "
            f"generates another '{world.name}' than version {facts.get('version')} did"
        )
    return world


def _is_named_by(scenario: Scenario, world: World) -> bool:
    """Whether the scenario's ``world`` and ``world_seed`` give this world again."""
    if scenario.world not in NAMED_TUBES or world.stations_m is not None or world.mesh is not None:
        return False
    parameters = NAMED_TUBES[scenario.world][1]
    if scenario.world_seed is not None:
        parameters = dataclasses.replace(parameters, seed=scenario.world_seed)
    recipe = {"generator": "lava-tube", **dataclasses.asdict(parameters)}
    return world.name == scenario.world and recipe.items() <= world.source.items()
