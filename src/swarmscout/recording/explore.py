"""Run one mission and get its run: the function that most scripts need."""

from __future__ import annotations

import contextlib
from collections.abc import Callable
from pathlib import Path
from typing import Any

from swarmscout.core.errors import RunError
from swarmscout.core.model import Model
from swarmscout.mission.mission import Mission
from swarmscout.mission.scenario import Scenario
from swarmscout.mission.scenario_files import make_scenario
from swarmscout.recording.run import Run
from swarmscout.recording.run_folder import claim_folder, release_folder
from swarmscout.recording.tables import check_level
from swarmscout.recording.writer import RunWriter
from swarmscout.worlds.world import World

__all__ = ["explore", "record_mission"]


def explore(
    world: str | Path | World = "lava-tube",
    robots: int = 15,
    steps: int = 300,
    destinations: str = "nearest",
    seed: int = 0,
    *,
    out: str | Path | None = None,
    record: str = "full",
    model: Model | None = None,
    **more: Any,
) -> Run:
    """Run a mission to its end.

    Args:
        world: a named world, the path of a map, or a :class:`~swarmscout.worlds.world.World`.
        robots: N, the number of robots.
        steps: the mission's length.
        destinations: a selector's name, or ``FILE.py:NAME``.
        seed: starts, noise, charge, characters, decisions.
        out: a new or empty folder for the run; None keeps it in memory.
        record: ``full``; ``curves`` (no steps, maps or events); ``summary``.
        model: answers a selector that asks a language model, instead of the scenario's.
        **more: further scenario keys; a section is a mapping: ``teams={"desired_size": 3}``.

    Returns:
        The finished run.

    Raises:
        ScenarioError: a key is unknown or impossible.
        WorldError: the world cannot be loaded.
        SelectorError: the selector is unknown.
        ModelError: the selector asks a language model, and none is configured.
        RunError: ``out`` is not empty or cannot be written.

    Example:
        >>> run = explore(robots=5, steps=50, seed=1)  # doctest: +SKIP
        >>> run.summary["explored_m2"]  # doctest: +SKIP
    """
    keys: dict[str, Any] = {
        "world": world.name if isinstance(world, World) else str(world),
        "robots": robots,
        "steps": steps,
        "destinations": destinations,
        "seed": seed,
        **more,
    }
    given = world if isinstance(world, World) else None
    return record_mission(make_scenario(keys), out=out, record=record, world=given, model=model)


def record_mission(
    scenario: Scenario,
    *,
    out: str | Path | None = None,
    record: str = "full",
    world: World | None = None,
    base: Path | None = None,
    on_step: Callable[[Mission], None] | None = None,
    model: Model | None = None,
) -> Run:
    """Run a scenario's mission and record it.

    When something breaks the mission off (an error, an interrupt), what was recorded until then is
    written down before the exception goes on its way; nothing is left behind when it never began.

    Args:
        scenario: what to run.
        out: a new or empty folder, or None for memory.
        record: the recording level.
        world: the world, when it is not to be loaded by the scenario's name.
        base: folder for relative paths of the scenario, besides the working directory.
        on_step: called with the mission after each step.
        model: answers a selector that asks a language model, instead of the scenario's.

    Raises:
        SwarmscoutError: as :func:`explore`.
    """
    check_level(record)
    folder = None if out is None else claim_folder(Path(out))
    writer = RunWriter(folder, level=record, whole_world=world is not None)
    mission: Mission | None = None
    try:
        mission = Mission(scenario, world=world, recorder=writer, base=base, model=model)
        mission.run(on_step)
    except BaseException:
        # The reason for breaking off is what matters; that the disk is full was it, perhaps.
        with contextlib.suppress(RunError):
            writer.close()
        if folder is not None:
            release_folder(folder)
        raise
    finally:
        if mission is not None:
            mission.close()
    return writer.run()
