"""Which combination is best: all combinations of a sweep ranked, each beside the best in pairs."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from swarmscout.studies.comparison import Arm, Label, arms_of, pair_keys
from swarmscout.studies.intervals import ALPHA, Estimate, by_unit, gap_to_best
from swarmscout.studies.metrics import METRICS

if TYPE_CHECKING:
    import polars as pl

    from swarmscout.studies.study import Study

__all__ = ["Rank", "Ranking", "rank_combinations"]


@dataclass(frozen=True)
class Rank:
    """One combination of values.

    Attributes:
        labels: its value on each axis of :attr:`Ranking.axes`.
        missions: number of finished missions.
        mean: the metric's mean over units.
        gap: how far it lies behind the best, in pairs of the same world and seed, with an interval
            that holds for all combinations together. NaN for the best.
        p: that it is as good as the best, corrected for all combinations. NaN for the best.
    """

    labels: tuple[Label, ...]
    missions: int
    mean: Estimate
    gap: Estimate
    p: float

    @property
    def may_be_best(self) -> bool:
        """Whether the study leaves open that it is the best."""
        return not self.p < ALPHA


@dataclass(frozen=True)
class Ranking:
    """All combinations, the best first.

    Attributes:
        axes: names of the axes that are combined: the compared one and the settings.
        ranks: the combinations.
    """

    axes: tuple[str, ...]
    ranks: tuple[Rank, ...]

    @property
    def candidates(self) -> list[Rank]:
        """The combinations that may be the best; the true best is among them with 95 %."""
        return [rank for rank in self.ranks if rank.may_be_best]

    @property
    def is_tested(self) -> bool:
        """Whether there are pairs enough to say anything of gaps."""
        return all(math.isfinite(rank.p) for rank in self.ranks[1:])


def rank_combinations(study: Study, frame: pl.DataFrame) -> Ranking | None:
    """Rank a study's combinations by the declared metric.

    Args:
        study: the study.
        frame: its table.

    Returns:
        The ranking; None if the metric has no better direction, worlds are compared, or fewer than
        two combinations have finished missions.
    """
    sign = METRICS[study.declared.metric].better
    arms = [arm for arm in arms_of(study, frame, study.declared.metric) if len(arm.values)]
    if sign == 0 or study.compared.is_place or len(arms) < 2:
        return None
    arms.sort(key=lambda arm: -sign * arm.mean.value)
    keys = pair_keys(study, frame)
    best = _by_pair(arms[0], keys)
    ranks = []
    for arm in arms:
        mine = _by_pair(arm, keys)
        both = [key for key in mine if key in best]
        gap, p = Estimate(math.nan), math.nan
        if arm is not arms[0]:
            gaps = np.array([sign * (best[key][0] - mine[key][0]) for key in both])
            units = [float(unit.mean()) for unit in by_unit(gaps, [mine[key][1] for key in both])]
            gap, p = gap_to_best(units, len(arms) - 1)
        labels = (arm.label, *arm.setting)
        ranks.append(Rank(labels, len(arm.values), arm.mean, gap, p))
    axes = (study.compared.name, *study.setting_names)
    return Ranking(axes, tuple(ranks))


def _by_pair(arm: Arm, keys: list[object]) -> dict[object, tuple[float, object]]:
    """Value and world of each mission, by what the missions of a pair share."""
    rows = arm.rows.tolist()
    places = zip(rows, arm.values.tolist(), arm.worlds, strict=True)
    return {keys[row]: (value, world) for row, value, world in places}
