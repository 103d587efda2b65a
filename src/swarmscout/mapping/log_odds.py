"""Log-odds as fixed-point integers, and the tables that read them.

One unit is 1/1000 nat. Integers add up exactly, so fusion is associative and commutative bit for
bit: the order of messages cannot change a map. Sums are 64 bits wide: robots that charge in one
place see the same cells millions of times.

Deviation: probabilities saturate, which the paper does not say, and when evidence is *read*, never
when it is added.

Source: paper, "Robot model"; Thrun, Burgard, Fox (2005), *Probabilistic Robotics*, ch. 4.2 and 9.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.typing import NDArray

__all__ = ["InverseSensorModel", "log_odds_of", "probability_of"]


def log_odds_of(probability: float) -> int:
    """A probability in (0, 1) as log-odds in 1/1000 nat."""
    return round(1000.0 * math.log(probability / (1.0 - probability)))


def probability_of(log_odds: float) -> float:
    """Log-odds in 1/1000 nat as a probability."""
    return 1.0 / (1.0 + math.exp(-log_odds / 1000.0))


@dataclass(frozen=True, slots=True)
class InverseSensorModel:
    """What a ray says of a cell, and how summed evidence is read.

    Attributes:
        free: increment for a cell that a ray passed, < 0.
        occupied: increment for the cell in which it ended, > 0.
        lowest, highest: saturation, applied when evidence is read.
        free_below, occupied_above: thresholds of the labels.
        hit_depth_m: an obstacle's body lies this far behind its measured surface.
    """

    free: int
    occupied: int
    lowest: int
    highest: int
    free_below: int
    occupied_above: int
    hit_depth_m: float

    def permille(self) -> NDArray[np.int16]:
        """int16[highest - lowest + 1]: occupancy probability in 1/1000 from `lowest` upwards.

        Route costs use these integers, so sums of costs are exact too. None is 0: a route over
        cells that cost nothing would have no end.
        """
        return _permille(self.lowest, self.highest).copy()


@cache
def _permille(lowest: int, highest: int) -> NDArray[np.int16]:
    odds = range(lowest, highest + 1)
    permille = [max(1, round(1000.0 * probability_of(value))) for value in odds]
    return np.array(permille, dtype=np.int16)
