"""A search over known free cells that can pause: the kernels of this package continue it.

A move has one of two lengths, so a queue for each length is sorted by itself: the search of
Dijkstra (1959) without a heap. Free cells without room for a body are not passed, and no corner of
one is cut.
"""

from __future__ import annotations

import numpy as np

from swarmscout.core.enums import FREE
from swarmscout.core.jit import allocating, inlined
from swarmscout.mapping.footprint import LABEL_BITS, TIGHT

__all__ = ["CELL_BITS", "FAR", "begin_walk", "end_walk", "walk_on"]

FAR = 2**38
CELL_BITS = 24
"""An entry of a queue is one number: the cell in the lower bits and the path length above."""

HEAD, TAIL = 0, 1  # of a queue: its first entry, and the place behind its last

# Orthogonal neighbours first, then diagonal ones.
ROW_STEP = np.array([0, 1, 0, -1, 1, 1, -1, -1], dtype=np.int64)
COL_STEP = np.array([1, 0, -1, 0, 1, -1, -1, 1], dtype=np.int64)


@inlined
def begin_walk(sources, field, queues, ends):  # type: ignore[no-untyped-def]
    """Begin a search from some cells.

    Args:
        sources: int64[S], flat cells of any kind, occupied ones too.
        field: int64[C, 2], FAR in column 0; written: path lengths in mm, and the cell on each path
            that is farthest from its source within a distance, see :func:`walk_on`.
        queues: int64[2, 2 C], written: path length and cell of each entry.
        ends: int64[2, 2], written: where each queue begins and ends.
    """
    ends[:] = 0
    for source in sources:
        if field[source, 0] != 0:
            field[source, 0] = 0
            field[source, 1] = source
            queues[0, ends[0, TAIL]] = source
            ends[0, TAIL] += 1


@allocating
def walk_on(status, edge, lengths, gate, field, queues, ends, until):  # type: ignore[no-untyped-def]
    """Continue a search; afterwards all path lengths up to a limit are the least.

    Args:
        status: uint8[C'], of one map, see ``OccupancyGrids``.
        edge: bool[rows, columns], whether a cell lies at the grid's edge.
        lengths: int64[2], of an orthogonal and a diagonal move, in mm.
        gate: the distance within which a path's cell is kept in column 1 of `field`, in mm.
        field, queues, ends: see :func:`begin_walk`.
        until: the limit, in mm.

    Returns:
        Whether there is anything left to search.
    """
    rows = edge.shape[0]
    columns = edge.shape[1]
    at_edge = edge.ravel()
    straight = queues[0]
    diagonal = queues[1]
    head_0, tail_0 = ends[0, HEAD], ends[0, TAIL]
    head_1, tail_1 = ends[1, HEAD], ends[1, TAIL]
    while head_0 < tail_0 or head_1 < tail_1:
        first = head_1 == tail_1 or (head_0 < tail_0 and straight[head_0] <= diagonal[head_1])
        waiting = straight[head_0] if first else diagonal[head_1]
        so_far = waiting >> CELL_BITS
        if so_far > until:
            break
        head_0 += first
        head_1 += not first
        cell = waiting & ((1 << CELL_BITS) - 1)
        if so_far > field[cell, 0]:
            continue
        row = 1
        col = 1
        if at_edge[cell]:
            row = cell // columns
            col = cell - row * columns
        for d in range(4):
            if at_edge[cell] and not (
                0 <= row + ROW_STEP[d] < rows and 0 <= col + COL_STEP[d] < columns
            ):
                continue
            new = cell + ROW_STEP[d] * columns + COL_STEP[d]
            total = so_far + lengths[0]
            if total < field[new, 0] and status[new] & (LABEL_BITS | TIGHT) == FREE:
                field[new, 0] = total
                field[new, 1] = new if total <= gate else field[cell, 1]
                straight[tail_0] = (total << CELL_BITS) | new
                tail_0 += 1
        for d in range(4, 8):
            if at_edge[cell] and not (
                0 <= row + ROW_STEP[d] < rows and 0 <= col + COL_STEP[d] < columns
            ):
                continue
            new = cell + ROW_STEP[d] * columns + COL_STEP[d]
            total = so_far + lengths[1]
            if (
                total < field[new, 0]
                and status[new] & (LABEL_BITS | TIGHT) == FREE
                and not (status[cell + COL_STEP[d]] | status[cell + ROW_STEP[d] * columns]) & TIGHT
            ):
                field[new, 0] = total
                field[new, 1] = new if total <= gate else field[cell, 1]
                diagonal[tail_1] = (total << CELL_BITS) | new
                tail_1 += 1
    ends[0, HEAD], ends[0, TAIL] = head_0, tail_0
    ends[1, HEAD], ends[1, TAIL] = head_1, tail_1
    return head_0 < tail_0 or head_1 < tail_1


@inlined
def end_walk(field, queues, ends):  # type: ignore[no-untyped-def]
    """Leave the field as it was before the search; the arguments are those of the others."""
    for q in range(2):
        for e in range(ends[q, TAIL]):
            field[queues[q, e] & ((1 << CELL_BITS) - 1), 0] = FAR
