"""Counts and means while a study runs."""

from __future__ import annotations

import math
from dataclasses import dataclass

from swarmscout.studies.plan import PlannedMission
from swarmscout.studies.study import Study
from swarmscout.studies.worker import Outcome

__all__ = ["RunningMean", "RunningTotals"]


@dataclass
class RunningMean:
    """A mean and variance in constant memory.

    Source: Welford 1962.
    """

    n: int = 0
    mean: float = 0.0
    squares: float = 0.0

    def add(self, value: float) -> None:
        """Add one value."""
        self.n += 1
        difference = value - self.mean
        self.mean += difference / self.n
        self.squares += difference * (value - self.mean)

    @property
    def error(self) -> float:
        """Standard error of the mean; NaN below two values."""
        return math.sqrt(self.squares / (self.n - 1) / self.n) if self.n > 1 else math.nan


class RunningTotals:
    """Counts a study's missions as they end.

    Attributes:
        todo: number of missions to run.
        ended: number of missions that have ended, failed ones included.
        failed: number of missions that failed.
        areas: explored m² by compared label.
        ratios: by compared label, explored area over that of the baseline with the same world, seed
            and settings. They are for progress displays; the report has intervals.
    """

    def __init__(self, study: Study, todo: int) -> None:
        self.todo = todo
        self.ended = 0
        self.failed = 0
        labels = [str(label) for label in study.compared.labels]
        self.areas = {label: RunningMean() for label in labels}
        self.ratios = {label: RunningMean() for label in labels}
        self._axis = study.axes.index(study.compared)
        self._labels = labels
        self._baseline = labels.index(str(study.declared.compare.baseline))
        # Incomplete pairs only: missions of a pair run close together, so there are few.
        self._open: dict[tuple[tuple[int, ...], int], dict[int, float]] = {}

    def count(self, mission: PlannedMission, outcome: Outcome) -> None:
        """Count one mission that has ended."""
        self.ended += 1
        value = mission.values[self._axis]
        if outcome.error is not None:
            self.failed += 1
        elif math.isfinite(outcome.explored_m2):
            self.areas[self._labels[value]].add(outcome.explored_m2)
        others = mission.values[: self._axis] + mission.values[self._axis + 1 :]
        areas = self._open.setdefault((others, mission.seed), {})
        areas[value] = math.nan if outcome.error is not None else outcome.explored_m2
        if len(areas) == len(self._labels):
            del self._open[others, mission.seed]
            base = areas[self._baseline]
            for index, area in areas.items():
                if math.isfinite(area) and math.isfinite(base) and base > 0.0:
                    self.ratios[self._labels[index]].add(area / base)
