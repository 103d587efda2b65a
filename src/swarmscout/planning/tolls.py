"""Tolls: what a cell costs a route per metre, in the search's grid, which has a rim of one cell."""

from __future__ import annotations

from swarmscout.core.jit import inlined
from swarmscout.mapping.footprint import BESIDE, STATION_ZONE, TIGHT
from swarmscout.mapping.occupancy import TILE

__all__ = ["fill_tolls", "padded", "toll_standing"]


@inlined
def padded(cell, columns):  # type: ignore[no-untyped-def]
    """A cell of the grid in the numbers of ``Search``, which count the rim too."""
    return cell + 2 * (cell // columns) + columns + 3


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


@inlined
def toll_standing(price, status, toll, standing, search, more):  # type: ignore[no-untyped-def]
    """Make the cells in which robots stand for long dearer, or put them back (`more` = 0)."""
    for e in range(standing.shape[0]):
        cell = standing[e]
        extra = more
        if cell < -1:
            cell = -2 - cell
            extra = 4 * more
        if cell >= 0:
            fresh = _toll(price, status, cell, search)
            toll[padded(cell, search.columns)] = fresh + (extra if fresh >= 0 else -extra)
