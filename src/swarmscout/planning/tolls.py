"""Tolls: what a cell costs a route per metre, in the search's grid, which has a rim of one cell."""

from __future__ import annotations

from swarmscout.core.cells import cell_at
from swarmscout.core.enums import CHARGE
from swarmscout.core.jit import inlined, kernel
from swarmscout.mapping.footprint import BESIDE, STATION_ZONE, TIGHT
from swarmscout.mapping.occupancy import TILE

__all__ = ["STILL_STEPS", "fill_tolls", "mark_robots", "padded", "toll_robots", "unpadded"]

STILL_STEPS = 3
"""A robot that has not moved for so many steps stands."""

SILENT_STEPS = 10
"""One that has not been heard for so long may have no charge left, and stand there for good."""

STANDS, SILENT, EXPLORES, CHARGES = 0, 1, 2, 3
KINDS = 4


@inlined
def padded(cell, columns):  # type: ignore[no-untyped-def]
    """A cell of the grid in the numbers of ``Search``, which count the rim too."""
    return cell + 2 * (cell // columns) + columns + 3


@inlined
def unpadded(cell, columns):  # type: ignore[no-untyped-def]
    """The flat cell of the grid with a number that counts the rim."""
    return cell - 2 * (cell // (columns + 2)) - columns - 1


@inlined
def _toll(price, status, cell, search):  # type: ignore[no-untyped-def]
    """What a cell costs per metre; negative where a body has no room: as dear as can be."""
    if status[cell] & TIGHT:
        return -(search.base + 1000)
    p = price[cell]
    toll = search.base + p
    if status[cell] & BESIDE:
        toll += search.beside
    if status[cell] & STATION_ZONE:
        toll += search.station
    return toll + (search.unproven if p >= search.proven else 0)


@inlined
def _rows_matter(tile, across, bounds, search):  # type: ignore[no-untyped-def]
    """Whether tolls in a tile differ from those of an unknown map, or did in the map before."""
    row = tile // across * TILE
    low = min(search.filled_low, bounds[0])
    high = max(search.filled_high, bounds[1])
    return row <= high and row + TILE > low


@inlined
def fill_tolls(m, price, status, bounds, changed, toll, labelled, search):  # type: ignore[no-untyped-def]
    """Bring tolls up to date with a map: the tiles that changed, or all if it was another map.

    Args:
        m: which map. price, status, bounds, changed: see ``OccupancyGrids``.
        toll: written. labelled: bool[T], written: False for tiles whose tolls may have changed.
        search: SEARCH, see there.
    """
    columns = search.columns
    rows = price.shape[1] // columns
    across = (columns + TILE - 1) // TILE
    other = m != search.loaded
    newest = 0 if other else search.seen
    for tile in range(labelled.shape[0]):
        when = changed[m, tile]
        newest = max(newest, when)
        if when <= search.seen if not other else not _rows_matter(tile, across, bounds[m], search):
            continue
        labelled[tile] = False
        left = tile % across * TILE
        right = min(columns, left + TILE)
        for row in range(tile // across * TILE, min(rows, tile // across * TILE + TILE)):
            start = (row + 1) * (columns + 2) + 1
            for col in range(left, right):
                toll[start + col] = _toll(price[m], status[m], row * columns + col, search)
    search.loaded = m
    search.seen = newest
    search.filled_low = bounds[m, 0]
    search.filled_high = bounds[m, 1]


@kernel
def mark_robots(heard, still, rows, grid, step, marks):  # type: ignore[no-untyped-def]
    """List where robots are known to be, and whether they stand there or drive.

    Args:
        heard: BEACON[R, N], still: int64[R, N], rows: int64[A]: see ``Knowledge``.
        grid: DRIVING[1]; step: the current step.
        marks: int64[R, N], written for the rows in use: cell * KINDS + kind, or -1.
    """
    grid = grid[0]
    for r in rows:
        for j in range(heard.shape[1]):
            marks[r, j] = -1
            other = heard[r, j]
            if other.step == step:
                kind = CHARGES if other.mode == CHARGE else EXPLORES
                if still[r, j] >= STILL_STEPS:
                    kind = STANDS
            elif other.step >= 0 and step - other.step > SILENT_STEPS:
                kind = SILENT
            else:
                continue
            row, col = cell_at(other.x_m, other.y_m, grid)
            if 0 <= row < grid.rows and 0 <= col < grid.columns:
                marks[r, j] = (row * grid.columns + col) * KINDS + kind


@inlined
def _extra(kind, search):  # type: ignore[no-untyped-def]
    """What a robot adds to the toll of the cells round it."""
    if kind == SILENT:
        return 4 * search.standing
    if kind == STANDS:
        return search.standing
    # To keep out of the way of those who drive the other way parts the ways out and home.
    return 2 * search.standing // 3 if (kind == EXPLORES) == search.home else 0


@inlined
def toll_robots(price, status, toll, marks, labelled, search, dearer):  # type: ignore[no-untyped-def]
    """Make the cells in which robots are, and those round them, dearer, or put their tolls back.

    A body lies anywhere in its cell, and often leaves no room for another in the next one.

    Args:
        price, status: of one map. toll: written. marks: int64[N], see :func:`mark_robots`.
        labelled: see :func:`fill_tolls`, written. search: SEARCH.
        dearer: False puts back what a call with True has changed.
    """
    rows = price.shape[0] // search.columns
    tiles = (search.columns + TILE - 1) // TILE
    for mark in marks:
        extra = _extra(mark % KINDS, search) if mark >= 0 else 0
        if extra == 0:
            continue
        row, col = mark // KINDS // search.columns, mark // KINDS % search.columns
        for near_row in range(max(0, row - 1), min(rows, row + 2)):
            for near_col in range(max(0, col - 1), min(search.columns, col + 2)):
                near = near_row * search.columns + near_col
                at = padded(near, search.columns)
                fresh = _toll(price, status, near, search)
                labelled[near_row // TILE * tiles + near_col // TILE] = False
                if not dearer:
                    toll[at] = fresh
                elif fresh >= 0:
                    toll[at] = max(toll[at], fresh + extra)
                else:
                    toll[at] = min(toll[at], fresh - extra)
