"""Checks of a table that was read: that its values can be those of a run."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from swarmscout.core.errors import RunError
from swarmscout.recording.tables import TABLES

if TYPE_CHECKING:
    import polars as pl

__all__ = ["check_number", "fault_of"]


def fault_of(frame: pl.DataFrame, table: str, robots: int, cells: int) -> str | None:
    """What is impossible in a table, in a few words; None when nothing is.

    Args:
        frame: the table, with the columns of :data:`swarmscout.recording.tables.TABLES`.
        table: its name.
        robots: N, the number of robots.
        cells: number of cells of the map.
    """
    limits = {"robot": (0, robots), "cell": (0, cells), "cell?": (-1, cells), "step": (0, None)}
    for column in TABLES[table].columns:
        series = frame[column.name]
        if series.null_count() and not column.unit.endswith("?"):
            return f"column '{column.name}' has empty values"
        if column.unit not in limits or series.null_count() == len(series):
            continue
        low, high = limits[column.unit]
        least, most = int(series.min()), int(series.max())  # type: ignore[arg-type]
        if least < low or (high is not None and most >= high):
            wrong = least if least < low else most
            kind = column.unit.removesuffix("?")
            return f"column '{column.name}' has the value {wrong}, which is not a {kind}"
    return _order(frame, table, robots)


def _order(frame: pl.DataFrame, table: str, robots: int) -> str | None:
    step = frame["step"].to_numpy()
    if (np.diff(step) < 0).any():
        return "its steps are not in order"
    if table in ("coverage", "timing", "steps"):
        each = robots if table == "steps" else 1
        if len(step) % each or (step != np.arange(len(step)) // each).any():
            return "steps or robots are missing"
    if table == "steps" and (frame["robot"].to_numpy() != np.arange(len(step)) % robots).any():
        return "robots are missing"
    return None


def check_number(noun: str, number: object, last: int) -> None:
    """Check that a step or a robot is one of 0 … last.

    Raises:
        RunError: it is not.
    """
    if isinstance(number, bool) or not isinstance(number, int | np.integer):
        raise RunError(f"{noun} = {number!r}: expected a whole number, 0 to {last}")
    if not 0 <= number <= last:
        raise RunError(f"there is no {noun} {number}: the run has {noun}s 0 to {last}")
