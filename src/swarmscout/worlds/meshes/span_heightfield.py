"""What lies above what: the mesh cut by a vertical line through each raster cell's centre.

A line meets the surface at some heights. Between two of them that follow each other, or above the
last, there is a *span*: room over a floor, if it is high enough. Neither normals nor a closed
surface are needed. Instead of casting rays, triangles are filled in from above, as a graphics card
does it, tile by tile: exact, quick, and the memory stays that of the result.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from swarmscout.core.errors import WorldError
from swarmscout.core.grid import GridFrame
from swarmscout.core.jit import inlined, kernel
from swarmscout.worlds.meshes.tiles import TILE, in_tiles

__all__ = ["FACES_AIR", "Spans", "find_spans"]

FACES_AIR = 1
"""A span's flag: both its surfaces are wound as those of a room in solid rock are."""
FACES_ROCK = 2
"""A span's flag: both its surfaces are wound the other way round."""
_MOST_SPANS = 60_000_000
_MOST_SURFACES = 200
"""Surfaces above a cell, on average over a tile: a mesh with more of them is stacked copies."""
_TOLERANCE = 1e-7
"""In cells: so near to an edge a centre lies on both triangles that share it."""


@dataclass(frozen=True, eq=False)
class Spans:
    """Room over floors, ordered by cell and then by height.

    Attributes:
        cell: int32[n], flat cell of the frame.
        floor_m: float32[n].
        ceiling_m: float32[n]; infinite under open sky.
        facing: uint8[n], of ``FACES_AIR`` and ``FACES_ROCK``.
        low: int32[k], cells with room under a ceiling, but nowhere enough.
        hit: how many cells have any surface.
    """

    cell: NDArray[np.int32]
    floor_m: NDArray[np.float32]
    ceiling_m: NDArray[np.float32]
    facing: NDArray[np.uint8]
    low: NDArray[np.int32]
    hit: int


def find_spans(
    corners: NDArray[np.float64],
    triangles: NDArray[np.int32],
    frame: GridFrame,
    clearance_m: float,
    progress: Callable[[float], None],
) -> Spans:
    """Cut a mesh into columns, and each column into spans.

    Args:
        corners: float64[V, 3], vertices: column and row in cells (a centre is a whole number),
            and height in metres.
        triangles: int32[T, 3].
        frame: where the raster lies; the whole mesh is inside.
        clearance_m: spans lower than this are none.
        progress: called with the share that is done, 0 to 1.

    Raises:
        WorldError: there are too many.
    """
    parts: list[tuple[NDArray[Any], ...]] = []
    total = hit = 0
    heights = np.empty(0, dtype=np.float64)
    for done, row, col, members in in_tiles(corners, triangles, frame):
        progress(done)
        counts = np.zeros(TILE * TILE, dtype=np.int64)
        _meet(corners, triangles, members, row, col, counts, np.empty(0), np.empty(0, np.uint8))
        _check_stack(counts, frame, row, col)
        ends = np.cumsum(counts)
        met = int(ends[-1])
        if not met:
            continue
        hit += int(np.count_nonzero(counts))
        heights = np.empty(met, dtype=np.float64)
        upward = np.empty(met, dtype=np.uint8)
        places = ends - counts
        _meet(corners, triangles, members, row, col, places, heights, upward)
        cell = np.empty(met, dtype=np.int32)
        floor, ceiling = np.empty(met, dtype=np.float32), np.empty(met, dtype=np.float32)
        facing, low = np.empty(met, dtype=np.uint8), np.empty(TILE * TILE, dtype=np.int32)
        many, lows = _spans(
            ends, counts, heights, upward, clearance_m, row, col, frame.columns,
            cell, floor, ceiling, facing, low,
        )  # fmt: skip
        arrays = (cell[:many], floor[:many], ceiling[:many], facing[:many], low[:lows])
        parts.append(tuple(array.copy() for array in arrays))
        total += many
        if total > _MOST_SPANS:
            raise WorldError(
                f"the mesh has more than {_MOST_SPANS:,} floors one above the other: "
                "take larger cells (resolution_m), or cut away what is not the cave"
            )
    progress(1.0)
    if not parts:
        return _no_spans()
    cell, floor, ceiling, facing, low = (np.concatenate(each) for each in zip(*parts, strict=True))
    order = np.argsort(cell, kind="stable")
    return Spans(cell[order], floor[order], ceiling[order], facing[order], low, hit)


