"""What a move of a route costs."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

__all__ = ["RouteCosts"]


@dataclass(frozen=True, slots=True)
class RouteCosts:
    """What moving costs, in integers.

    Attributes:
        straight: length of a move to an orthogonal neighbour, in mm.
        diagonal: of one to a diagonal neighbour.
        base: added to the price of every cell, in 1/1000: 1000 for "length", 0 for "probability".
        least: the lowest price of a cell without the base, in 1/1000 (for the heuristic).
        beside: added to the price of a cell in which a body may touch something occupied.
        standing: added to the price of the cells round a robot that is known to stand; four times
            as much if it is not heard any more, for it may have no charge left, and two thirds for
            one that drives home while the route leads out, or out while it leads home.
        station: added to the price of a cell in which others charge, for who does not.
        unproven: added, on the way to a station, to the price of a cell that is not known to be
            free …
        proven: … which is one whose price without the base is at least this.
        far_tiles: routes over more tiles than this are planned in parts, see ``planning.regions``;
            0: each is planned as a whole, and optimal.
    """

    straight: int
    diagonal: int
    base: int
    least: int
    beside: int = 1000
    standing: int = 3000
    station: int = 0
    unproven: int = 0
    proven: int = 1000
    far_tiles: int = 0

    def in_metres(self, cost: int | NDArray[np.int64]) -> float | NDArray[np.float64]:
        """A cost as metres of free way (price 1)."""
        return cost / 2e6
