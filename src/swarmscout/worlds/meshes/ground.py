"""The ground under a floor's bumps, and where a floor is no ground: obstacles and steep places."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from swarmscout.core.jit import kernel

__all__ = ["Ground", "flanks", "ground_under"]

_BUMP_M = 0.6
"""Radius: what is narrower than this disc and stands out of the floor is no ground."""
_OBSTACLE_M = 0.2
_STEEPEST_DEG = 30.0
_SMOOTH_M = 0.3
_LEDGE_M = 1.0
"""What is nearer than the disc's radius and so much higher or lower is another level."""
_FLANK_DEG, _FLANK_M = 45.0, 0.2


@dataclass(frozen=True, eq=False)
class Ground:
    """The ground reference, and where the floor departs from it.

    Attributes:
        height_m: float32[rows, cols], the smoothed ground, which goes on a little beside the floor;
            NaN farther away.
        obstacle: bool[rows, cols], the floor stands out of the ground.
        steep: bool[rows, cols], the ground is too steep.
    """

    height_m: NDArray[np.float32]
    obstacle: NDArray[np.bool_]
    steep: NDArray[np.bool_]


def ground_under(floor_m: NDArray[np.float32], cell_m: float) -> Ground:
    """Grey opening of the floor with a disc, smoothed; obstacles and steep places against it.

    Args:
        floor_m: float32[rows, cols], heights of the floor; NaN where there is none.
        cell_m: edge of a cell, in metres.
    """
    known = ~np.isnan(floor_m)
    offsets = _disc(_BUMP_M / cell_m)
    lowest = _extreme(floor_m, floor_m, offsets, -1.0)
    opened = _extreme(lowest, floor_m, offsets, 1.0)
    height = _smoothed(opened, known, _SMOOTH_M / cell_m)
    # Beside the floor any mean does; on it the edge of another level must not bend the ground.
    offsets = _disc(3.0 * _SMOOTH_M / cell_m)
    weights = np.exp(-0.5 * (offsets**2).sum(axis=1) * (cell_m / _SMOOTH_M) ** 2)
    _mean(opened, offsets, weights, height)
    with np.errstate(invalid="ignore"):
        obstacle = known & (floor_m - height > _OBSTACLE_M)
    slope = _slope(np.where(known, height, np.float32(np.nan)), cell_m)
    steep = known & (slope > math.tan(math.radians(_STEEPEST_DEG)))
    return Ground(height, obstacle, steep & ~obstacle)


def flanks(floor_m: NDArray[np.float32], cell_m: float) -> NDArray[np.bool_]:
    """Where a floor is so steep that it is the side of something: bool[rows, cols].

    Args:
        floor_m: float32[rows, cols], heights of the floor; NaN where there is none.
        cell_m: edge of a cell, in metres.
    """
    known = ~np.isnan(floor_m)
    height = np.where(known, _smoothed(floor_m, known, _FLANK_M / cell_m), np.float32(np.nan))
    steep: NDArray[np.bool_] = _slope(height, cell_m) > math.tan(math.radians(_FLANK_DEG))
    return steep & known


def _disc(radius: float) -> NDArray[np.int64]:
    """int64[k, 2]: row and column offsets of the cells in a disc."""
    reach = math.floor(radius + 1e-9)
    row, col = np.mgrid[-reach : reach + 1, -reach : reach + 1]
    inside = row**2 + col**2 <= radius**2 + 1e-9
    return np.ascontiguousarray(np.stack((row[inside], col[inside]), axis=1), dtype=np.int64)


@kernel
def _extreme(heights, floor, offsets, sign):  # type: ignore[no-untyped-def]
    """The highest (sign 1) or lowest (−1) height within a disc round each cell.

    SciPy's grey filters know no missing heights, nor that beyond a ledge another level begins, and
    take every cell of a raster that is mostly rock.
    """
    rows, columns = heights.shape
    found = np.full((rows, columns), np.nan, dtype=np.float32)
    for row in range(rows):
        for col in range(columns):
            if np.isnan(heights[row, col]):
                continue
            best = heights[row, col]
            for number in range(len(offsets)):
                r, c = row + offsets[number, 0], col + offsets[number, 1]
                if 0 <= r < rows and 0 <= c < columns:
                    # A missing height compares as false.
                    same_level = abs(floor[r, c] - floor[row, col]) < _LEDGE_M
                    if same_level and sign * heights[r, c] > sign * best:
                        best = heights[r, c]
            found[row, col] = best
    return found


@kernel
def _mean(heights, offsets, weights, mean):  # type: ignore[no-untyped-def]
    """Put the weighted mean of the heights about each known one, on its own level, into `mean`."""
    rows, columns = heights.shape
    for row in range(rows):
        for col in range(columns):
            here = heights[row, col]
            if np.isnan(here):
                continue
            total = weight = 0.0
            for number in range(len(offsets)):
                r, c = row + offsets[number, 0], col + offsets[number, 1]
                if 0 <= r < rows and 0 <= c < columns and abs(heights[r, c] - here) < _LEDGE_M:
                    total += weights[number] * heights[r, c]
                    weight += weights[number]
            mean[row, col] = total / weight


def _smoothed(
    heights: NDArray[np.float32], known: NDArray[np.bool_], sigma: float
) -> NDArray[np.float32]:
    """A Gaussian mean over the known heights only; NaN where none is near."""
    filled = np.where(known, heights, np.float32(0.0))
    weight = ndimage.gaussian_filter(known.astype(np.float32), sigma, truncate=3.0)
    total = ndimage.gaussian_filter(filled, sigma, truncate=3.0)
    enough = weight > 1e-3
    smooth = np.full(heights.shape, np.nan, dtype=np.float32)
    np.divide(total, weight, out=smooth, where=enough)
    return smooth


@kernel
def _slope(heights, cell_m):  # type: ignore[no-untyped-def]
    """Rise over run of the steepest direction; at the floor's edges from the side that is known."""
    rows, columns = heights.shape
    slope = np.zeros((rows, columns), dtype=np.float32)
    for row in range(rows):
        for col in range(columns):
            here = heights[row, col]
            if np.isnan(here):
                continue
            steepest = 0.0
            for axis in range(2):
                low = high = here
                span = 0
                r, c = row - (1 - axis), col - axis
                if r >= 0 and c >= 0 and not np.isnan(heights[r, c]):
                    low, span = heights[r, c], span + 1
                r, c = row + (1 - axis), col + axis
                if r < rows and c < columns and not np.isnan(heights[r, c]):
                    high, span = heights[r, c], span + 1
                if span > 0:
                    steepest += ((high - low) / span) ** 2
            slope[row, col] = np.sqrt(steepest) / cell_m
    return slope
