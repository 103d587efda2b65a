"""Tolls: what a cell costs a route per metre, in the search's grid, which has a rim of one cell."""

from __future__ import annotations

from swarmscout.core.jit import inlined
from swarmscout.mapping.footprint import BESIDE, STATION_ZONE, TIGHT

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
def fill_tolls(price, status, bounds, toll, search):  # type: ignore[no-untyped-def]
    """Set the tolls of all rows that differ from those of an unknown map, or did before."""
    columns = search.columns
    for row in range(min(search.filled_low, bounds[0]), max(search.filled_high, bounds[1]) + 1):
        start = (row + 1) * (columns + 2) + 1
        for col in range(columns):
            toll[start + col] = _toll(price, status, row * columns + col, search)
    search.filled_low = bounds[0]
    search.filled_high = bounds[1]


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
