"""One table says what is recorded: writer, reader, player, Rerun and documentation follow it."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import polars as pl
import pytest

from swarmscout import Run, RunWriter
from swarmscout.recording.table_page import page_with_tables
from swarmscout.recording.tables import TABLES, Column, schema_of
from swarmscout.viewing.player.recorded import steps_of
from swarmscout.viewing.player.step_range import robot_columns
from swarmscout.viewing.rerun_recording import _recorded

PAGE = Path(__file__).parents[2] / "docs" / "recordings.md"


def test_the_page_is_up_to_date() -> None:
    page = PAGE.read_text(encoding="utf-8")
    assert page == page_with_tables(page), (
        "python -m swarmscout.recording.table_page docs/recordings.md"
    )


def test_all_that_a_mission_reports_is_recorded(tape: Any) -> None:
    for record in tape.records:
        assert ["step", *record.coverage] == [c.name for c in TABLES["coverage"].columns]
        names = [f"{name}_s" for name in record.seconds]
        assert ["step", *names] == [c.name for c in TABLES["timing"].columns]


@pytest.fixture
def a_new_column() -> Iterator[str]:
    """What a new column per robot takes: a row here, and a property of StepRecord."""
    steps = TABLES["steps"]
    column = Column(
        "from_origin_m", "float64", "m", "distance from (0, 0)",
        lambda record: np.hypot(record.x_m, record.y_m),
    )  # fmt: skip
    TABLES["steps"] = replace(steps, columns=(*steps.columns, column))
    schema_of.cache_clear()
    yield column.name
    TABLES["steps"] = steps
    schema_of.cache_clear()


def test_a_new_column_is_a_row_of_the_table(a_new_column: str, tape: Any, empty: Path) -> None:
    writer = RunWriter(empty)
    tape.play(writer)
    run = Run.open(empty)
    expected = run.steps.select((pl.col("x_m") ** 2 + pl.col("y_m") ** 2).sqrt()).to_series()
    np.testing.assert_allclose(run.steps[a_new_column].to_numpy(), expected.to_numpy())
    shown = steps_of(run).columns[a_new_column]
    assert shown.shape == (run.last_step + 1, run.scenario.robots)
    np.testing.assert_allclose(shown.ravel() / 1000, expected.to_numpy(), atol=1e-3)
    assert a_new_column in {column.name for column in robot_columns()}
    assert (
        _recorded(run, 7)[a_new_column]
        == run.steps.filter(pl.col("step") == 7)[a_new_column].to_list()
    )
    assert f"| `{a_new_column}` | float64 | m | distance from (0, 0) |" in page_with_tables(
        PAGE.read_text(encoding="utf-8")
    )


def test_a_run_without_the_new_column_is_refused_in_one_line(
    finished: Run, a_new_column: str
) -> None:
    assert finished.path is not None
    with pytest.raises(Exception, match=f"column '{a_new_column}' of 'steps' is missing"):
        _ = Run.open(finished.path).steps
