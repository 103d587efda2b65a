"""Rays against a world's raster.

Deviation: rays meet walls only. Robots know each other's positions and never map each other, so a
ray that passes through other robots loses nothing but the shadows that they would cast.
"""

from __future__ import annotations

import math
from typing import Any
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import distance_transform_cdt

from swarmscout.core.jit import inlined, kernel
from swarmscout.robots.bodies import Bodies, heading_table
from swarmscout.worlds.world import World

__all__ = ["add_noise", "cast_rays", "raster_ranges"]

_FRAME = np.dtype([("left_m", "f8"), ("bottom_m", "f8"), ("cell_m", "f8")])
_HEADINGS = heading_table()

_kept: WeakKeyDictionary[World, tuple[NDArray[np.uint8], NDArray[Any]]] = WeakKeyDictionary()


def raster_ranges(
    bodies: Bodies, world: World, directions: NDArray[np.int64], range_m: float
) -> NDArray[np.float64]:
    """Cast rays from each robot's centre.

    Args:
        bodies: where robots are.
        world: what the rays meet: the cells of its raster that are not free, and its border.
        directions: int64[rays], counter-clockwise from the heading, in ticks of 0.1°.
        range_m: longest range, in metres.

    Returns:
        float64[N, rays], distances in metres; inf where a ray met nothing, and for robots that are
        not alive.
    """
    clear, frame = _clearance(world)
    ranges = np.empty((len(bodies.heading), len(directions)))
    cast_rays(
        clear, frame, bodies.position, bodies.heading, bodies.alive, directions, _HEADINGS,
        range_m, ranges,
    )  # fmt: skip
    return ranges


def _clearance(world: World) -> tuple[NDArray[np.uint8], NDArray[Any]]:
    """How far walls are from each cell of a world's raster, and the raster's frame.

    Rays leap over free cells by it. It is computed once for each world.

    Returns:
        uint8[rows, cols], chessboard distance to the nearest wall cell, at most 255 and 0 in a
        wall; and one record of `_FRAME`.
    """
    if world not in _kept:
        free = np.pad(world.free != 0, 1)  # Outside is wall.
        cells = distance_transform_cdt(free, metric="chessboard")[1:-1, 1:-1]
        clear = np.ascontiguousarray(np.minimum(cells, 255), dtype=np.uint8)
        _kept[world] = clear, np.array([(*world.origin_m, world.resolution_m)], dtype=_FRAME)
    return _kept[world]


@inlined
def _first_wall(clear, x, y, dx, dy, longest):  # type: ignore[no-untyped-def]
    """Distance along a ray to the first wall cell, in cells; inf if beyond `longest`.

    The ray leaps from box to box: `clear[row, col] - 1` cells on each side of a cell are free.

    Source: Amanatides and Woo (1987), "A fast voxel traversal algorithm for ray tracing", of which
    this is the leaping form.
    """
    rows, columns = clear.shape
    col = int(math.floor(x))
    row = int(math.floor(y))
    per_col = 1.0 / dx if dx != 0.0 else np.inf
    per_row = 1.0 / dy if dy != 0.0 else np.inf
    leap = max(1, int(clear[row, col]))  # The robot's own cell stops no ray.
    while True:
        to_col = np.inf
        to_row = np.inf
        if dx != 0.0:
            to_col = ((col + leap if dx > 0.0 else col - leap + 1) - x) * per_col
        if dy != 0.0:
            to_row = ((row + leap if dy > 0.0 else row - leap + 1) - y) * per_row
        distance = min(to_col, to_row)
        if distance > longest:
            return np.inf
        # Rounding must not move the ray out of the box on the side that it did not reach.
        if to_col < to_row:
            col += leap if dx > 0.0 else -leap
            row = min(row + leap - 1, max(row - leap + 1, int(math.floor(y + distance * dy))))
        else:
            row += leap if dy > 0.0 else -leap
            col = min(col + leap - 1, max(col - leap + 1, int(math.floor(x + distance * dx))))
        if row < 0 or row >= rows or col < 0 or col >= columns:
            return distance
        leap = int(clear[row, col])
        if leap == 0:
            return distance


@kernel
def cast_rays(clear, frame, position, heading, alive, directions, table, range_m, ranges):  # type: ignore[no-untyped-def]
    """Cast rays from each robot's centre; see :func:`raster_ranges`.

    Args:
        clear, frame: of :func:`_clearance`.
        position: float64[N, 2] in metres; heading: int64[N] in ticks; alive: bool[N].
        directions: int64[rays] in ticks; table: float64[3600, 2] of (cos, sin).
        range_m: longest range, in metres.
        ranges: float64[N, rays], written.
    """
    ticks = table.shape[0]
    left_m, bottom_m, cell_m = frame[0].left_m, frame[0].bottom_m, frame[0].cell_m
    longest = range_m / cell_m
    for i in range(position.shape[0]):
        x = (position[i, 0] - left_m) / cell_m
        y = (position[i, 1] - bottom_m) / cell_m
        if not alive[i] or clear[int(math.floor(y)), int(math.floor(x))] > longest + 2.0:
            ranges[i, :] = np.inf  # Dead, or too far from any wall.
            continue
        for r in range(directions.shape[0]):
            tick = (heading[i] + directions[r]) % ticks
            cells = _first_wall(clear, x, y, table[tick, 0], table[tick, 1], longest)
            # Rounding must not carry what was met beyond the longest range.
            ranges[i, r] = min(cells * cell_m, range_m) if cells <= longest else np.inf


@kernel
def add_noise(ranges, noise, deviation_m, range_m):  # type: ignore[no-untyped-def]
    """Add noise to ranges that met something; what then lies beyond the longest range is inf.

    Args:
        ranges: float64[N, beams], changed.
        noise: float64[N, beams], standard normal numbers.
        deviation_m: the noise's standard deviation; range_m: the longest range, in metres.
    """
    for i in range(ranges.shape[0]):
        for r in range(ranges.shape[1]):
            measured = max(0.0, ranges[i, r] + noise[i, r] * deviation_m)
            ranges[i, r] = measured if measured <= range_m else np.inf
