"""The tidy table of a study: a row per mission, a column per axis and per measured number."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from swarmscout.core.errors import RunError, StudyError
from swarmscout.recording.json_files import read_json
from swarmscout.recording.table_files import read_table
from swarmscout.studies.metrics import METRICS, SHARES
from swarmscout.studies.plan import Planned
from swarmscout.studies.sensing_limit import sensing_limit_m2

if TYPE_CHECKING:
    import polars as pl

    from swarmscout.studies.study import Study

__all__ = ["area_curve", "curves", "missions_table", "summary_columns"]

_SKIPPED = {"version", "rules_version", "robots", "seed", "world", "start", "selector", "teams"}
_OWN = {"area_at_step", "time_to"}


def missions_table(study: Study) -> pl.DataFrame:
    """Every mission of a study: ``status`` is ``finished``, ``failed`` or ``not run``.

    Raises:
        StudyError: a finished run is damaged.
    """
    import polars as pl

    finished, failed = study.folder.finished(), study.folder.failed()
    limits: dict[tuple[int, ...], float] = {}
    rows = []
    for mission in study.missions:
        row: dict[str, Any] = {
            "mission": mission.name,
            "status": "not run",
            **{a.name: a.values[i].label for a, i in zip(study.axes, mission.values, strict=True)},
            "world": mission.world,
            "world_seed": mission.world_seed,
            "seed": mission.seed,
            "robots": mission.robots,
            "planned_steps": mission.steps,
            "error": None,
        }
        if mission.name in finished:
            row["status"] = "finished"
            row |= _measured(study.folder.run(mission.name), mission, study.declared.record)
            if mission.values not in limits:
                limits[mission.values] = sensing_limit_m2(study.scenario(mission))
            row["limit_share"] = row["explored_m2"] / limits[mission.values]
        elif mission.name in failed:
            row |= {"status": "failed", "error": failed[mission.name].error}
        rows.append(row)
    frame = pl.DataFrame(rows, infer_schema_length=None)
    lacking = [pl.lit(None, dtype=pl.Float64).alias(k) for k in METRICS if k not in frame.columns]
    return frame.with_columns(lacking)


def curves(study: Study, frame: pl.DataFrame) -> NDArray[np.float32]:
    """float32[missions, steps + 1]: explored m² after each step, NaN for missions not finished.

    Missions of different lengths are as long as the longest: NaN behind their end.

    Args:
        study: the study.
        frame: its table, for the order of rows.

    Raises:
        StudyError: a finished run is damaged.
    """
    longest = max(mission.steps for mission in study.missions)
    found = np.full((frame.height, longest + 1), np.nan, dtype=np.float32)
    steps = {mission.name: mission.steps for mission in study.missions}
    for at, (name, status) in enumerate(frame.select("mission", "status").iter_rows()):
        if status == "finished":
            curve = area_curve(study.folder.run(name), steps[name], study.declared.record)
            found[at, : len(curve)] = curve
    return found


def area_curve(folder: Path, steps: int, record: str) -> NDArray[np.float64]:
    """float64[steps + 1]: explored m² of one run; what was explored when it ended stays explored.

    Args:
        folder: the run.
        steps: the mission's planned length.
        record: its recording level; of a ``summary`` the area is known every 50 steps.

    Raises:
        StudyError: the run is damaged.
    """
    if record == "summary":
        summary = _summary(folder)
        known = {0: 0.0, **{int(s): a for s, a in summary["area_at_step"].items()}}
        known[int(summary["steps"])] = summary["explored_m2"]
        at = sorted(known)
        between: NDArray[np.float64] = np.interp(
            np.arange(steps + 1), at, [known[step] for step in at]
        )
        return between
    try:
        area = read_table(folder, "coverage")["explored_m2"].to_numpy()
    except RunError as error:
        raise StudyError(str(error)) from None
    return np.concatenate([area, np.full(max(0, steps + 1 - len(area)), area[-1])])


def summary_columns(summary: Mapping[str, Any]) -> dict[str, Any]:
    """A run's summary as columns; what is nested gets dotted names, as ``llm.calls``."""
    times = summary.get("time_to", {})
    return {
        **dict(_scalars(summary)),
        **{f"time_to_{share}": times.get(f"{share}%") for share in SHARES},
    }


def _measured(folder: Path, mission: Planned, record: str) -> dict[str, Any]:
    summary = _summary(folder)
    row = summary_columns(summary)
    row["auc_m2"] = float(area_curve(folder, mission.steps, record).mean())
    if record != "summary":
        try:
            timing = read_table(folder, "timing")
            row["decisions"] = read_table(folder, "decisions").height
        except RunError as error:
            raise StudyError(str(error)) from None
        # Some steps compile or load something: of all steps the median tells what one costs. Few
        # steps decide much, so of decisions it is the mean, without the first step.
        ways = (("step_s", "step_ms", np.median), ("decide_s", "decide_ms", np.mean))
        for column, name, middle in ways:
            if column in timing.columns and timing.height > 1:
                row[name] = 1e3 * float(middle(timing[column].to_numpy()[1:]))
    return row


def _summary(folder: Path) -> dict[str, Any]:
    file = folder / "summary.json"
    try:
        data = read_json(file)
    except RunError:
        data = None
    if data is None:
        raise StudyError(
            f"'{file}' is missing or damaged: remove '{folder}' and run the study again"
        )
    return data


def _scalars(values: Mapping[str, Any], prefix: str = "") -> Iterator[tuple[str, Any]]:
    for key, value in values.items():
        if not prefix and (key in _SKIPPED or key in _OWN):
            continue
        if isinstance(value, Mapping):
            yield from _scalars(value, f"{prefix}{key}.")
        elif value is None or isinstance(value, str | bool | int | float):
            yield prefix + key, value