def _check_stack(counts: NDArray[np.int64], frame: GridFrame, row: int, col: int) -> None:
    """Refuse a tile with hundreds of surfaces above each of its cells.

    Raises:
        WorldError: with the place where most of them are.
    """
    if counts.sum() > _MOST_SURFACES * max(int(np.count_nonzero(counts)), TILE):
        fullest = int(np.argmax(counts))
        x, y = frame.centre_of(row + fullest // TILE, col + fullest % TILE)
        raise WorldError(
            f"{counts[fullest]:,} surfaces or more lie one above the other at ({x:.1f}, {y:.1f}) "
            "m: not a cave or a building; remove stacked copies"
        )


def _no_spans() -> Spans:
    none, heights = np.empty(0, dtype=np.int32), np.empty(0, dtype=np.float32)
    return Spans(none, heights, heights, np.empty(0, dtype=np.uint8), none, 0)


@inlined
def _reach(pu, pv, qu, qv, row, low, high):  # type: ignore[no-untyped-def]
    """Widen the interval in which a row meets a triangle by where it meets one of its edges."""
    if pv > qv or (pv == qv and pu > qu):  # Both triangles at an edge must find the same place.
        pu, pv, qu, qv = qu, qv, pu, pv
    if row < pv or row > qv:
        return low, high
    if pv == qv:
        return min(low, pu), max(high, qu)
    at = pu + (row - pv) / (qv - pv) * (qu - pu)
    return min(low, at), max(high, at)


@kernel
def _meet(corners, triangles, members, top, left, places, heights, upward):  # type: ignore[no-untyped-def]
    """Where the columns of a tile meet triangles: count (no heights), or fill in and move places.

    places: int64[TILE * TILE], counts or the next place to write to, by column of the tile.

    Counting ends early where there is far too much to count.
    """
    fill = len(heights) > 0
    total = 0
    for member in members:
        if not fill and total > _MOST_SURFACES * TILE * TILE:
            return
        a, b, c = triangles[member, 0], triangles[member, 1], triangles[member, 2]
        au, av, az = corners[a, 0], corners[a, 1], corners[a, 2]
        bu, bv, bz = corners[b, 0], corners[b, 1], corners[b, 2]
        cu, cv, cz = corners[c, 0], corners[c, 1], corners[c, 2]
        twice = (bu - au) * (cv - av) - (cu - au) * (bv - av)
        if abs(twice) < 1e-12:
            continue  # Upright: a column runs past it or along it.
        slope_u = ((bz - az) * (cv - av) - (cz - az) * (bv - av)) / twice
        slope_v = ((cz - az) * (bu - au) - (bz - az) * (cu - au)) / twice
        lowest, highest = min(az, bz, cz), max(az, bz, cz)
        first = max(int(np.ceil(min(av, bv, cv) - _TOLERANCE)), top)
        last = min(int(np.floor(max(av, bv, cv) + _TOLERANCE)), top + TILE - 1)
        for row in range(first, last + 1):
            line = min(max(float(row), min(av, bv, cv)), max(av, bv, cv))
            near, far = np.inf, -np.inf
            near, far = _reach(au, av, bu, bv, line, near, far)
            near, far = _reach(bu, bv, cu, cv, line, near, far)
            near, far = _reach(cu, cv, au, av, line, near, far)
            for col in range(
                max(int(np.ceil(near - _TOLERANCE)), left),
                min(int(np.floor(far + _TOLERANCE)), left + TILE - 1) + 1,
            ):
                column = (row - top) * TILE + col - left
                if fill:
                    z = az + slope_u * (col - au) + slope_v * (row - av)
                    # Steep triangles blow rounding up; no point of one leaves its bounds.
                    heights[places[column]] = min(max(z, lowest), highest)
                    upward[places[column]] = 1 if twice > 0.0 else 0
                places[column] += 1
                total += 1


@kernel
def _spans(  # type: ignore[no-untyped-def]
    ends, counts, heights, upward, clearance, top, left, columns, cell, floor, ceiling, facing, low
):
    """Order each column's heights and keep the room between them; returns how many, and lows."""
    many = lows = 0
    for column in range(len(counts)):
        if counts[column] == 0:
            continue
        end = ends[column]
        begin = end - counts[column]
        if end - begin > 64:
            order = np.argsort(heights[begin:end], kind="mergesort")
            heights[begin:end] = heights[begin:end][order]
            upward[begin:end] = upward[begin:end][order]
        for one in range(begin + 1, end):  # Few surfaces, or sorted already.
            z, up = heights[one], upward[one]
            at = one
            while at > begin and heights[at - 1] > z:
                heights[at], upward[at] = heights[at - 1], upward[at - 1]
                at -= 1
            heights[at], upward[at] = z, up
        where = (top + column // TILE) * columns + left + column % TILE
        tight = False
        roofed = False
        for one in range(begin, end):
            sky = one + 1 == end
            gap = np.inf if sky else heights[one + 1] - heights[one]
            if gap < clearance:
                tight = tight or gap > 0.25 * clearance
                continue
            cell[many], floor[many] = where, heights[one]
            ceiling[many] = np.inf if sky else heights[one + 1]
            roofed = roofed or not sky
            above_down = sky or upward[one + 1] == 0
            above_up = sky or upward[one + 1] == 1
            facing[many] = 0
            if upward[one] == 1 and above_down:
                facing[many] = FACES_AIR
            elif upward[one] == 0 and above_up:
                facing[many] = FACES_ROCK
            many += 1
        if tight and not roofed:
            low[lows] = where
            lows += 1
    return many, lows
