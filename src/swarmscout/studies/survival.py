"""Time to a share of the reachable area, with missions that did not reach it as censored.

Medians are Kaplan-Meier's; the mean is restricted to the mission's length.
"""

from __future__ import annotations

import warnings
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import stats

from swarmscout.studies.intervals import Estimate, mean_interval

__all__ = ["Times", "times_to"]


@dataclass(frozen=True)
class Times:
    """Time to one share of the reachable area, over missions.

    Attributes:
        reached: number of missions that reached the share.
        n: number of missions.
        median: steps until half of all missions reach it; None when fewer than half do.
        median_low: lower end of its 95 % interval, from the survival curve's band; None when open.
        median_high: upper end of that interval; None when open.
        restricted: mean of the steps, with the mission's length for missions that did not reach it.
    """

    reached: int
    n: int
    median: float | None
    median_low: float | None
    median_high: float | None
    restricted: Estimate


def times_to(steps: NDArray[np.float64], longest: NDArray[np.float64]) -> Times:
    """Summarize times of which some are censored.

    Args:
        steps: float64[n], the first step with that share explored; NaN where it was not reached.
        longest: float64[n], the missions' lengths.
    """
    missed = np.isnan(steps)
    known = np.where(missed, longest, steps)
    median: list[float | None] = [None, None, None]
    if len(steps) and not missed.all():
        data = stats.CensoredData(uncensored=known[~missed], right=known[missed])
        survival: Any = stats.ecdf(data).sf
        with warnings.catch_warnings(), np.errstate(all="ignore"):
            # The band is not defined before the first and after the last observation.
            warnings.simplefilter("ignore", RuntimeWarning)
            band = survival.confidence_interval(method="log-log")
        for at, curve in enumerate((survival, band.low, band.high)):
            below = np.flatnonzero(np.nan_to_num(curve.probabilities, nan=1.0) <= 0.5)
            median[at] = float(curve.quantiles[below[0]]) if len(below) else None
    return Times(
        reached=int((~missed).sum()),
        n=len(steps),
        median=median[0],
        median_low=median[1],
        median_high=median[2],
        restricted=mean_interval(known),
    )
