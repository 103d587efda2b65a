"""One mission in a worker process, from its scenario to a finished run folder."""

from __future__ import annotations

import gc
import os
import shutil
import time
import traceback
import uuid
from dataclasses import dataclass
from functools import cache, lru_cache
from pathlib import Path

from swarmscout.core.errors import RunError, SwarmscoutError
from swarmscout.mission.mission import Mission
from swarmscout.mission.scenario import Scenario
from swarmscout.recording.writer import RunWriter
from swarmscout.studies.study_folder import is_run
from swarmscout.worlds.catalogue import NAMED_TUBES, load_world
from swarmscout.worlds.world import World

__all__ = ["Outcome", "Task", "run_task"]


@dataclass(frozen=True, slots=True)
class Task:
    """One mission to run.

    Attributes:
        name: the mission's name.
        scenario: its resolved scenario.
        folder: where its run goes, as text, since it may be a path of another machine.
        record: the recording level.
    """

    name: str
    scenario: Scenario
    folder: str
    record: str


@dataclass(frozen=True, slots=True)
class Outcome:
    """The result of a task.

    Attributes:
        name: the mission's name.
        error: what went wrong, in one line; None when the mission succeeded.
        traceback: where, for a defect; empty for a known error.
        explored_m2: explored area; NaN for a failed mission.
        seconds: CPU time of the mission and its recording, without loading the world.
    """

    name: str
    error: str | None = None
    traceback: str = ""
    explored_m2: float = float("nan")
    seconds: float = 0.0


def run_task(task: Task) -> Outcome:
    """Run one mission and keep it; an error is returned as an outcome.

    The run appears under its name complete or not at all. A run that exists already is kept.
    """
    final = Path(task.folder)
    if is_run(final):
        return Outcome(task.name)
    try:
        explored_m2, seconds = _run(task, final)
    except SwarmscoutError as error:
        return Outcome(task.name, f"{type(error).__name__}: {error}")
    except Exception as error:
        line = f"{type(error).__name__}: {error}"
        return Outcome(task.name, " ".join(line.split()), traceback.format_exc())
    _settle()
    return Outcome(task.name, explored_m2=explored_m2, seconds=seconds)


def _run(task: Task, final: Path) -> tuple[float, float]:
    part = final.with_name(f".{final.name}-{uuid.uuid4().hex[:12]}")
    try:
        world = _world(task.scenario.world, task.scenario.world_seed, _stamp(task.scenario.world))
        began = time.process_time()
        # A mission that is killed is run again, so its tables need no closed parts on the way.
        writer = RunWriter(part, level=task.record, parts=False)
        mission = Mission(task.scenario, world=world, recorder=writer)
        try:
            summary = mission.run()
        finally:
            mission.close()
        seconds = time.process_time() - began
        if final.is_dir() and not is_run(final):
            shutil.rmtree(final, ignore_errors=True)  # Not a run: nothing can read it.
        try:
            os.rename(part, final)
        except OSError as error:
            if not is_run(final):  # Otherwise another worker finished first, with the same run.
                raise RunError(f"cannot make '{final}': {error.strerror or error}") from None
    finally:
        if part.exists():
            shutil.rmtree(part, ignore_errors=True)
    return float(summary["explored_m2"]), seconds


@cache
def _settle() -> None:
    """Exempt what is loaded after the first mission from garbage collection.

    Libraries and compiled code are half a million objects. Going through all of them after every
    few missions took a tenth of a worker's time.
    """
    gc.collect()
    gc.freeze()


@lru_cache(maxsize=8)
def _world(what: str, seed: int | None, stamp: int) -> World:
    return load_world(what, seed=seed)


def _stamp(what: str) -> int:
    """When a world's file last changed: a worker of a cluster may outlive a map."""
    if what in NAMED_TUBES:
        return 0
    try:
        return Path(what).stat().st_mtime_ns
    except OSError:
        return 0
