"""What a study can show, from its design alone: checked before anything is computed.

The smallest difference that a design shows with 80 % power follows from Student's paired t test,
corrected for the number of comparisons (Bonferroni), under an assumed scatter of differences.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

from scipy import stats

from swarmscout.studies.intervals import ALPHA, smallest_p

if TYPE_CHECKING:
    from swarmscout.studies.study import Study

__all__ = ["Design", "design_of"]

SCATTER_OF_WORLDS = 0.12
SCATTER_OF_SEEDS = 0.10
"""Assumed standard deviations of a pair's difference, as shares of the baseline's value.

They are typical of explored area in the committed studies (docs/results.md).
"""

_POWER = 0.8
_COARSE = 0.5


@dataclass(frozen=True)
class Design:
    """The size of a study.

    Attributes:
        worlds: number of worlds.
        trials: missions of each combination in each world.
        comparisons: number of comparisons with the baseline.
    """

    worlds: int
    trials: int
    comparisons: int

    @property
    def units(self) -> int:
        """Number of independent units: worlds, or seeds in a single world."""
        return self.worlds if self.worlds > 1 else self.trials

    @property
    def unit(self) -> str:
        """What the units are."""
        return "worlds" if self.worlds > 1 else "seeds"

    @property
    def scatter(self) -> float:
        """Assumed standard deviation of the units' differences, as a share of the baseline."""
        if self.worlds == 1:
            return SCATTER_OF_SEEDS
        return math.hypot(SCATTER_OF_WORLDS, SCATTER_OF_SEEDS / math.sqrt(self.trials))

    @property
    def can_show(self) -> bool:
        """Whether any difference at all could reach p < 0.05."""
        return self.comparisons * smallest_p(self.units) < ALPHA

    @property
    def units_needed(self) -> int | None:
        """The fewest units that can show a difference; None where only fewer comparisons help."""
        enough = (n for n in range(2, 65) if self.comparisons * smallest_p(n) < ALPHA)
        return next(enough, None)

    @property
    def detectable(self) -> float:
        """The smallest difference shown with 80 % power, as a share of the baseline's value."""
        if self.units < 2:
            return math.inf
        tail = ALPHA / 2.0 / self.comparisons
        n = self.units
        factor = stats.t.isf(tail, n - 1) + stats.t.ppf(_POWER, n - 1)
        return float(factor) * self.scatter / math.sqrt(n)

    @property
    def is_weak(self) -> bool:
        """Whether the design shows nothing, or only differences of more than half the baseline."""
        return not self.can_show or self.detectable > _COARSE

    def describe(self) -> str:
        """What the design can show, in one or two sentences."""
        count = f"{self.comparisons} comparison{'s' if self.comparisons > 1 else ''}"
        units = f"{self.units} {self.unit if self.units > 1 else self.unit[:-1]}"
        if not self.can_show:
            text = f"{units} and {count} cannot show any difference: no p can come below 0.05"
            needed = self.units_needed
            return f"{text}. " + (
                "Make fewer comparisons."
                if needed is None
                else f"At least {needed} {self.unit} are needed ({self._how(needed)})."
            )
        return (
            f"with {units} and {count}, differences above about {100 * self.detectable:.0f} % of "
            f"the baseline can be shown (80 % power, if differences scatter by "
            f"{100 * self.scatter:.0f} %)"
        )

    def _how(self, needed: int) -> str:
        if self.unit == "worlds":
            return f"world_seed = [0, …, {needed - 1}]"
        return f"trials = {needed}, or better an axis world_seed = [0, …, {needed - 1}]"


def design_of(study: Study) -> Design:
    """The design of a study.

    Raises:
        StudyError: a combination of values is impossible.
    """
    keys = [key for key in ("world", "world_seed") if key not in study.compared.keys]
    worlds = {tuple(getattr(mission, key) for key in keys) for mission in study.missions}
    settings = math.prod(len(axis.values) for axis in study.settings)
    return Design(
        worlds=len(worlds),
        trials=study.declared.trials,
        comparisons=(len(study.compared.values) - 1) * settings,
    )
