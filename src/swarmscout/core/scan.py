"""A scan: what a range sensor hands to the mind of its robot."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

__all__ = ["TICKS", "Scan", "rays_in"]

TICKS = 3600
"""Angles are counted in ticks of 0.1°, so that turning never accumulates rounding errors."""


@dataclass(frozen=True, slots=True)
class Scan:
    """One measurement of all robots' range sensors, row i by robot i.

    The inverse sensor model (:mod:`swarmscout.mapping.evidence`) reads nothing else: a beam clears
    the cells that it passed and fills those in which it ended.

    Attributes:
        ranges: float64[N, beams], measured distances in metres from the robot's centre, each in
            [0, max_range_m], or inf where a beam met nothing.
        directions: int64[beams], where the beams point, counter-clockwise from the robot's heading,
            in ticks of 0.1°.
        max_range_m: the longest range in metres; a beam that met nothing clears cells up to here.
        opening: the angle over which each beam spreads, in ticks of 0.1°. 0 is a ray. A wider beam
            is a cone that measures the nearest obstacle in it: where on its arc is unknown.
    """

    ranges: NDArray[np.float64]
    directions: NDArray[np.int64]
    max_range_m: float
    opening: int = 0


def rays_in(opening: int, range_m: float, cell_m: float) -> tuple[int, int]:
    """How many rays a wide beam is made of, and how far they are apart, in ticks.

    At the longest range neighbours are at most half a cell apart, or one tick.

    Args:
        opening: the beam's, in ticks; range_m: the longest range; cell_m: edge of a cell.
    """
    apart = max(1, int(0.5 * cell_m / range_m * TICKS / (2.0 * math.pi)))
    return -(-opening // apart) + 1, apart
