from __future__ import annotations

import time
from pathlib import Path
from typing import Any

import numpy as np
import polars as pl
import pytest

from swarmscout import Run, RunError, RunWriter, Scenario, record_mission
from swarmscout.core.enums import ACTIONS, EVENTS, MODES
from swarmscout.core.recorder import Decision
from swarmscout.recording.decisions import plain
from swarmscout.recording.row_buffer import Chunk
from swarmscout.recording.tables import LEVELS, OWN_MAPS, TABLES


def test_every_record_comes_back_as_it_was(finished: Run, tape: Any) -> None:
    by_step = finished.steps.partition_by("step", maintain_order=True)
    assert len(by_step) == len(tape.records) == finished.scenario.steps + 1
    for rows, record in zip(by_step, tape.records, strict=True):
        assert rows["step"].unique().to_list() == [record.step]
        assert rows["robot"].to_list() == list(range(finished.scenario.robots))
        np.testing.assert_array_equal(
            rows.select("x_m", "y_m", "heading_rad").to_numpy(), record.pose
        )
        np.testing.assert_array_equal(rows["charge"].to_numpy(), record.charge)
        np.testing.assert_array_equal(rows["alive"].to_numpy(), record.alive)
        assert rows["mode"].to_list() == [MODES[code] for code in record.mode]
        assert rows["action"].to_list() == [ACTIONS[code] for code in record.action]
        assert rows["contact"].to_list() == [("none", "wall", "robot")[c] for c in record.contact]
        for name in ("team", "leader", "desired", "destination"):
            np.testing.assert_array_equal(rows[name].to_numpy(), getattr(record, name))
        events = finished.events.filter(pl.col("step") == record.step)
        assert events["kind"].to_list() == [EVENTS[kind] for kind in record.events[:, 0]]
        assert events.select("robot", "other", "value").rows() == [
            tuple(int(value) for value in row) for row in record.events[:, 1:]
        ]
        changes = finished.map_changes.filter(pl.col("step") == record.step)
        np.testing.assert_array_equal(changes["cell"].to_numpy(), record.map_cells)
        np.testing.assert_array_equal(changes["log_odds"].to_numpy(), record.map_log_odds)
    assert finished.coverage.drop("step").to_dicts() == [plain(r.coverage) for r in tape.records]


def test_decisions_come_back_as_they_were(finished: Run, tape: Any) -> None:
    told = [decision for record in tape.records for decision in record.decisions]
    assert finished.decisions.height == len(told) > 0
    for row, decision in zip(finished.decisions.iter_rows(named=True), told, strict=True):
        assert row["leader"] == decision.leader
        assert row["cause"] == decision.cause
        assert row["reason"] == decision.reason
        if decision.cell is not None:
            assert finished.frame.unflat(row["cell"]) == tuple(decision.cell)
            assert (row["x_m"], row["y_m"]) == (decision.x_m, decision.y_m)


def test_a_decision_without_a_cell_has_nulls(tape: Any) -> None:
    record = tape.records[1]
    nothing = Decision(
        1, 7, 2, "none yet", "nearest", None, np.nan, np.nan, np.nan, 0, 0, 0, "none left",
        {"score": np.float64(0.5), "odd": np.nan, "cells": np.arange(2)},
    )  # fmt: skip
    chunk = Chunk(len(record.pose), 3, 10, TABLES)
    kept = record.decisions
    try:
        record.decisions = [nothing]
        chunk.add(record)
    finally:
        record.decisions = kept
    row = chunk.frames()["decisions"].row(0, named=True)
    assert [row[name] for name in ("cell", "x_m", "y_m", "distance_m")] == [None] * 4
    assert row["details"] == '{"cells": [0, 1], "odd": null, "score": 0.5}'


def test_memory_and_disk_hold_the_same(scenario: Scenario, finished: Run) -> None:
    run = record_mission(scenario)
    assert run.path is None
    assert run.finished
    assert run.summary == finished.summary
    for table in TABLES:
        if table != "timing":
            assert run.table(table).equals(finished.table(table)), table
            assert run.table(table).schema == finished.table(table).schema
    assert run.timing["step"].equals(finished.timing["step"])
    np.testing.assert_array_equal(run.map_at(), finished.map_at())
    np.testing.assert_array_equal(run.world().free, finished.world().free)


@pytest.mark.parametrize("level", LEVELS)
def test_a_level_keeps_its_tables_and_no_other(level: str, scenario: Scenario, empty: Path) -> None:
    run = record_mission(scenario, out=empty, record=level)
    assert {file.stem for file in empty.glob("*.parquet")} == (
        {*LEVELS[level]} - {"attempts", "timing", *OWN_MAPS}
    )
    assert {"scenario.toml", "run.json", "map.npz", "summary.json"} <= {
        file.name for file in empty.iterdir()
    }
    assert run.last_step == scenario.steps
    assert run.map_at().any()
    for table in TABLES:
        if table in ("attempts", *OWN_MAPS):
            continue  # Of missions that ask a language model, or in which maps differ.
        if table in LEVELS[level]:
            assert run.table(table).height
        else:
            with pytest.raises(RunError, match=f"'{table}' was not recorded.*'{level}'"):
                run.table(table)


def test_nothing_temporary_is_left(finished: Run) -> None:
    assert finished.path is not None
    left = {file.name for file in finished.path.iterdir() if file.name != "world"}
    assert left == {
        "scenario.toml", "run.json", "map.npz", "summary.json", "timing.zip",
        *(f"{table}.parquet" for table in TABLES if table not in ("attempts", "timing", *OWN_MAPS)),
    }  # fmt: skip


def test_an_interrupted_add_changes_nothing(tape: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    first, second = tape.records[1], tape.records[2]
    chunk, clean = (Chunk(len(first.pose), 5, 10, TABLES) for _ in range(2))
    chunk.add(first)

    class Torn:
        """A record that is interrupted when its last field is read."""

        def __getattr__(self, name: str) -> Any:
            if name == "seconds":
                raise KeyboardInterrupt
            return getattr(second, name)

    with pytest.raises(KeyboardInterrupt):
        chunk.add(Torn())  # type: ignore[arg-type]
    assert chunk.length == 1
    third = tape.records[3]
    for record in (third,):
        chunk.add(record)
    for record in (first, third):
        clean.add(record)
    for table, frame in clean.frames().items():
        assert chunk.frames()[table].equals(frame), table


def test_a_writer_keeps_one_mission(tape: Any) -> None:
    writer = RunWriter()
    with pytest.raises(RunError, match="no mission has begun"):
        writer.run()
    tape.play(writer)
    with pytest.raises(RunError, match="one mission"):
        writer.begin(tape.mission)
    writer.close()


def test_an_unknown_level_is_refused() -> None:
    with pytest.raises(RunError, match="'ful' is unknown: did you mean 'full'"):
        RunWriter(level="ful")


def test_recording_costs_little(tape: Any, tmp_path: Path) -> None:
    costs = []
    for attempt in range(5):
        began = time.process_time()
        tape.play(RunWriter(tmp_path / str(attempt)))
        costs.append(time.process_time() - began)
    # About 50 ms on a laptop's core; the limit leaves room for slow and busy machines.
    assert min(costs) < 0.4
