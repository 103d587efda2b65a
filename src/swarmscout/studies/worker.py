"""What a worker does: one mission, from its scenario to a finished run folder."""

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
from swarmscout.worlds.catalogue import NAMED_TUBES, load_world
from swarmscout.worlds.world import World

__all__ = ["Outcome", "Task", "carry_out"]


@dataclass(frozen=True, slots=True)
class Task:
    """One mission to be run.

    Attributes:
        name: of the mission.
        scenario: what to run.
        folder: where its run goes, as text: it may be another machine's path.
        record: the recording level.
    """

    name: str
    scenario: Scenario
    folder: str
    record: str


@dataclass(frozen=True, slots=True)
class Outcome:
    """What came of a task.

    Attributes:
        name: of the mission.
        error: what went wrong, in one line; None when it succeeded.
        traceback: where, for a defect.
        explored_m2: explored area; NaN for a failed mission.
        seconds: CPU time of the mission and of recording it, without loading its world.
    """

    name: str
    error: str | None = None
    traceback: str = ""
    explored_m2: float = float("nan")
    seconds: float = 0.0


def carry_out(task: Task) -> Outcome:
    """Run one mission and keep it; an error is an outcome, too.

    The run appears under its name whole or not at all. Where it stands already, nothing is done.
    """
    final = Path(task.folder)
    if final.exists():
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
        # A mission that is killed is run anew: there is no need to close its tables on the way.
        writer = RunWriter(part, level=task.record, parts=False)
        mission = Mission(task.scenario, world=world, recorder=writer)
        try:
            summary = mission.run()
        finally:
            mission.close()
        seconds = time.process_time() - began
        try:
            os.rename(part, final)
        except OSError as error:
            if not final.is_dir():  # Else another worker was quicker; its run is the same.
                raise RunError(f"cannot make '{final}': {error.strerror or error}") from None
    finally:
        if part.exists():
            shutil.rmtree(part, ignore_errors=True)
    return float(summary["explored_m2"]), seconds


@cache
def _settle() -> None:
    """After its first mission a worker has loaded what it needs: no need to look at it again.

    Libraries and compiled code are half a million objects. The garbage collector goes through all
    of them whenever a few missions have kept enough rows, which took a tenth of a worker's time.
    """
    gc.collect()
    gc.freeze()


@lru_cache(maxsize=8)
def _world(what: str, seed: int | None, stamp: int) -> World:
    return load_world(what, seed=seed)


def _stamp(what: str) -> int:
    """When a world's file was changed; a worker on a cluster may live longer than a map."""
    if what in NAMED_TUBES:
        return 0
    try:
        return Path(what).stat().st_mtime_ns
    except OSError:
        return 0
