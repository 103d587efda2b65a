"""The ground under the bumps of a floor, and where the floor is an obstacle or too steep."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from swarmscout.core.jit import kernel
from swarmscout.worlds.morphology import covered_by

__all__ = ["Ground", "flanks", "ground_under"]

_BUMP_M = 0.6
"""Radius: what is narrower than this disc and stands out of the floor is not ground."""
_OBSTACLE_M = 0.2
_STEEPEST_DEG, _SPARE_DEG, _SLOPE_M = 30.0, 8.0, 0.5
_SMOOTH_M = 0.3
_LEDGE_M = 1.0
"""What is nearer than the disc's radius and so much higher or lower is another level."""
_FLANK_DEG, _FLANK_M = 45.0, 0.3
_APART_M = 0.1
"""A disc has points so far apart, and no more of them in finer cells."""


@dataclass(frozen=True, eq=False)
class Ground:
    """The ground reference, and where the floor departs from it.

    Attributes:
        height_m: float32[rows, cols], the smoothed ground, which goes on a little beside the floor;
            NaN farther away.
        obstacle: bool[rows, cols], the floor stands out of the ground.
        steep: bool[rows, cols], the floor is too steep.
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
    offsets = _disc(_BUMP_M, cell_m)
    lowest = _extreme(floor_m, floor_m, offsets, -1.0)
    opened = _extreme(lowest, floor_m, offsets, 1.0)
    height = _smoothed(opened, cell_m, _SMOOTH_M)
    with np.errstate(invalid="ignore"):
        obstacle = known & (floor_m - height > _OBSTACLE_M)
    nearest = _disc(_stride(cell_m) * cell_m, cell_m)
    slope = _slope(np.where(known, height, np.float32(np.nan)), nearest, cell_m)
    steep = known & (slope > math.tan(math.radians(_STEEPEST_DEG)))
    # At its upper edge an opened slope is level, even where the floor is not.
    plain = np.where(obstacle, np.float32(np.nan), floor_m)
    slope = _slope(plain, _disc(_SLOPE_M, cell_m), cell_m)
    steep |= known & (slope > math.tan(math.radians(_STEEPEST_DEG + _SPARE_DEG)))
    return Ground(height, obstacle, steep & ~obstacle)


def flanks(floor_m: NDArray[np.float32], cell_m: float) -> NDArray[np.bool_]:
    """Where a floor is so steep that it is the side of something: bool[rows, cols].

    Args:
        floor_m: float32[rows, cols], heights of the floor; NaN where there is none.
        cell_m: edge of a cell, in metres.
    """
    slope = _slope(floor_m, _disc(_FLANK_M, cell_m), cell_m)
    steep: NDArray[np.bool_] = slope > math.tan(math.radians(_FLANK_DEG))
    return steep


def _stride(cell_m: float) -> int:
    """Every how many cells a disc has a point."""
    return max(math.floor(_APART_M / cell_m + 1e-6), 1)


def _disc(radius_m: float, cell_m: float) -> NDArray[np.int64]:
    """int64[k, 2]: row and column offsets of points in a disc."""
    stride = _stride(cell_m)
    radius = radius_m / cell_m
    reach = math.floor(radius / stride + 1e-9) * stride
    row, col = np.mgrid[-reach : reach + 1 : stride, -reach : reach + 1 : stride]
    inside = row**2 + col**2 <= radius**2 + 1e-9
    return np.ascontiguousarray(np.stack((row[inside], col[inside]), axis=1), dtype=np.int64)


@kernel
def _extreme(heights, floor, offsets, sign):  # type: ignore[no-untyped-def]
    """The highest (sign 1) or lowest (−1) height within a disc round each cell.

    SciPy's grey filters support neither missing heights nor another level beyond a ledge, and
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


def _smoothed(heights: NDArray[np.float32], cell_m: float, sigma_m: float) -> NDArray[np.float32]:
    """A Gaussian mean of the known heights, also a little beside them; NaN farther away."""
    offsets = _disc(3.0 * sigma_m, cell_m)
    weights = np.exp(-0.5 * (offsets**2).sum(axis=1) * (cell_m / sigma_m) ** 2)
    where = covered_by(~np.isnan(heights), cell_m, 2.5 * sigma_m)
    smooth: NDArray[np.float32] = _mean(heights, where, offsets, weights)
    stride = _stride(cell_m)
    if stride > 1:
        # Neighbours have looked at other points: a square in which each such choice counts once.
        reach = stride // 2
        row, col = np.mgrid[-reach : reach + 1, -reach : reach + 1]
        offsets = np.stack((row.ravel(), col.ravel()), axis=1)
        weights = np.where(2 * np.abs(offsets) == stride, 0.5, 1.0).prod(axis=1)
        smooth = _mean(smooth, where, offsets, weights)
    return smooth


@kernel
def _mean(heights, where, offsets, weights):  # type: ignore[no-untyped-def]
    """The weighted mean of the known heights about each wanted cell.

    Where a height is known it counts only what is on its own level: beyond a ledge the ground is
    another one.
    """
    rows, columns = heights.shape
    mean = np.full((rows, columns), np.nan, dtype=np.float32)
    for row in range(rows):
        for col in range(columns):
            if not where[row, col]:
                continue
            here = heights[row, col]
            total = weight = 0.0
            for number in range(len(offsets)):
                r, c = row + offsets[number, 0], col + offsets[number, 1]
                if 0 <= r < rows and 0 <= c < columns and not np.isnan(heights[r, c]):
                    # An unknown height compares as false: beside the floor all of it counts.
                    if abs(heights[r, c] - here) >= _LEDGE_M:
                        continue
                    total += weights[number] * heights[r, c]
                    weight += weights[number]
            if weight > 0.0:
                mean[row, col] = total / weight
    return mean


@kernel
def _slope(heights, offsets, cell_m):  # type: ignore[no-untyped-def]
    """The slope of the plane that fits the known heights about each cell best, on its own level.

    A plane is not misled at a floor's edge, where a mean bends.
    """
    rows, columns = heights.shape
    slope = np.zeros((rows, columns), dtype=np.float32)
    for row in range(rows):
        for col in range(columns):
            here = heights[row, col]
            if np.isnan(here):
                continue
            count = u = v = z = uu = uv = vv = uz = vz = 0.0
            for number in range(len(offsets)):
                y, x = offsets[number, 0], offsets[number, 1]
                r, c = row + y, col + x
                if 0 <= r < rows and 0 <= c < columns and abs(heights[r, c] - here) < _LEDGE_M:
                    rise = heights[r, c] - here
                    count += 1.0
                    u, v, z = u + x, v + y, z + rise
                    uu, uv, vv = uu + x * x, uv + x * y, vv + y * y
                    uz, vz = uz + x * rise, vz + y * rise
            uu, uv, vv = uu - u * u / count, uv - u * v / count, vv - v * v / count
            uz, vz = uz - u * z / count, vz - v * z / count
            span = uu * vv - uv * uv
            if span > 1e-6:
                along, up = (uz * vv - vz * uv) / span, (vz * uu - uz * uv) / span
            else:  # In a single row or column there is but one direction.
                along, up = uz / max(uu, 1e-6), vz / max(vv, 1e-6)
            slope[row, col] = np.sqrt(along * along + up * up) / cell_m
    return slope
