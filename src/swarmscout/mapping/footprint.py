"""A body's footprint on an occupancy grid: where its centre has no room beside what is known.

Each occupied cell weighs on the cells round it, and a cell's weights are summed as integers: what a
cell's label changes is added or taken away round it alone, and the sums equal those of a distance
transform from scratch after any sequence of changes. Deviation: the paper takes robots as points;
the method is the configuration space of Lozano-Pérez (1983), "Spatial planning: a configuration
space approach", for a disc.

A surface lies anywhere in the cell that counts as occupied, on average `hit_depth_m` before its
middle. Cells are closed (``TIGHT``) where, half a cell to the robot's favour, a body would touch:
so each passage that is a cell wider than the body is open, wherever it lies on the grid, as long as
cells are not much larger than the body. Nearer than half a cell more, and `SIDE_M`, is dear
(``BESIDE``): routes keep clear of walls where there is room.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from swarmscout.core.enums import FREE, OCCUPIED
from swarmscout.core.jit import allocating, inlined, kernel

__all__ = [
    "BESIDE",
    "BESIDE_UNIT",
    "FRONTIER",
    "LABEL_BITS",
    "STATION_ZONE",
    "TIGHT",
    "Footprint",
    "enter",
    "find_entries",
    "find_exits",
    "get_out",
    "weigh",
]

LABEL_BITS = 3
FRONTIER = 4
"""The bit of a cell's status that marks a frontier; the lower bits are its label."""
TIGHT = 8
"""The bit of a cell in whose middle a body has no room, occupied cells among them."""
BESIDE = 16
"""The bit of a cell in whose middle a body may touch what is occupied; all that are tight too."""
STATION_ZONE = 32
"""The bit of a cell in which robots charge; others keep clear of it. It never changes."""

BESIDE_UNIT = 1 << 16
"""Weights count occupied cells that make a cell tight in the lower bits, and all here."""

SIDE_M = 0.1
"""Where there is room, routes keep by so much farther from walls than a body may touch."""

EXIT_M = 2.0
"""So far at most a robot has to drive out of cells without room."""


@dataclass(frozen=True)
class Footprint:
    """What a body needs round its centre, in cells of a grid; by default that of a point.

    Attributes:
        weights: int64[n, 3]: rows and columns off an occupied cell, and what it weighs there.
        entry_cells: largest distance from a goal without room to the place that stands for it.
        exit_cells: the same for a place without room that a body has to leave.
    """

    weights: NDArray[np.int64] = field(
        default_factory=lambda: np.array([[0, 0, BESIDE_UNIT + 1]], dtype=np.int64)
    )
    entry_cells: float = 0.0
    exit_cells: float = 0.0

    @staticmethod
    def of_disc(
        radius_m: float, cell_m: float, depth_m: float, *, keeps_clear: bool = True
    ) -> Footprint:
        """The footprint of a round body.

        Args:
            radius_m: half of its diameter. cell_m: edge of a cell.
            depth_m: an occupied cell lies so far behind a wall's surface.
            keeps_clear: whether cells in which it may touch something are worse than others.
        """
        touch = (radius_m + depth_m) / cell_m
        tight = max(touch - 0.5, 0.5)
        beside = touch + 0.5 + SIDE_M / cell_m if keeps_clear else tight
        reach = math.ceil(beside)
        weights = [
            (row, col, BESIDE_UNIT + (math.hypot(row, col) < tight - 1e-9))
            for row in range(-reach, reach + 1)
            for col in range(-reach, reach + 1)
            if math.hypot(row, col) < beside - 1e-9
        ]
        # A goal in the corner of two walls is farther from any room than one along a wall.
        entry_m = 3.0 * radius_m + 2.0 * cell_m
        return Footprint(
            np.array(weights, dtype=np.int64), entry_m / cell_m, max(EXIT_M, entry_m) / cell_m
        )


@inlined
def weigh(status, crowd, row, col, rows, columns, weights, sign):  # type: ignore[no-untyped-def]
    """Add (sign 1) or take away (-1) the weight of an occupied cell on those round it.

    Args:
        status: uint8[C'], crowd: int32[C], of one map: written.
        row, col: the cell; rows, columns: the grid's shape; weights: of ``Footprint``.

    Returns:
        How many other cells have become tight; the first and last row with a change.
    """
    closed = 0
    low = row
    high = row
    for w in range(weights.shape[0]):
        near_row = row + weights[w, 0]
        near_col = col + weights[w, 1]
        if not (0 <= near_row < rows and 0 <= near_col < columns):
            continue
        near = near_row * columns + near_col
        crowd[near] += sign * weights[w, 2]
        was = status[near]
        now = was & ~(TIGHT | BESIDE)
        if crowd[near] > 0:
            now |= BESIDE
            if crowd[near] & (BESIDE_UNIT - 1):
                now |= TIGHT
        if now != was:
            status[near] = now
            closed += now & TIGHT != 0 and was & TIGHT == 0 and (near_row != row or near_col != col)
            low = min(low, near_row)
            high = max(high, near_row)
    return closed, low, high


