"""Confidence intervals of the tables."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy import stats


def interval(values: NDArray[np.float64]) -> tuple[float, float]:
    """95 % confidence interval of the mean: BCa bootstrap from 20 values on, Student's t below."""
    if np.ptp(values) == 0.0:
        return float(values[0]), float(values[0])
    if len(values) >= 20:
        rng = np.random.default_rng(0)
        low, high = stats.bootstrap((values,), np.mean, method="BCa", rng=rng).confidence_interval
        return float(low), float(high)
    low, high = stats.t.interval(0.95, len(values) - 1, loc=values.mean(), scale=stats.sem(values))
    return float(low), float(high)
