"""Estimates with 95 % intervals: every interval and every test of the project.

Units are what was drawn independently: worlds when there is more than one, since missions in one
world resemble each other, and seeds otherwise. Each world counts as one value, the mean over its
missions. Intervals are BCa bootstraps (Efron 1987) from 20 units on, and Student's t below that,
where a bootstrap covers too little. Below 10 units reports warn.
"""

from __future__ import annotations

import math
import warnings
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import stats

__all__ = [
    "ALPHA",
    "FEW_UNITS",
    "LEVEL",
    "MANY_UNITS",
    "Estimate",
    "by_unit",
    "gap_to_best",
    "holm",
    "interquartile_mean",
    "interquartile_value",
    "mean_interval",
    "mean_over_units",
    "ratio_over_units",
    "share_interval",
    "sign_flip_p",
    "smallest_p",
]

LEVEL = 0.95
ALPHA = 0.05
"""Adjusted p-values below this count as evidence."""

MANY_UNITS = 20
"""From this number of units on an interval is a bootstrap."""

FEW_UNITS = 10
"""Below this number of units an interval comes with a warning."""

_RESAMPLES = 9999
_BATCH_VALUES = 4_000_000
_NOWHERE = float("nan")

Values = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Estimate:
    """A value and an interval that covers the true value in 95 of 100 studies like this one.

    Attributes:
        value: the estimate; NaN without data.
        low: lower end; NaN when there are too few units.
        high: upper end.
        units: number of independent units.
        method: ``BCa``, ``t``, ``Wilson``, or empty without an interval.
    """

    value: float
    low: float = _NOWHERE
    high: float = _NOWHERE
    units: int = 0
    method: str = ""

    def __contains__(self, value: float) -> bool:
        """Whether a value lies in the interval."""
        return self.low <= value <= self.high


def mean_interval(values: Sequence[float] | Values) -> Estimate:
    """The mean of independent values, and its interval.

    Args:
        values: one per unit, finite.
    """
    x = np.asarray(values, dtype=np.float64)
    if len(x) == 0:
        return Estimate(_NOWHERE)
    if len(x) == 1:
        return Estimate(float(x[0]), units=1)
    mean = float(x.mean())
    if np.ptp(x) == 0.0:
        return Estimate(mean, mean, mean, len(x), "t")
    if len(x) >= MANY_UNITS:
        low, high = _bootstrap(x, np.mean)
        if math.isfinite(low) and math.isfinite(high):
            return Estimate(mean, low, high, len(x), "BCa")
    half = float(stats.t.ppf(0.5 + LEVEL / 2, len(x) - 1) * stats.sem(x))
    return Estimate(mean, mean - half, mean + half, len(x), "t")


def interquartile_mean(values: Sequence[float] | Values) -> Estimate:
    """The mean of the middle half of independent values, and its interval.

    Below 20 values it is the t interval of a trimmed mean by its winsorized variance.

    Source: Agarwal et al. 2021 (the interquartile mean for comparisons); Tukey and McLaughlin 1963.
    """
    x = np.sort(np.asarray(values, dtype=np.float64))
    n = len(x)
    if n < 4:
        return mean_interval(x)
    value = interquartile_value(x)
    if n >= MANY_UNITS and np.ptp(x) > 0.0:
        low, high = _bootstrap(x, _trimmed)
        if math.isfinite(low) and math.isfinite(high):
            return Estimate(value, low, high, n, "BCa")
    cut = int(0.25 * n)
    winsorized = np.clip(x, x[cut], x[n - 1 - cut])
    kept = n - 2 * cut
    error = float(winsorized.std(ddof=1)) * math.sqrt(n) / kept
    half = float(stats.t.ppf(0.5 + LEVEL / 2, kept - 1)) * error
    return Estimate(value, value - half, value + half, n, "t")


def interquartile_value(values: Values) -> float:
    """The mean of the middle half, without an interval."""
    return float(stats.trim_mean(values, 0.25))


def share_interval(won: float, n: int) -> Estimate:
    """A share of independent trials, and Wilson's interval.

    Args:
        won: number of successful trials; a tie counts half.
        n: number of trials.
    """
    if n == 0:
        return Estimate(_NOWHERE)
    z = float(stats.norm.ppf(0.5 + LEVEL / 2))
    p = won / n
    middle = (p + z * z / (2 * n)) / (1 + z * z / n)
    half = z * math.sqrt(p * (1 - p) / n + z * z / (4 * n * n)) / (1 + z * z / n)
    return Estimate(p, max(0.0, middle - half), min(1.0, middle + half), n, "Wilson")


