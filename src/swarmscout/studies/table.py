"""The tidy table of a study: a row per mission, a column per axis and per measured number."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from swarmscout.core.errors import RunError, StudyError
from swarmscout.mission.scenario import Scenario
from swarmscout.recording.json_files import SUMMARY, read_json
from swarmscout.recording.table_files import read_table
from swarmscout.studies.metrics import METRICS, SHARES
from swarmscout.studies.plan import PlannedMission
from swarmscout.studies.sensing_limit import sensing_limit_m2
from swarmscout.studies.study_file import Axis
from swarmscout.studies.study_folder import StudyFolder

if TYPE_CHECKING:
    import polars as pl

__all__ = ["area_curve", "area_curves", "missions_table", "summary_columns"]

# Columns of the plan, or of tables of their own: not taken from summaries.
_NOT_MEASURED = {
    "version", "rules_version", "robots", "seed", "world", "start", "task", "selector", "teams",
    "area_at_step", "time_to",
}  # fmt: skip


def missions_table(
    missions: Sequence[PlannedMission],
    axes: Sequence[Axis],
    folder: StudyFolder,
    record: str,
    scenario: Callable[[PlannedMission], Scenario],
) -> pl.DataFrame:
    """A row per mission; its ``status`` is ``finished``, ``failed`` or ``not run``.

    Args:
        missions: the planned missions, in the order of rows.
        axes: the study's axes, a column each.
        folder: where runs and failures lie.
        record: the recording level of the runs.
        scenario: gives the resolved scenario of a mission.

    Raises:
        StudyError: a finished run is damaged.
    """
    import polars as pl

    finished, failed = folder.finished(), folder.failed()
    limits: dict[tuple[int, ...], float] = {}
    rows = []
    for mission in missions:
        row: dict[str, Any] = {
            "mission": mission.name,
            "status": "not run",
            **{a.name: a.values[i].label for a, i in zip(axes, mission.values, strict=True)},
            "world": mission.world,
            "world_seed": mission.world_seed,
            "seed": mission.seed,
            "robots": mission.robots,
            "planned_steps": mission.steps,
            "error": None,
        }
        if mission.name in finished:
            row["status"] = "finished"
            row |= _measured(folder.run(mission.name), mission, record)
            if mission.values not in limits:
                limits[mission.values] = sensing_limit_m2(scenario(mission))
            row["limit_share"] = row["explored_m2"] / limits[mission.values]
        elif mission.name in failed:
            row |= {"status": "failed", "error": failed[mission.name].error}
        rows.append(row)
    frame = pl.DataFrame(rows, infer_schema_length=None)
    lacking = [pl.lit(None, dtype=pl.Float64).alias(k) for k in METRICS if k not in frame.columns]
    return frame.with_columns(lacking)


def area_curves(
    missions: Sequence[PlannedMission], folder: StudyFolder, record: str
) -> NDArray[np.float32]:
    """float32[missions, steps + 1]: explored m² after each step, NaN for missions not finished.

    Rows are as long as the longest mission's: NaN after the end of a shorter one.

    Args:
        missions: the planned missions, in the order of rows.
        folder: where runs lie.
        record: the recording level of the runs.

    Raises:
        StudyError: a finished run is damaged.
    """
    longest = max(mission.steps for mission in missions)
    found = np.full((len(missions), longest + 1), np.nan, dtype=np.float32)
    finished = folder.finished()
    for row, mission in zip(found, missions, strict=True):
        if mission.name in finished:
            curve = area_curve(folder.run(mission.name), mission.steps, record)
            row[: len(curve)] = curve
    return found


def area_curve(folder: Path, steps: int, record: str) -> NDArray[np.float64]:
    """float64[steps + 1]: explored m² of one run; a mission that ended early keeps its last area.

    Args:
        folder: the run.
        steps: the mission's planned length.
        record: its recording level. A ``summary`` holds the area every 50 steps; values between
            are interpolated.

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
    """A run's summary as columns; nested values get dotted names, such as ``llm.calls``."""
    times = summary.get("time_to", {})
    return {
        **dict(_scalars(summary)),
        **{f"time_to_{share}": times.get(f"{share}%") for share in SHARES},
    }


def _measured(folder: Path, mission: PlannedMission, record: str) -> dict[str, Any]:
    summary = _summary(folder)
    row = summary_columns(summary)
    row["auc_m2"] = float(area_curve(folder, mission.steps, record).mean())
    if record != "summary":
        try:
            timing = read_table(folder, "timing")
            row["decisions"] = read_table(folder, "decisions").height
        except RunError as error:
            raise StudyError(str(error)) from None
        # Some steps compile or load code, so the median gives the cost of a step. Few steps decide
        # much, so decisions take the mean. The first step is left out of both.
        ways = (("step_s", "step_ms", np.median), ("decide_s", "decide_ms", np.mean))
        for column, name, middle in ways:
            if column in timing.columns and timing.height > 1:
                row[name] = 1e3 * float(middle(timing[column].to_numpy()[1:]))
    return row


def _summary(folder: Path) -> dict[str, Any]:
    file = folder / SUMMARY
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
        if not prefix and key in _NOT_MEASURED:
            continue
        if isinstance(value, Mapping):
            yield from _scalars(value, f"{prefix}{key}.")
        elif value is None or isinstance(value, str | bool | int | float):
            yield prefix + key, value
