"""Path lengths to frontiers, always finite, and the choice of a frontier by its index."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from swarmscout.destinations.selector import Choice
from swarmscout.destinations.view import LeaderView

__all__ = ["NO_WAY_M", "choice_of", "ways_m"]

NO_WAY_M = 1000.0
"""Added to the distance of frontiers without a known path over free cells: they come last."""


def ways_m(view: LeaderView) -> NDArray[np.float64]:
    """float64[F], path lengths over free cells; without a path NO_WAY_M plus the straight line.

    They are finite, so that a selector can always choose.
    """
    return np.where(np.isinf(view.path_length_m), NO_WAY_M + view.distances_m, view.path_length_m)


def choice_of(view: LeaderView, chosen: int, reason: str, memory: object = None) -> Choice:
    """The choice of the frontier at an index of the view's list."""
    row, col = view.frontiers[chosen].tolist()
    return Choice((row, col), reason=reason, memory=memory)