def sign_flip_p(differences: Sequence[float] | Values) -> float:
    """Two-sided p of the paired sign-flip test of a mean difference of 0.

    All sign patterns are tried for up to 13 differences, and 9,999 random ones for more.

    Args:
        differences: one per unit.

    Returns:
        p; NaN below two differences. It is at least :func:`smallest_p` of their number.
    """
    d = np.asarray(differences, dtype=np.float64)
    if len(d) < 2:
        return _NOWHERE
    if not d.any():
        return 1.0
    batch = max(1, _BATCH_VALUES // len(d))
    found = stats.permutation_test(
        (d,), np.mean, permutation_type="samples", vectorized=True, n_resamples=_RESAMPLES,
        batch=batch, rng=np.random.default_rng(0),
    )  # fmt: skip
    return float(found.pvalue)


def smallest_p(units: int) -> float:
    """The smallest p that :func:`sign_flip_p` can give for a number of units."""
    return max(2.0 / 2.0**units, 2.0 / (_RESAMPLES + 1)) if units > 1 else 1.0


def gap_to_best(gaps: Sequence[float] | Values, comparisons: int) -> tuple[Estimate, float]:
    """How far an alternative lies behind the best of several, corrected for their number.

    An alternative whose p is below 0.05 is not the true best, with at most 5 % error over all
    alternatives together. This holds although the best was picked from the same data.

    Args:
        gaps: the best's values less the alternative's, one per unit, in pairs.
        comparisons: number of alternatives.

    Returns:
        The mean gap with its simultaneous interval, which lies above 0 exactly if p < 0.05; and the
        one-sided p of Student's paired t test, times `comparisons` (Bonferroni); NaN below two
        units.

    Source: Gupta 1965 (subset selection); Hsu 1996, "Multiple comparisons", chapter 4.
    """
    x = np.asarray(gaps, dtype=np.float64)
    n = len(x)
    if n < 2:
        return Estimate(float(x.mean()) if n else _NOWHERE, units=n), _NOWHERE
    mean = float(x.mean())
    if np.ptp(x) == 0.0:
        # Equal gaps say nothing of how gaps vary: the sign test takes over.
        p = 0.5**n if mean > 0.0 else 1.0
        return Estimate(mean, mean, mean, n, "t"), min(1.0, comparisons * p)
    error = float(stats.sem(x))
    half = float(stats.t.isf((1.0 - LEVEL) / comparisons, n - 1)) * error
    p = float(stats.t.sf(mean / error, n - 1))
    return Estimate(mean, mean - half, mean + half, n, "t"), min(1.0, comparisons * p)


def holm(p_values: Sequence[float]) -> list[float]:
    """p-values of several comparisons, adjusted for the chance of any false finding.

    Args:
        p_values: one per comparison; NaN stays NaN and does not count.

    Source: Holm 1979.
    """
    adjusted = [_NOWHERE] * len(p_values)
    counted = [i for i, p in enumerate(p_values) if not math.isnan(p)]
    worst = 0.0
    for rank, i in enumerate(sorted(counted, key=lambda i: p_values[i])):
        worst = max(worst, min(1.0, (len(counted) - rank) * p_values[i]))
        adjusted[i] = worst
    return adjusted


def by_unit(values: Values, worlds: Sequence[object]) -> list[Values]:
    """Values grouped by independent unit.

    Args:
        values: one per mission or pair.
        worlds: the world of each value.

    Returns:
        An array per world; with a single world, an array of one value per mission or pair.
    """
    groups: dict[object, list[float]] = {}
    for value, world in zip(values.tolist(), worlds, strict=True):
        groups.setdefault(world, []).append(value)
    if len(groups) > 1:
        return [np.array(group) for group in groups.values()]
    return [np.array([value]) for group in groups.values() for value in group]


def mean_over_units(values: Values, worlds: Sequence[object]) -> Estimate:
    """The mean of values of missions or pairs, each unit counting once.

    Args:
        values: one per mission or pair.
        worlds: the world of each value.
    """
    return mean_interval([float(unit.mean()) for unit in by_unit(values, worlds)])


def ratio_over_units(values: Values, base: Values, worlds: Sequence[object]) -> Estimate:
    """The mean of pairs' ratios, each unit counting once; NaN where some `base` is not above 0.

    Args:
        values, base: one each per pair.
        worlds: the world of each pair.
    """
    if not len(base) or not (base > 0.0).all():
        return Estimate(_NOWHERE)
    return mean_over_units(values / base, worlds)


def _trimmed(x: Values, axis: int = -1) -> Values:
    return np.asarray(stats.trim_mean(x, 0.25, axis=axis))


def _bootstrap(x: Values, statistic: object) -> tuple[float, float]:
    with warnings.catch_warnings():
        # Nearly equal values have no BCa interval: it is NaN, and Student's t takes over.
        warnings.simplefilter("ignore", stats.DegenerateDataWarning)
        found = stats.bootstrap(
            (x,), statistic, confidence_level=LEVEL, n_resamples=_RESAMPLES, method="BCa",
            vectorized=True, batch=max(1, _BATCH_VALUES // len(x)), rng=np.random.default_rng(0),
        )  # type: ignore[call-overload]  # fmt: skip
    low, high = found.confidence_interval
    return float(low), float(high)
