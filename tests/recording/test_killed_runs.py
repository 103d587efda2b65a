"""A run survives its mission's death, whenever that comes."""

from __future__ import annotations

import os
import random
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import polars as pl
import pytest

from swarmscout import Run, RunError, RunWriter, Scenario, record_mission
from swarmscout.recording import table_files
from swarmscout.recording.tables import PART_STEPS, TABLES

KILLS = 20
STEPS = 300
SCENARIO = {"robots": 5, "steps": STEPS, "seed": 2, "destinations": "nearest"}

CHILD = f"""
import os, sys
from swarmscout import Scenario, record_mission
def told(mission):
    os.write(1, b"%d\\n" % mission.step_number)
record_mission(Scenario(**{SCENARIO}), out=sys.argv[1], on_step=told)
"""


def assert_beginning(run: Run, whole: Run, at_least: int) -> None:
    """A run holds the beginning of the whole run, up to a step or further."""
    last = run.last_step
    assert last >= at_least
    for table in TABLES:
        expected = whole.table(table).filter(pl.col("step") <= last)
        if table == "timing":
            assert run.timing["step"].equals(expected["step"])
        elif expected.height or run.table(table).height:
            assert run.table(table).equals(expected), table
    if last >= 0:
        np.testing.assert_array_equal(run.map_at(last), whole.map_at(last))
        np.testing.assert_array_equal(run.map_at(last // 2), whole.map_at(last // 2))


@pytest.mark.slow
def test_a_killed_mission_loses_less_than_fifty_steps(tmp_path: Path) -> None:
    whole = record_mission(Scenario(**SCENARIO))  # type: ignore[arg-type]
    draw = random.Random(7)
    survived = set()
    for attempt in range(KILLS):
        # One moment in each twentieth of the mission, the last while it is being finished.
        step = min(STEPS, round((attempt + 1 - 0.9 * draw.random()) * (STEPS + 15) / KILLS))
        folder = tmp_path / str(attempt)
        told = _kill_at(folder, step, wait_s=0.03 * draw.random())
        run = Run.open(folder)
        survived.add(run.last_step)
        assert_beginning(run, whole, at_least=told - PART_STEPS + 1)
        assert run.finished == (run.summary is not None)
        if run.finished:
            assert run.summary == whole.summary
        np.testing.assert_array_equal(run.world().free, whole.world().free)
    assert len(survived) >= 5, "the moments of death were not spread over the mission"


def _kill_at(folder: Path, step: int, wait_s: float) -> int:
    """Start a mission, kill it shortly after a step; return the last step it told of."""
    child = subprocess.Popen([sys.executable, "-c", CHILD, str(folder)], stdout=subprocess.PIPE)
    assert child.stdout is not None
    told = 0
    while told < step:
        line = child.stdout.readline()
        assert line, "the mission ended by itself before it could be killed"
        told = int(line)
    time.sleep(wait_s)
    child.send_signal(signal.SIGKILL)
    rest = child.stdout.read().split()
    child.stdout.close()
    child.wait()
    return int(rest[-1]) if rest else told


class Dead(BaseException):
    """The process is gone."""


@pytest.fixture
def die_at(monkeypatch: pytest.MonkeyPatch) -> Iterator[Callable[[int], list[int]]]:
    """Arm every operation that touches the disk: the n-th does half of its work, then all ends."""
    count = [0, -1]

    def arm(owner: Any, name: str, half: Callable[..., None]) -> None:
        real = getattr(owner, name)

        def operation(*args: Any, **more: Any) -> Any:
            count[0] += 1
            if count[0] == count[1]:
                half(*args)
                raise Dead
            if 0 <= count[1] < count[0]:
                raise Dead
            return real(*args, **more)

        monkeypatch.setattr(owner, name, operation)

    arm(table_files, "_fill", lambda path, data, _: path.write_bytes(data[: len(data) // 2]))
    arm(os, "replace", lambda *_: None)
    arm(Path, "unlink", lambda *_: None)
    arm(Path, "rmdir", lambda *_: None)

    def at(operation: int) -> list[int]:
        count[:] = [0, operation]
        return count

    yield at
    count[1] = -1


def test_death_at_any_operation_on_the_disk(
    tape: Any, finished: Run, tmp_path: Path, die_at: Callable[[int], list[int]]
) -> None:
    operation, opened = 0, 0
    while True:
        operation += 1
        folder = tmp_path / str(operation)
        count = die_at(operation)
        told = -1
        writer = RunWriter(folder)
        try:
            writer.begin(tape.mission)
            for record in tape.records:
                told = record.step
                writer.record(record)
            writer.end(tape.summary)
        except Dead:
            pass
        died, count[1] = count[0] >= operation, -1
        if told == -1 and not (folder / "run.json").exists():
            with pytest.raises(RunError, match=r"does not exist|is not a run"):
                Run.open(folder)
            continue
        run = Run.open(folder)
        opened += 1
        # The step during which the process dies may be lost together with the 49 before it.
        assert_beginning(run, finished, at_least=told - PART_STEPS)
        assert run.finished == (folder / "summary.json").exists() >= (not died)
        if not died:
            break
    assert opened > 20, "too few operations were tried for this test to mean anything"


def test_a_mission_that_breaks_off_keeps_every_step(
    scenario: Scenario, finished: Run, empty: Path
) -> None:
    def fail(mission: Any) -> None:
        if mission.step_number == 77:
            raise RuntimeError("something else broke")

    with pytest.raises(RuntimeError, match="something else"):
        record_mission(scenario, out=empty, on_step=fail)
    run = Run.open(empty)
    assert not run.finished
    assert run.last_step == 77
    assert_beginning(run, finished, at_least=77)


def test_closing_may_be_interrupted_and_repeated(
    tape: Any, finished: Run, empty: Path, die_at: Callable[[int], list[int]]
) -> None:
    writer = RunWriter(empty)
    tape.play(writer, until=70, end=False)
    for operation in range(1, 200):
        count = die_at(operation)
        try:
            writer.close()
        except Dead:
            count[1] = -1
            assert_beginning(Run.open(empty), finished, at_least=49)
            continue
        break
    count[1] = -1
    assert_beginning(Run.open(empty), finished, at_least=70)


def test_a_full_disk_keeps_what_was_written(
    tape: Any, finished: Run, empty: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    real = table_files._fill

    def full(path: Path, data: bytes, durable: bool) -> None:
        if "000002" in path.name:
            raise OSError(28, "No space left on device")
        real(path, data, durable)

    monkeypatch.setattr(table_files, "_fill", full)
    with pytest.raises(RunError, match=r"cannot write '.*': No space left on device"):
        tape.play(RunWriter(empty))
    assert_beginning(Run.open(empty), finished, at_least=99)
