"""The measures of a mission: names, units, and which direction is better."""

from __future__ import annotations

from dataclasses import dataclass

__all__ = ["METRICS", "SHARES", "Metric"]

SHARES = (50, 75, 90, 95, 99)
"""Shares of the reachable area, in percent, for which times are taken."""


@dataclass(frozen=True)
class Metric:
    """One measure of a mission.

    Attributes:
        label: its name in figures and tables.
        unit: its unit; empty for a share or a count.
        better: 1 when more is better, -1 when less is, 0 when neither is.
    """

    label: str
    unit: str = ""
    better: int = 0

    @property
    def axis_label(self) -> str:
        """Label and unit, for the axis of a figure."""
        return f"{self.label} ({self.unit})" if self.unit else self.label


METRICS: dict[str, Metric] = {
    "explored_m2": Metric("explored area", "m²", 1),
    "explored_fraction": Metric("explored share of the reachable area", "", 1),
    "score": Metric("score of the task", "", 1),
    "auc_m2": Metric("explored area, mean over the mission", "m²", 1),
    "limit_share": Metric("share of the sensing limit", "", 1),
    "overlap_ratio": Metric("share of cells seen by more than one robot", "", -1),
    "distance_m": Metric("driven distance of all robots", "m", 0),
    "forward_share": Metric("share of steps forward", "", 1),
    "turn_share": Metric("share of steps turning", "", -1),
    "blocked_share": Metric("share of steps blocked", "", -1),
    "joins": Metric("teams joined"),
    "leaves": Metric("robots that left a team"),
    "charges": Metric("robots charged"),
    "stranded": Metric("robots stranded", "", -1),
    "decisions": Metric("destinations chosen"),
    "map_accuracy": Metric("share of known cells labelled right", "", 1),
    "step_ms": Metric("time of a step", "ms", -1),
    "decide_ms": Metric("time of a step's decisions", "ms", -1),
    **{f"time_to_{share}": Metric(f"time to {share} % explored", "steps", -1) for share in SHARES},
}
"""Columns of a study's table that a study can declare as its metric, see docs/studies.md."""
