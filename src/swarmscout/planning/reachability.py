"""Which cells a route connects at all, without its cost: components of the cells with room.

A route moves to the 8 neighbours and cuts no corner, so two cells are connected exactly if they
are over the 4 neighbours. Open cells of a row form runs, and runs of neighbouring rows that overlap
belong together: a union-find over runs looks at each cell once, however many robots ask.

Source: He, Chao, Suzuki (2008), "A run-based two-scan labeling algorithm".
"""

from __future__ import annotations

import numpy as np

from swarmscout.core.components import root_of
from swarmscout.core.jit import inlined, kernel
from swarmscout.mapping.footprint import TIGHT

__all__ = ["find_connected"]


@inlined
def _find_runs(status, words, first, last, begins, ends, n):  # type: ignore[no-untyped-def]
    """Append the runs of cells with room among the flat cells first … last - 1.

    Returns:
        How many runs there are then.
    """
    tight = np.uint64(0x0808080808080808)
    cell = first
    is_open = False
    while cell < last:
        if cell & 7 == 0 and cell + 8 <= last:
            word = words[cell >> 3] & tight
            if word == (np.uint64(0) if is_open else tight):
                cell += 8
                continue
        if (status[cell] & TIGHT == 0) != is_open:
            is_open = not is_open
            if is_open:
                begins[n] = cell
            else:
                ends[n] = cell
                n += 1
        cell += 1
    if is_open:
        ends[n] = last
        n += 1
    return n


@inlined
def _join_rows(begins, ends, above, here, beyond, columns, parents):  # type: ignore[no-untyped-def]
    """Join the runs of one row (above … here - 1) with those of the next (here … beyond - 1)."""
    a = above
    b = here
    while a < here and b < beyond:
        if begins[a] + columns < ends[b] and begins[b] < ends[a] + columns:
            one = root_of(parents, a)
            other = root_of(parents, b)
            parents[max(one, other)] = min(one, other)
        if ends[a] + columns < ends[b]:
            a += 1
        else:
            b += 1


@inlined
def _component(cell, low, high, columns, first_run, begins, ends, parents):  # type: ignore[no-untyped-def]
    """The component of a cell with room; -1: it has none."""
    row = cell // columns
    # Rows beyond those with evidence are open all along, and so is the nearest that was looked at.
    beyond = min(high, max(low, row)) - row
    cell += beyond * columns
    at = first_run[row + beyond - low]
    after = first_run[row + beyond - low + 1]
    while at < after:
        middle = (at + after) // 2
        if ends[middle] <= cell:
            at = middle + 1
        else:
            after = middle
    inside = at < first_run[row + beyond - low + 1] and begins[at] <= cell
    return root_of(parents, at) if inside else -1


@kernel
def find_connected(status, words, bounds, rows, columns, start, cells, found):  # type: ignore[no-untyped-def]
    """Which cells a route from one cell leads to.

    Args:
        status: uint8[C'], of one map; words: the same, eight cells a word.
        bounds: int64[2], first and last row with evidence, see ``OccupancyGrids``.
        rows, columns: the grid's shape.
        start: flat cell; a body can leave it, even if it has no room there.
        cells: int64[n], flat cells, -1 for none; found: bool[n], written.
    """
    low = max(0, min(rows - 1, bounds[0] - 1))
    high = min(rows - 1, max(low, bounds[1] + 1))
    first_run = np.zeros(high - low + 2, dtype=np.int64)
    most = (high - low + 1) * (columns // 2 + 1)
    begins = np.empty(most, dtype=np.int64)
    ends = np.empty(most, dtype=np.int64)
    n = 0
    for row in range(low, high + 1):
        n = _find_runs(status, words, row * columns, (row + 1) * columns, begins, ends, n)
        first_run[row - low + 1] = n
    parents = np.arange(n)
    for row in range(high - low):
        _join_rows(
            begins, ends, first_run[row], first_run[row + 1], first_run[row + 2], columns, parents
        )
    roots = np.full(5, -1, dtype=np.int64)
    row = start // columns
    col = start - row * columns
    for d in range(5):
        near_row = row + (d == 1) - (d == 2)
        near_col = col + (d == 3) - (d == 4)
        # Out of a cell without room it gets to those beside it; back into it, it does not.
        if 0 <= near_row < rows and 0 <= near_col < columns and (d == 0 or roots[0] < 0):
            roots[d] = _component(
                near_row * columns + near_col, low, high, columns, first_run, begins, ends, parents
            )
    for k in range(cells.shape[0]):
        found[k] = False
        if cells[k] >= 0:
            root = _component(cells[k], low, high, columns, first_run, begins, ends, parents)
            for d in range(5):
                found[k] = found[k] or (root >= 0 and root == roots[d])
