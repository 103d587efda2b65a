"""Kernels behind the features of a leader's view: quantities of many frontiers at once.

Paths here lead over cells that are *known* to be free. A route may also lead through unknown cells
(see ``planning.search``), but a search over these takes twenty times as long, and the known part of
the map is enough to compare frontiers.
"""

from __future__ import annotations

import numpy as np

from swarmscout.core.components import root_of
from swarmscout.core.enums import OCCUPIED, UNKNOWN
from swarmscout.core.jit import kernel
from swarmscout.destinations.walking import FAR, begin_walk, end_walk, walk_on
from swarmscout.mapping.footprint import FRONTIER, LABEL_BITS

__all__ = ["count_around", "count_within", "label_clusters", "locate", "walk"]


@kernel
def locate(flat, ox, oy, cell_m, columns, cells, centres_m):  # type: ignore[no-untyped-def]
    """Rows, columns and centres of flat cells, as ``GridFrame`` computes them.

    Args:
        flat: int64[F]; ox, oy, cell_m, columns: the grid's frame.
        cells: int64[F, 2], centres_m: float64[F, 2], written.
    """
    for f in range(flat.shape[0]):
        row = flat[f] // columns
        col = flat[f] - row * columns
        cells[f, 0] = row
        cells[f, 1] = col
        centres_m[f, 0] = ox + (col + 0.5) * cell_m
        centres_m[f, 1] = oy + (row + 0.5) * cell_m


@kernel
def count_around(status, cells, rows, columns, counts):  # type: ignore[no-untyped-def]
    """Frontier and occupied cells among the 8 neighbours of many cells.

    Args:
        status: uint8[C'], of one map, see ``OccupancyGrids``.
        cells: int64[F], flat cells; rows, columns: the grid's shape.
        counts: int64[2, F], written: frontiers, occupied.
    """
    for f in range(cells.shape[0]):
        row = cells[f] // columns
        col = cells[f] - row * columns
        counts[0, f] = 0
        counts[1, f] = 0
        for near_row in range(max(0, row - 1), min(rows, row + 2)):
            for near_col in range(max(0, col - 1), min(columns, col + 2)):
                if near_row == row and near_col == col:
                    continue
                near = status[near_row * columns + near_col]
                counts[0, f] += near & FRONTIER != 0
                counts[1, f] += near & LABEL_BITS == OCCUPIED


@kernel
def count_within(status, cells, half_widths, rows, columns, counts):  # type: ignore[no-untyped-def]
    """Cells of each kind in a disc around each of many cells, visible or not.

    Args:
        status: uint8[C'], of one map, see ``OccupancyGrids``.
        cells: int64[F], flat cells.
        half_widths: int64[r + 1], half the width of the disc 0 … r rows off its centre.
        rows, columns: the grid's shape.
        counts: int64[4, F], written: unknown, free, occupied, and those free ones that are
            frontiers.
    """
    reach = half_widths.shape[0] - 1
    for f in range(cells.shape[0]):
        row = cells[f] // columns
        col = cells[f] - row * columns
        all_of_them = 0
        unknown = 0
        occupied = 0
        frontier = 0
        for near_row in range(max(0, row - reach), min(rows, row + reach + 1)):
            half = half_widths[abs(near_row - row)]
            first = near_row * columns + max(0, col - half)
            last = near_row * columns + min(columns - 1, col + half)
            all_of_them += last - first + 1
            for near in range(first, last + 1):
                label = status[near] & LABEL_BITS
                unknown += label == UNKNOWN
                occupied += label == OCCUPIED
                frontier += status[near] & FRONTIER != 0
        counts[0, f] = unknown
        counts[1, f] = all_of_them - unknown - occupied
        counts[2, f] = occupied
        counts[3, f] = frontier


@kernel
def label_clusters(cells, columns, places, labels):  # type: ignore[no-untyped-def]
    """Label groups of frontier cells that touch, at corners too.

    Args:
        cells: int64[F], flat frontier cells, ascending; columns: of the grid.
        places: int32[C], scratch: -1 everywhere, before and after.
        labels: int64[F], written: the cluster's number, from 0 in the order of first cells.

    Returns:
        The number of clusters.
    """
    size = places.shape[0]
    for f in range(cells.shape[0]):
        cell = cells[f]
        col = cell % columns
        labels[f] = f
        for d in range(4):
            # The neighbours that come before it: left, and three in the row before.
            near = cell - 1 if d == 0 else cell - columns + d - 2
            if (col == 0 and d in (0, 1)) or (col == columns - 1 and d == 3):
                continue
            if 0 <= near < size and places[near] >= 0:
                here = root_of(labels, f)
                there = root_of(labels, places[near])
                labels[max(here, there)] = min(here, there)
        places[cell] = f
    for f in range(cells.shape[0]):
        places[cells[f]] = -1
        labels[f] = root_of(labels, f)
    n = 0
    for f in range(cells.shape[0]):
        # A root comes before its descendants, so it is numbered when they are reached.
        if labels[f] == f:
            labels[f] = n
            n += 1
        else:
            labels[f] = labels[labels[f]]
    return n


@kernel
def walk(status, sources, targets, edge, lengths, gate, field, queues, found):  # type: ignore[no-untyped-def]
    """Lengths of the shortest paths over free cells from the nearest of some cells to many.

    Args:
        status: uint8[C'], of one map, see ``OccupancyGrids``.
        sources: int64[S], targets: int64[F], flat cells; a target of -1 has no path.
        edge, lengths, gate, field, queues: see :mod:`swarmscout.destinations.walking`.
        found: int64[2, F], written: the length in mm, -1 without a path; and the cell on the path
            that is farthest from the source within `gate`.
    """
    ends = np.empty((2, 2), dtype=np.int64)
    begin_walk(sources, field, queues, ends)
    walk_on(status, edge, lengths, gate, field, queues, ends, FAR)
    for t in range(targets.shape[0]):
        length = field[targets[t], 0] if targets[t] >= 0 else FAR
        found[0, t] = length if length != FAR else -1
        found[1, t] = field[targets[t], 1] if length != FAR else targets[t]
    end_walk(field, queues, ends)
