"""A study's missions: every combination of the axes' values with every seed, each with a name.

A mission's name contains a digest of its resolved scenario, of the files that the scenario names,
and of the rules version. A run is therefore found again when other parts of the study's file
change, and a run by other rules is not mistaken for it.
"""

from __future__ import annotations

import hashlib
import json
from dataclasses import dataclass
from itertools import product
from pathlib import Path
from typing import Any

from swarmscout.core.errors import StudyError, SwarmscoutError
from swarmscout.mission.mission import RULES_VERSION
from swarmscout.mission.plug_ins import PLUG_INS, PlugIn
from swarmscout.mission.scenario import Scenario
from swarmscout.mission.scenario_files import load_scenario, make_scenario
from swarmscout.recording.run_folder import default_name
from swarmscout.studies.study_file import (
    PATH_KEYS,
    Axis,
    StudyFile,
    absolute,
    base_of,
    changes_of,
    refuse_fifo,
)
from swarmscout.worlds.catalogue import NAMED_TUBES, load_world

__all__ = ["PlannedMission", "base_scenario", "expand", "scenario_of"]


@dataclass(frozen=True, slots=True)
class PlannedMission:
    """One mission of a study, before or after it is run.

    Attributes:
        name: the name of its run folder.
        values: index of its value on each axis.
        world: the world's name or file.
        world_seed: the world's seed; None for the default.
        seed: the mission's seed.
        steps: planned number of steps.
        robots: number of robots.
    """

    name: str
    values: tuple[int, ...]
    world: str
    world_seed: int | None
    seed: int
    steps: int
    robots: int


def base_scenario(declared: StudyFile, folder: Path) -> Scenario:
    """The scenario that a study starts from, with the study's own changes.

    Raises:
        ScenarioError: the base cannot be read, or a change is impossible.
    """
    return load_scenario(base_of(declared, folder), changes_of(declared, folder))


def expand(
    declared: StudyFile, axes: list[Axis], base: Scenario, folder: Path
) -> list[PlannedMission]:
    """Every mission of a study, world by world, so that a worker loads each world once.

    Args:
        declared: the contents of the study's file.
        axes: its axes.
        base: the scenario that it starts from.
        folder: what relative paths are relative to.

    Raises:
        StudyError: a combination is impossible, or names something that does not exist.
    """
    known_good: dict[Any, str] = {}
    planned = []
    for values in product(*(range(len(axis.values)) for axis in axes)):
        first = scenario_of(axes, base, folder, values, declared.first_seed)
        try:
            world = _check_world(first, known_good)
            files = [_check_rule(kind, first, known_good) for kind in PLUG_INS]
        except SwarmscoutError as error:
            raise StudyError(f"{_where(axes, values)}: {error}") from None
        for trial in range(declared.trials):
            scenario = first.model_copy(update={"seed": declared.first_seed + trial})
            planned.append(
                PlannedMission(
                    name=_name(scenario, world, files, declared.record),
                    values=values,
                    world=scenario.world,
                    world_seed=scenario.world_seed,
                    seed=scenario.seed,
                    steps=scenario.steps,
                    robots=scenario.robots,
                )
            )
    order = {place: at for at, place in enumerate(dict.fromkeys(map(_place, planned)))}
    planned.sort(key=lambda mission: (order[_place(mission)], mission.seed))
    return planned


def scenario_of(
    axes: list[Axis], base: Scenario, folder: Path, values: tuple[int, ...], seed: int
) -> Scenario:
    """The resolved scenario of one mission.

    Raises:
        StudyError: the combination of values is impossible.
    """
    keys: dict[str, Any] = {}
    for axis, index in zip(axes, values, strict=True):
        for key, value in axis.values[index].keys.items():
            keys[key] = absolute(value, folder) if key in PATH_KEYS else value
    try:
        return make_scenario(base.model_dump(), {**keys, "seed": seed})
    except SwarmscoutError as error:
        raise StudyError(f"{_where(axes, values)}: {error}") from None


def _place(mission: PlannedMission) -> tuple[str, int | None]:
    return mission.world, mission.world_seed


def _where(axes: list[Axis], values: tuple[int, ...]) -> str:
    pairs = (f"{a.name} = {a.values[i].label}" for a, i in zip(axes, values, strict=True))
    return f"the combination {', '.join(pairs)}"


def _check_world(scenario: Scenario, known: dict[Any, str]) -> str:
    """A digest of a world's file; empty for a named world."""
    key = ("world", scenario.world, scenario.world_seed)
    if key not in known:
        known[key] = ""
        if scenario.world not in NAMED_TUBES:
            refuse_fifo(Path(scenario.world), f"world '{scenario.world}'")
            world = load_world(scenario.world, seed=scenario.world_seed)
            stations = None if world.stations_m is None else world.stations_m.tolist()
            known[key] = f"{world.digest} {world.start_m} {stations}"
    return known[key]


def _check_rule(kind: PlugIn, scenario: Scenario, known: dict[Any, str]) -> str:
    """A digest of a plug-in's file; empty for a registered one."""
    name, parameters = kind.name(scenario), kind.parameters(scenario)
    key = (kind.registry.noun, name, json.dumps(parameters, sort_keys=True, default=str))
    if key not in known:
        kind.registry.make(name, parameters)
        path, colon, _ = name.rpartition(":")
        is_file = colon and path.endswith(".py")
        known[key] = hashlib.sha256(Path(path).read_bytes()).hexdigest() if is_file else ""
    return known[key]


def _name(scenario: Scenario, world: str, files: list[str], record: str) -> str:
    """``<world>-<selector>-n<robots>-s<seed>-<digest>``."""
    named = scenario
    # A file is identified by its contents, not by its path.
    for kind, digest in zip(PLUG_INS, files, strict=True):
        if digest:
            named = kind.renamed(named, f"{kind.name(scenario).rpartition(':')[2]} {digest}")
    data = named.model_dump(mode="json")
    if world:
        data["world"] = world
    text = json.dumps([data, RULES_VERSION, record], sort_keys=True)
    return f"{default_name(scenario)}-{hashlib.sha256(text.encode()).hexdigest()[:12]}"
