"""What is known while a study runs: per compared value a mean, and the paired ratio so far."""

from __future__ import annotations

import math
from dataclasses import dataclass

from swarmscout.studies.plan import Planned
from swarmscout.studies.study import Study
from swarmscout.studies.worker import Outcome

__all__ = ["SoFar", "Tally"]


@dataclass
class Tally:
    """A running mean and variance (Welford): nothing grows with the number of values."""

    n: int = 0
    mean: float = 0.0
    squares: float = 0.0

    def add(self, value: float) -> None:
        """Count one value."""
        self.n += 1
        off = value - self.mean
        self.mean += off / self.n
        self.squares += off * (value - self.mean)

    @property
    def error(self) -> float:
        """Standard error of the mean; NaN below two values."""
        return math.sqrt(self.squares / (self.n - 1) / self.n) if self.n > 1 else math.nan


class SoFar:
    """Counts a study's missions as they end.

    Attributes:
        todo: missions that are to be run.
        ended: those that have come to an end, failed ones included.
        failed: those that failed.
        areas: by compared label, explored m².
        ratios: by compared label, explored area over that of the baseline with the same world, seed
            and settings. It is for watching: the report has the intervals that count.
    """

    def __init__(self, study: Study, todo: int) -> None:
        self.todo = todo
        self.ended = 0
        self.failed = 0
        labels = [str(label) for label in study.compared.labels]
        self.areas = {label: Tally() for label in labels}
        self.ratios = {label: Tally() for label in labels}
        self._axis = study.axes.index(study.compared)
        self._labels = labels
        self._baseline = labels.index(str(study.declared.compare.baseline))
        # Pairs of which something is still to come; missions of a pair are run close together.
        self._open: dict[tuple[tuple[int, ...], int], dict[int, float]] = {}

    def count(self, mission: Planned, outcome: Outcome) -> None:
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
