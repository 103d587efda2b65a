"""How far frontiers are, as most rules want to know it, and the nearest of some."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from swarmscout.destinations.selector import Choice
from swarmscout.destinations.view import LeaderView

__all__ = ["NO_WAY_M", "choice_of", "ways_m"]

NO_WAY_M = 1000.0
"""So much farther are frontiers to which no way over free cells is known: they come last."""


def ways_m(view: LeaderView) -> NDArray[np.float64]:
    """float64[F], ways over free cells; where there is none, NO_WAY_M and the straight distance.

    Finite, so a rule always finds something to choose.
    """
    return np.where(np.isinf(view.path_length_m), NO_WAY_M + view.distances_m, view.path_length_m)


def choice_of(view: LeaderView, chosen: int, reason: str, memory: object = None) -> Choice:
    """The choice of the frontier at a place in the view's list."""
    row, col = view.frontiers[chosen].tolist()
    return Choice((row, col), reason=reason, memory=memory)
