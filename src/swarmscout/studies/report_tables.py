"""Tables of the measures besides the declared metric."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from typing import TYPE_CHECKING

import numpy as np

from swarmscout.studies.comparison import Arm, arms_of
from swarmscout.studies.formatting import code, with_interval
from swarmscout.studies.intervals import mean_over_units
from swarmscout.studies.metrics import METRICS, SHARES
from swarmscout.studies.report_elements import Block, Heading, Table, Text
from swarmscout.studies.survival import times_to

if TYPE_CHECKING:
    import polars as pl

    from swarmscout.studies.study import Study

__all__ = ["arms_table", "language_model_table", "measures_table", "times_table"]

_SHOWN = (
    "explored_m2", "explored_fraction", "auc_m2", "limit_share", "overlap_ratio", "distance_m",
    "turn_share", "blocked_share", "decisions", "charges", "stranded", "map_accuracy",
    "step_ms", "decide_ms",
)  # fmt: skip


_ACROSS = 5
"""Number of measures in one table."""


def arms_table(
    study: Study, heads: Sequence[str], rows: Iterable[tuple[Arm, Sequence[str]]]
) -> Table:
    """A table with a row per arm, which begins with the arm's setting and compared value.

    Args:
        study: the study.
        heads: heads of the further columns.
        rows: each arm with its further cells.
    """
    settings = study.setting_names
    return Table(
        [*settings, study.compared.name, *heads],
        [[*map(code, arm.setting), code(arm.label), *cells] for arm, cells in rows],
        numbers=len(settings) + 1,
    )


def measures_table(study: Study, frame: pl.DataFrame) -> Iterator[Block]:
    """Every other measure with its interval, untested since it was not declared."""
    yield Heading("Other measures", 3)
    yield Text(
        "Means with 95 % intervals. These measures were not declared, so nothing is tested. Times "
        "are wall times, possibly on a busy machine: compare them within this table only."
    )
    columns = {
        metric: arms_of(study, frame, metric)
        for metric in _SHOWN
        if frame[metric].is_not_null().any() and metric != study.declared.metric
    }
    names = list(columns)
    for begin in range(0, len(names), _ACROSS):
        shown = names[begin : begin + _ACROSS]
        rows = [
            (arm, [with_interval(columns[metric][at].mean) for metric in shown])
            for at, arm in enumerate(columns[shown[0]])
        ]
        heads = [METRICS[metric].axis_label for metric in shown]
        yield arms_table(study, heads, rows)


def times_table(study: Study, frame: pl.DataFrame) -> Iterator[Block]:
    """Time to shares of the reachable area."""
    if not frame["time_to_50"].is_not_null().any():
        yield Heading("Time to a share of the reachable area", 3)
        yield Text("No mission explored half of the reachable area.")
        return
    yield Heading("Time to a share of the reachable area", 3)
    yield Text(
        "Median steps (Kaplan-Meier: missions that did not reach the share are censored at their "
        "length) with 95 % intervals, and the number of missions that reached it."
    )
    rows = [
        (arm, [_time_cell(frame, arm, share) for share in SHARES])
        for arm in arms_of(study, frame, "explored_m2")
    ]
    heads = [f"{share} %" for share in SHARES]
    yield arms_table(study, heads, rows)


def _time_cell(frame: pl.DataFrame, arm: Arm, share: int) -> str:
    rows = arm.rows
    steps = np.array(frame[f"time_to_{share}"].gather(rows).to_list(), dtype=np.float64)
    longest = np.array(frame["planned_steps"].gather(rows).to_list(), dtype=np.float64)
    found = times_to(steps, longest)
    if not found.n or not found.reached:
        return f"0 of {found.n}"
    if found.median is None:
        return f"> {longest.max():.0f}; {found.reached} of {found.n}"
    low = f"{found.median_low:.0f}" if found.median_low is not None else "…"
    high = f"{found.median_high:.0f}" if found.median_high is not None else "…"
    return f"{found.median:.0f} [{low}, {high}]; {found.reached} of {found.n}"


def language_model_table(study: Study, frame: pl.DataFrame) -> Iterator[Block]:
    """What language models did and cost (columns ``llm.…``), if any was asked."""
    columns = [name for name in frame.columns if name.startswith("llm.")]
    columns = [name for name in columns if frame[name].dtype.is_numeric()]
    if not columns:
        return
    yield Heading("Language models", 3)
    yield Text("Totals of a mission: means over missions with 95 % intervals.")
    rows = []
    for arm in arms_of(study, frame, "explored_m2"):
        chosen = frame[arm.rows.tolist()]
        if not any(chosen[name].is_not_null().any() for name in columns):
            continue
        cells = []
        for name in columns:
            values = np.array(chosen[name].to_list(), dtype=np.float64)
            known = np.isfinite(values)
            worlds = [w for w, k in zip(arm.worlds, known, strict=True) if k]
            cells.append(with_interval(mean_over_units(values[known], worlds)))
        rows.append((arm, cells))
    heads = [name.removeprefix("llm.").replace("_", " ").replace(".", ": ") for name in columns]
    yield arms_table(study, heads, rows)
