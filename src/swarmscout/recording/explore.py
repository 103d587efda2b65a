"""Run one mission and get its run: the function that most scripts need."""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

from swarmscout.core.errors import RunError
from swarmscout.core.recorder import Recorder, StepRecord
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
        **more: further scenario keys; a section is a mapping: ``teams={"desired_size": 3}``.

    Returns:
        The finished run.

    Raises:
        ScenarioError: a key is unknown or impossible.
        WorldError: the world cannot be loaded.
        SelectorError: the selector is unknown.
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
    return record_mission(make_scenario(keys), out=out, record=record, world=given)


def record_mission(
    scenario: Scenario,
    *,
    out: str | Path | None = None,
    record: str = "full",
    world: World | None = None,
    base: Path | None = None,
    on_step: Callable[[Mission], None] | None = None,
    watchers: Sequence[Recorder] = (),
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
        watchers: further recorders, for example one that shows the mission while it runs.

    Raises:
        SwarmscoutError: as :func:`explore`.
    """
    check_level(record)
    folder = None if out is None else claim_folder(Path(out))
    writer = RunWriter(folder, level=record, whole_world=world is not None)
    try:
        recorder = _All([writer, *watchers]) if watchers else writer
        Mission(scenario, world=world, recorder=recorder, base=base).run(on_step)
    except BaseException:
        # The reason for breaking off is what matters; that the disk is full was it, perhaps.
        with contextlib.suppress(RunError):
            writer.close()
        if folder is not None:
            release_folder(folder)
        raise
    return writer.run()


class _All:
    """Several recorders as one; the writer is the first and knows a step before anybody sees it."""

    def __init__(self, recorders: Sequence[Recorder]) -> None:
        self._recorders = recorders

    def begin(self, mission: Mission) -> None:
        for recorder in self._recorders:
            recorder.begin(mission)

    def record(self, record: StepRecord) -> None:
        for recorder in self._recorders:
            recorder.record(record)

    def end(self, summary: Mapping[str, Any]) -> None:
        for recorder in self._recorders:
            recorder.end(summary)
