"""Steep surfaces between neighbouring columns, which the columns themselves may not meet.

A partition without thickness, the side of a box that stands on a floor, the flank of a boulder: an
upright surface meets no vertical line. So the mesh is cut by upright planes through the
rows and the columns of cell centres too; where a plane meets a steep triangle between two
neighbours, there is a wall from one height to another.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from swarmscout.core.grid import GridFrame
from swarmscout.core.jit import inlined, kernel
from swarmscout.worlds.meshes.tiles import TILE, in_tiles

__all__ = ["EAST", "NORTH", "Walls", "find_walls"]

EAST, NORTH = 0, 1
_STEEP = math.tan(math.radians(60.0))
_TOLERANCE = 1e-7


@dataclass(frozen=True, eq=False)
class Walls:
    """Pieces of wall between a cell and its neighbour to the east or north, ordered by key.

    Attributes:
        key: int64[n], twice the flat cell, plus ``EAST`` or ``NORTH``.
        bottom_m: float32[n].
        top_m: float32[n].
        mine: bool[n], whether the wall stands in the cell itself rather than in its neighbour.
    """

    key: NDArray[np.int64]
    bottom_m: NDArray[np.float32]
    top_m: NDArray[np.float32]
    mine: NDArray[np.bool_]


def find_walls(
    corners: NDArray[np.float64],
    triangles: NDArray[np.int32],
    frame: GridFrame,
    clearance_m: float,
    progress: Callable[[float], None],
) -> Walls:
    """Find all pieces of wall between neighbouring cells.

    Args:
        corners: float64[V, 3], vertices: column and row in cells, and height in metres.
        triangles: int32[T, 3].
        frame: the raster; the whole mesh is inside.
        clearance_m: how much room over a floor two neighbours must share.
        progress: called with the share that is done, 0 to 1.
    """
    # What is less steep rises so little between two centres that the room over one floor and the
    # room over the other share less than the clearance: their columns show that already.
    steepness = min(_STEEP, 0.5 * clearance_m / frame.cell_m)
    a, b, c = (corners[triangles[:, corner]] for corner in range(3))
    across = np.cross(b - a, c - a)
    # Seen from above lengths count in cells, upward in metres.
    upright = np.hypot(across[:, 0], across[:, 1]) >= steepness * frame.cell_m * np.abs(
        across[:, 2]
    )
    steep = np.ascontiguousarray(triangles[upright])
    del a, b, c, across, upright
    parts: list[
        tuple[NDArray[np.int64], NDArray[np.float32], NDArray[np.float32], NDArray[np.bool_]]
    ]
    parts = []
    for done, row, col, members in in_tiles(corners, steep, frame):
        progress(done)
        none = np.empty(0, dtype=np.float32)
        met = _cut(
            corners, steep, members, row, col, frame.columns, np.empty(0, np.int64), none, none
        )
        if not met:
            continue
        key = np.empty(met, dtype=np.int64)
        bottom, top = np.empty(met, dtype=np.float32), np.empty(met, dtype=np.float32)
        _cut(corners, steep, members, row, col, frame.columns, key, bottom, top)
        order = np.lexsort((bottom, key))
        parts.append(_joined(key[order], bottom[order], top[order]))
    progress(1.0)
    if not parts:
        none = np.empty(0, dtype=np.float32)
        return Walls(np.empty(0, dtype=np.int64), none, none, np.empty(0, dtype=np.bool_))
    key, bottom, top, mine = (np.concatenate(each) for each in zip(*parts, strict=True))
    order = np.argsort(key, kind="stable")
    return Walls(key[order], bottom[order], top[order], mine[order])


def _joined(
    key: NDArray[np.int64], bottom: NDArray[np.float32], top: NDArray[np.float32]
) -> tuple[NDArray[np.int64], NDArray[np.float32], NDArray[np.float32], NDArray[np.bool_]]:
    """Pieces of the same wall that touch or overlap become one."""
    begins = _begins(key, bottom, top)
    starts = np.flatnonzero(begins)
    return (
        key[starts] >> 1,
        bottom[starts],
        np.maximum.reduceat(top, starts),
        (key[starts] & 1) == 1,
    )


@kernel
def _begins(key, bottom, top):  # type: ignore[no-untyped-def]
    """Where a new wall begins in pieces that are ordered by key and bottom."""
    begins = np.ones(len(key), dtype=np.bool_)
    reach = np.float32(0.0)
    for piece in range(len(key)):
        if piece > 0 and key[piece] == key[piece - 1] and bottom[piece] <= reach + 0.01:
            begins[piece] = False
            reach = max(reach, top[piece])
        else:
            reach = top[piece]
    return begins


@inlined
def _place(u, v, low_u, low_z, high_u, high_z, low, high):  # type: ignore[no-untyped-def]
    """Take one more point of a section into its ends and its bounds."""
    if u < low_u:
        low_u, low_z = u, v
    if u > high_u:
        high_u, high_z = u, v
    return low_u, low_z, high_u, high_z, min(low, v), max(high, v)


@inlined
def _section(corners, a, b, c, along, over, line):  # type: ignore[no-untyped-def]
    """Where an upright plane meets a triangle.

    Returns its two ends (place along the plane and height), its lowest and highest point, and
    whether the whole triangle lies in the plane.
    """
    low_u, low_z, high_u, high_z, low, high = np.inf, 0.0, -np.inf, 0.0, np.inf, -np.inf
    inside = 0
    for side in range(3):
        p, q = (a, b) if side == 0 else ((b, c) if side == 1 else (c, a))
        if corners[p, over] > corners[q, over]:
            p, q = q, p
        first, last = corners[p, over], corners[q, over]
        if line < first or line > last:
            continue
        if last - first < 1e-9:
            inside += 1
            for end in (p, q):
                low_u, low_z, high_u, high_z, low, high = _place(
                    corners[end, along], corners[end, 2], low_u, low_z, high_u, high_z, low, high
                )
            continue
        share = (line - first) / (last - first)
        u = corners[p, along] + share * (corners[q, along] - corners[p, along])
        z = corners[p, 2] + share * (corners[q, 2] - corners[p, 2])
        low_u, low_z, high_u, high_z, low, high = _place(
            u, z, low_u, low_z, high_u, high_z, low, high
        )
    return low_u, low_z, high_u, high_z, low, high, inside == 3


@kernel
def _cut(corners, triangles, members, top, left, columns, key, bottom, upper):  # type: ignore[no-untyped-def]
    """Pieces of wall in a tile: count (no keys), or fill in; a key's last bit says whose it is."""
    fill = len(key) > 0
    many = 0
    for member in members:
        a, b, c = triangles[member, 0], triangles[member, 1], triangles[member, 2]
        for direction in range(2):  # EAST: planes along rows; NORTH: along columns.
            along, over = direction, 1 - direction
            line0, step0 = (top, left) if direction == 0 else (left, top)
            lowest = min(corners[a, over], corners[b, over], corners[c, over])
            highest = max(corners[a, over], corners[b, over], corners[c, over])
            for line in range(
                max(int(np.ceil(lowest - _TOLERANCE)), line0),
                min(int(np.floor(highest + _TOLERANCE)), line0 + TILE - 1) + 1,
            ):
                at = min(max(float(line), lowest), highest)
                near, near_z, far, far_z, low, high, flat = _section(
                    corners, a, b, c, along, over, at
                )
                for step in range(
                    max(int(np.floor(near - _TOLERANCE)), step0),
                    min(int(np.floor(far + _TOLERANCE)), step0 + TILE - 1) + 1,
                ):
                    if fill:
                        begin, end = max(near, float(step)), min(far, step + 1.0)
                        z0, z1 = low, high
                        if far - near > 1e-6 and not flat:
                            rise = (far_z - near_z) / (far - near)
                            z0 = near_z + rise * (begin - near)
                            z1 = near_z + rise * (end - near)
                        row, col = (line, step) if direction == 0 else (step, line)
                        mine = 1 if 0.5 * (begin + end) - step < 0.5 else 0
                        key[many] = ((row * columns + col) * 2 + direction) * 2 + mine
                        bottom[many] = max(min(z0, z1), low)
                        upper[many] = min(max(z0, z1), high)
                    many += 1
    return many
