"""Where robots that charge drive to and stand, from the positions of the stations."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from swarmscout.core.grid import GridFrame

__all__ = ["dock_cells", "lay_places", "station_zone"]

MOST_PLACES = 48
"""A robot notes in the bits of a number which places it has tried."""


def dock_cells(frame: GridFrame, stations_m: NDArray[np.float64]) -> NDArray[np.int64]:
    """The cells that a route to a station ends in: the station's own, and those round it.

    Several, since a station's own cell may be partly wall, or taken.

    Args:
        frame: the grid.
        stations_m: float64[k, 2] in metres.

    Returns:
        int64[n, 2], flat cells whose centres lie within 1.5 cells of a station, and which.
    """
    found = [
        (cell, s)
        for s in range(len(stations_m))
        for cell in _cells_within(frame, stations_m[s], 1.5 * frame.cell_m)
    ]
    return np.array(found, dtype=np.int64).reshape(-1, 2)


def station_zone(
    frame: GridFrame, stations_m: NDArray[np.float64], range_m: float
) -> NDArray[np.int64]:
    """int64[n], flat cells within the charging range of stations, in metres, float64[k, 2]."""
    cells = {cell for station in stations_m for cell in _cells_within(frame, station, range_m)}
    return np.array(sorted(cells), dtype=np.int64)


def lay_places(
    frame: GridFrame, stations_m: NDArray[np.float64], within_m: float, apart_m: float
) -> NDArray[np.int64]:
    """Cells in which robots stand when they charge, for each station from the inside out.

    Args:
        frame: the grid.
        stations_m: float64[k, 2] in metres.
        within_m: so near to the station, at most.
        apart_m: so far from each other, at least.

    Returns:
        int64[k, P], flat cells, -1 after the last.
    """
    places = np.full((len(stations_m), MOST_PLACES), -1, dtype=np.int64)
    for s, station in enumerate(stations_m):
        cells = np.array(_cells_within(frame, station, within_m), dtype=np.int64)
        centres = frame.centres_of(frame.unflat_many(cells))
        order = np.argsort(np.round(np.hypot(*(centres - station).T), 6), kind="stable")
        n = 0
        taken = np.empty((0, 2))
        for c in order.tolist():
            gaps = np.hypot(*(taken - centres[c]).T)
            if (gaps >= apart_m - 1e-9).all() and n < MOST_PLACES:
                places[s, n] = cells[c]
                taken = np.vstack((taken, centres[c]))
                n += 1
    return places


def _cells_within(frame: GridFrame, point: NDArray[np.float64], within_m: float) -> list[int]:
    """Flat cells whose centres lie within a distance of a point, ascending."""
    x_m, y_m = float(point[0]), float(point[1])
    row, col = frame.cell_of(x_m, y_m)
    about = int(within_m / frame.cell_m) + 1
    found = []
    for near_row in range(max(0, row - about), min(frame.rows, row + about + 1)):
        for near_col in range(max(0, col - about), min(frame.columns, col + about + 1)):
            x, y = frame.centre_of(near_row, near_col)
            if (x - x_m) ** 2 + (y - y_m) ** 2 <= within_m**2:
                found.append(frame.flat(near_row, near_col))
    return found