@allocating
def _nearest(mask, wanted, status, cell, rows, columns, reach):  # type: ignore[no-untyped-def]
    """The nearest cell of some kind, by a flood over others that are not occupied.

    Args:
        mask, wanted: of that kind are cells with these bits of their status.

    Returns:
        Flat cell, `cell` itself if it is of that kind; of equally near ones the first; -1: none
        within `reach`, in cells.
    """
    if status[cell] & mask == wanted:
        return cell
    far = int(reach) + 1  # One more than needed: rounding must not lead out of the window.
    edge = 2 * far + 1
    seen = np.zeros((edge, edge), dtype=np.bool_)
    queue = np.empty(edge * edge, dtype=np.int64)
    row = cell // columns
    col = cell - row * columns
    top = row - far
    left = col - far
    queue[0] = cell
    seen[row - top, col - left] = True
    best = -1
    most2 = reach * reach + 1e-9
    best2 = most2
    head = 0
    tail = 1
    while head < tail:
        from_row = queue[head] // columns
        from_col = queue[head] - from_row * columns
        head += 1
        for d in range(4):
            near_row = from_row + (d == 0) - (d == 1)
            near_col = from_col + (d == 2) - (d == 3)
            if not (0 <= near_row < rows and 0 <= near_col < columns):
                continue
            off2 = (near_row - row) ** 2 + (near_col - col) ** 2
            if off2 > most2 or seen[near_row - top, near_col - left]:
                continue
            seen[near_row - top, near_col - left] = True
            near = near_row * columns + near_col
            if status[near] & LABEL_BITS == OCCUPIED:
                continue
            if status[near] & mask != wanted:
                queue[tail] = near
                tail += 1
            elif off2 < best2 or (off2 == best2 and near < best):
                best = near
                best2 = float(off2)
    return best


@inlined
def enter(status, cell, rows, columns, reach):  # type: ignore[no-untyped-def]
    """Where a body drives that is to get to a cell.

    To the nearest cell that is known to be free and clear of walls; if there is none, to one that
    is free and has room, and else to an unknown one.

    Args:
        status: uint8[C'], of one map.
        cell: flat; rows, columns: the grid's shape.
        reach: largest distance from the cell, in cells.

    Returns:
        Flat cell; -1: a body has no room near it.
    """
    if status[cell] & LABEL_BITS == OCCUPIED:
        return -1
    found = _nearest(LABEL_BITS | BESIDE, FREE, status, cell, rows, columns, reach)
    if found < 0:
        found = _nearest(LABEL_BITS | TIGHT, FREE, status, cell, rows, columns, reach)
    if found < 0:
        found = _nearest(TIGHT, 0, status, cell, rows, columns, reach)
    return found


@inlined
def get_out(status, cell, rows, columns, reach):  # type: ignore[no-untyped-def]
    """Where a body gets room that is in a cell; the cell itself if that or one beside it has some.

    And so if there is none near; the arguments are those of :func:`enter`.
    """
    row = cell // columns
    col = cell - row * columns
    for d in range(4):
        near_row = row + (d == 0) - (d == 1)
        near_col = col + (d == 2) - (d == 3)
        inside = 0 <= near_row < rows and 0 <= near_col < columns
        if inside and not status[near_row * columns + near_col] & TIGHT:
            return cell
    found = _nearest(TIGHT, 0, status, cell, rows, columns, reach)
    return cell if found < 0 else found


@kernel
def find_entries(status, cells, rows, columns, reach, found):  # type: ignore[no-untyped-def]
    """See :func:`enter`, for many cells.

    Args:
        status: uint8[C'], of one map; cells: int64[n], flat; rows, columns: the grid's shape.
        reach: largest distance, in cells; found: int64[n], written.
    """
    for k in range(cells.shape[0]):
        found[k] = enter(status, cells[k], rows, columns, reach)


@kernel
def find_exits(status, cells, rows, columns, reach, found):  # type: ignore[no-untyped-def]
    """See :func:`get_out`, for many cells; the arguments are those of :func:`find_entries`."""
    for k in range(cells.shape[0]):
        found[k] = get_out(status, cells[k], rows, columns, reach)
