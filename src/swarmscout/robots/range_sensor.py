"""The range sensor: a fan of short rays from the robot's centre (paper, "Robot model", Fig. 1a).

Deviation: rays meet walls only. A robot knows where the others are and never maps them, so letting
rays pass through bodies loses nothing but the shadows they would cast.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import minimum_filter

from swarmscout.core.jit import inlined, kernel
from swarmscout.robots.bodies import to_ticks

__all__ = ["NOTHING", "RangeSensor", "cast_rays", "mark_clear"]

NOTHING = np.inf
"""The range of a ray that met nothing."""


CLEAR = 2
"""In a marked raster: free, and so far from any wall that no ray meets one."""


def mark_clear(free: NDArray[np.uint8], resolution_m: float, range_m: float) -> NDArray[np.uint8]:
    """Mark the cells from which no ray can meet a wall, so that none need be cast there.

    Args:
        free: uint8[rows, cols], the world's raster; outside is wall.
        resolution_m: edge of its cells; range_m: longest range.

    Returns:
        uint8[rows, cols]: 0 wall, 1 free, CLEAR where all cells within reach are free.
    """
    reach = math.ceil(range_m / resolution_m) + 1
    known = (free != 0).astype(np.uint8)
    clear = minimum_filter(known, size=2 * reach + 1, mode="constant", cval=0)
    return np.ascontiguousarray(known + clear)


class RangeSensor:
    """Nine (or so) noisy rays over a fan.

    Attributes:
        offsets: int64[rays], directions relative to the heading, in ticks, right to left.
        range_m: longest range.
    """

    def __init__(self, rays: int, fan_deg: float, range_m: float) -> None:
        angles = [0.0] if rays == 1 else np.linspace(-fan_deg, fan_deg, rays)
        self.offsets: NDArray[np.int64] = np.array([to_ticks(a) for a in angles], dtype=np.int64)
        self.range_m = range_m


@inlined
def _first_wall(free, x, y, dx, dy, longest):  # type: ignore[no-untyped-def]
    """Distance along a ray to the first cell that is not free, in cells; inf if beyond `longest`.

    Source: Amanatides and Woo (1987), "A fast voxel traversal algorithm for ray tracing".
    """
    rows, columns = free.shape
    col = int(math.floor(x))
    row = int(math.floor(y))
    step_col = 1 if dx > 0.0 else -1
    step_row = 1 if dy > 0.0 else -1
    per_col = abs(1.0 / dx) if dx != 0.0 else np.inf
    per_row = abs(1.0 / dy) if dy != 0.0 else np.inf
    next_col = ((col + 1 - x) if dx > 0.0 else (x - col)) * per_col if dx != 0.0 else np.inf
    next_row = ((row + 1 - y) if dy > 0.0 else (y - row)) * per_row if dy != 0.0 else np.inf
    while True:
        if next_col < next_row:
            distance = next_col
            next_col += per_col
            col += step_col
        else:
            distance = next_row
            next_row += per_row
            row += step_row
        if distance > longest:
            return np.inf
        if row < 0 or row >= rows or col < 0 or col >= columns or free[row, col] == 0:
            return distance


@kernel
def cast_rays(free, ox, oy, res, position, heading, alive, offsets, table, range_m, noise, ranges):  # type: ignore[no-untyped-def]
    """Sense once with all robots.

    Args:
        free: uint8[rows, cols], the world's raster, marked by :func:`mark_clear` or not.
        ox, oy, res: its lower left corner and cell edge, in metres.
        position: float64[N, 2], heading: int64[N], alive: bool[N].
        offsets: int64[rays] in ticks; table: float64[3600, 2] of (cos, sin).
        range_m: longest range.
        noise: float64[N, rays], added to what is measured, in metres.
        ranges: float64[N, rays], written: the measured range ≥ 0, or inf if nothing was met.
    """
    ticks = table.shape[0]
    for i in range(position.shape[0]):
        x = (position[i, 0] - ox) / res
        y = (position[i, 1] - oy) / res
        if not alive[i] or free[int(math.floor(y)), int(math.floor(x))] == CLEAR:
            for r in range(offsets.shape[0]):
                ranges[i, r] = np.inf
            continue
        for r in range(offsets.shape[0]):
            tick = (heading[i] + offsets[r]) % ticks
            cells = _first_wall(free, x, y, table[tick, 0], table[tick, 1], range_m / res)
            if cells == np.inf:
                ranges[i, r] = np.inf
            else:
                ranges[i, r] = max(0.0, cells * res + noise[i, r])
