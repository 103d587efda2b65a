"""The nearest frontier by route."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from swarmscout.destinations.path_lengths import choice_of
from swarmscout.destinations.selector import Choice
from swarmscout.destinations.view import LeaderView

__all__ = ["Nearest"]


@dataclass(frozen=True, slots=True)
class Nearest:
    """The frontier with the cheapest route from the leader.

    Ties go to the first cell. Without a route to any frontier, the nearest in a straight line is
    chosen.

    Source: Yamauchi (1998), "Frontier-based exploration using multiple robots".
    """

    def choose(self, view: LeaderView, memory: Any) -> Choice:
        """See :class:`swarmscout.destinations.selector.Selector`."""
        costs = view.route_costs(nearest=1)
        chosen = int(np.argmin(costs))
        if np.isinf(costs[chosen]):
            chosen = int(np.argmin(view.distances_m))
            reason = "no route to any frontier: the nearest in a straight line"
        else:
            reason = f"nearest by route, cost {costs[chosen]:.2f} m"
        return choice_of(view, chosen, reason)
