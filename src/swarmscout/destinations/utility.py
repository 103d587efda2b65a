"""Utility minus cost, where a destination of others makes what lies round it less useful."""

from __future__ import annotations

from typing import Any

import numpy as np
from pydantic.dataclasses import dataclass

from swarmscout.core.parameters import STRICT, Amount, Metres
from swarmscout.destinations.crowding import crowding
from swarmscout.destinations.path_lengths import choice_of, ways_m
from swarmscout.destinations.selector import Choice
from swarmscout.destinations.view import LeaderView

__all__ = ["Utility"]


@dataclass(frozen=True, slots=True, config=STRICT)
class Utility:
    """Utility minus way; other teams' destinations make what is near them less useful.

    Each frontier's utility begins at 1, and each destination of another team at distance d takes
    ``max(0, 1 - d / range_m)`` off it. The leader takes the frontier with the highest utility minus
    ``beta_per_m`` times its way.

    Attributes:
        range_m: a destination makes frontiers up to here less useful.
        beta_per_m: what a metre of way costs, in utilities.

    Source: Burgard, Moors, Stachniss, Schneider (2005), "Coordinated multi-robot exploration", IEEE
        Transactions on Robotics. There a central loop assigns one robot after the other; made
        local: each leader discounts round the destinations that it last heard of, and takes its
        own best.
    """

    range_m: Metres = 29.0
    beta_per_m: Amount = 0.044

    def choose(self, view: LeaderView, memory: Any) -> Choice:
        """See :class:`swarmscout.destinations.selector.Selector`."""
        utility = 1.0 - crowding(view.others.destinations_m, view, self.range_m)
        ways = ways_m(view)
        chosen = int(np.argmax(utility - self.beta_per_m * ways))
        return choice_of(view, chosen, f"utility {utility[chosen]:.2f}, way {ways[chosen]:.1f} m")
