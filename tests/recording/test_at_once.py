"""A run that is written at once, as studies write theirs, holds what any other run does."""

from __future__ import annotations

import contextlib
import gc
import random
import shutil
import weakref
import zipfile
from pathlib import Path
from typing import Any

import numpy as np
import polars as pl
import pytest

from swarmscout import Mission, Run, RunError, RunWriter, Scenario
from swarmscout.core.recorder import StepRecord
from swarmscout.recording import table_files
from swarmscout.recording.tables import LEVELS, OWN_MAPS


def written(tape: Any, folder: Path, level: str, **how: Any) -> Run:
    writer = RunWriter(folder, level=level, **how)
    tape.play(writer)
    return writer.run()


@pytest.mark.parametrize("level", LEVELS)
def test_it_holds_the_same(level: str, tape: Any, finished: Run, tmp_path: Path) -> None:
    run = written(tape, tmp_path / "run", level, parts=False)
    clocked = {"timing.zip"} if "timing" in LEVELS[level] else set()
    assert {file.name for file in (tmp_path / "run").iterdir()} == {
        "scenario.toml", "run.json", "data.zip", "summary.json", *clocked,
    }  # fmt: skip
    assert run.finished
    assert run.summary == finished.summary
    assert run.last_step == finished.last_step
    np.testing.assert_array_equal(run.map_at(), finished.map_at())
    for table in LEVELS[level]:
        assert run.table(table).schema == finished.table(table).schema, table
        if table == "timing":
            assert run.timing["step"].equals(finished.timing["step"])
        else:
            assert run.table(table).equals(finished.table(table)), table
    with pytest.raises(RunError, match="has no table"):
        run.table("nonsense")


def test_curves_are_those_of_a_full_run(tape: Any, finished: Run, tmp_path: Path) -> None:
    run = written(tape, tmp_path / "run", "curves", parts=False)
    for table in ("decisions", "coverage", "attempts"):
        assert run.table(table).equals(finished.table(table)), table
    for table in {*LEVELS["full"]} - {*LEVELS["curves"], *OWN_MAPS}:
        with pytest.raises(RunError, match=f"'{table}' was not recorded"):
            run.table(table)


def test_the_archive_is_readable_without_us(tape: Any, finished: Run, tmp_path: Path) -> None:
    written(tape, tmp_path / "run", "curves", parts=False)
    file = tmp_path / "run" / "data.zip"
    with zipfile.ZipFile(file) as archive:
        assert archive.testzip() is None
        assert pl.read_ipc_stream(archive.read("coverage.arrows")).equals(finished.coverage)
    assert finished.path is not None
    with np.load(file) as here, np.load(finished.path / "map.npz") as there:
        for name in there.files:
            np.testing.assert_array_equal(here[name], there[name])


def test_only_timing_differs_from_run_to_run(scenario: Scenario, tmp_path: Path) -> None:
    for name in ("a", "b"):
        Mission(scenario, recorder=RunWriter(tmp_path / name, parts=False)).run()
    for file in (tmp_path / "a").iterdir():
        same = file.read_bytes() == (tmp_path / "b" / file.name).read_bytes()
        assert same == (file.name != "timing.zip"), file


def test_damage_is_one_clear_line(tape: Any, tmp_path: Path) -> None:
    whole = written(tape, tmp_path / "whole", "curves", parts=False)
    data = (tmp_path / "whole" / "data.zip").read_bytes()
    draw = random.Random(3)
    damaged = [data[: draw.randrange(len(data))] for _ in range(40)]
    for _ in range(300):
        wrong = bytearray(data)
        for _ in range(draw.choice((1, 1, 4))):
            wrong[draw.randrange(len(data))] = draw.randrange(256)
        damaged.append(bytes(wrong))
    broken = tmp_path / "broken"
    shutil.copytree(tmp_path / "whole", broken)
    refused = 0
    for wrong in damaged:
        (broken / "data.zip").write_bytes(wrong)
        run = Run.open(broken)
        for table in ("decisions", "coverage"):
            with contextlib.suppress(RunError):
                assert run.table(table).equals(whole.table(table))
                continue
            refused += 1
        with contextlib.suppress(RunError):
            np.testing.assert_array_equal(run.map_at(), whole.map_at())
    assert refused > 200, "too little was damaged for this test to mean anything"
    (broken / "data.zip").write_bytes(data[:-30])
    with pytest.raises(
        RunError, match=r"data\.zip' is damaged: its 'coverage\.arrows' is not whole"
    ):
        _ = Run.open(broken).coverage
    with zipfile.ZipFile(broken / "data.zip", "w") as archive:
        archive.writestr("coverage.arrows", b"something else")
    with pytest.raises(RunError, match=r"data\.zip' is damaged: its 'coverage' is not a table"):
        _ = Run.open(broken).coverage
    with zipfile.ZipFile(tmp_path / "whole" / "data.zip") as archive:
        coverage = archive.read("coverage.arrows")
    with zipfile.ZipFile(broken / "data.zip", "w") as archive:
        archive.writestr("coverage.arrows", coverage)
    with pytest.raises(RunError, match=r"data\.zip' is damaged: it holds no 'log_odds\.npy'"):
        Run.open(broken).map_at()
    (broken / "data.zip").unlink()
    with pytest.raises(RunError, match=r"is damaged: its table 'coverage' is missing"):
        _ = Run.open(broken).coverage


class Dead(BaseException):
    """The process is gone."""


def test_death_while_it_is_written_never_counts(
    tape: Any, finished: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    fill, left = table_files._fill, [0]

    def dying(path: Path, data: bytes, durable: bool) -> None:
        left[0] -= 1
        if left[0] < 0:
            path.write_bytes(data[: len(data) // 2])
            raise Dead
        fill(path, data, durable)

    monkeypatch.setattr(table_files, "_fill", dying)
    for operations in range(5):
        left[0] = operations
        with pytest.raises(Dead):
            written(tape, tmp_path / str(operations), "curves", parts=False)
        if operations >= 2:
            run = Run.open(tmp_path / str(operations))
            assert not run.finished
            assert run.last_step == (finished.last_step if operations == 4 else -1)
    left[0] = 5
    assert written(tape, tmp_path / "whole", "curves", parts=False).finished


def test_a_broken_off_mission_keeps_every_step(tape: Any, finished: Run, empty: Path) -> None:
    writer = RunWriter(empty, level="curves", parts=False)
    tape.play(writer, until=77, end=False)
    writer.close()
    run = Run.open(empty)
    assert not run.finished
    assert run.last_step == 77
    assert run.coverage.equals(finished.coverage.head(78))


def test_a_writer_lets_go_of_a_finished_mission() -> None:
    writer = RunWriter(level="curves", parts=False)
    mission = Mission(Scenario(robots=3, steps=3), recorder=writer)
    mission.run()
    judge = weakref.ref(mission.judge)
    gc.disable()  # Reference counts alone must free it: the collector comes late or never.
    try:
        del mission
        assert judge() is None
    finally:
        gc.enable()
    assert writer.run().finished


def test_recorders_of_curves_do_not_pay_for_poses(monkeypatch: pytest.MonkeyPatch) -> None:
    def asked(_: StepRecord) -> Any:
        raise AssertionError("a pose was made in vain")

    monkeypatch.setattr(StepRecord, "pose", property(asked))
    Mission(Scenario(robots=3, steps=3), recorder=RunWriter(level="curves")).run()
    with pytest.raises(AssertionError, match="in vain"):
        Mission(Scenario(robots=3, steps=3), recorder=RunWriter(level="full")).run()
