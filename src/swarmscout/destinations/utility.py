"""Utility minus cost, where other teams' destinations reduce the utility around them."""

from __future__ import annotations

from typing import Any

import numpy as np

from swarmscout.core.parameters import Amount, Metres, checked_dataclass
from swarmscout.destinations.crowding import crowding
from swarmscout.destinations.path_lengths import choice_of, ways_m
from swarmscout.destinations.selector import Choice
from swarmscout.destinations.view import LeaderView

__all__ = ["Utility"]


@checked_dataclass
class Utility:
    """Utility minus path length; other teams' destinations reduce the utility near them.

    The utility of a frontier is 1, reduced by ``max(0, 1 - d / range_m)`` for each destination of
    another team at distance d. The leader takes the frontier with the highest utility minus
    ``beta_per_m`` times the length of the path to it.

    Attributes:
        range_m: distance within which a destination reduces the utility of frontiers.
        beta_per_m: cost per metre of path, in units of utility.

    Source: Burgard, Moors, Stachniss, Schneider (2005), "Coordinated multi-robot exploration", IEEE
        Transactions on Robotics. In the original a central loop assigns one robot after the other.
        Decentralized here: each leader uses the destinations that it last heard.
    """

    range_m: Metres = 29.0
    beta_per_m: Amount = 0.044

    def choose(self, view: LeaderView, memory: Any) -> Choice:
        """See :class:`swarmscout.destinations.selector.Selector`."""
        utility = 1.0 - crowding(view.others.destinations_m, view, self.range_m)
        ways = ways_m(view)
        chosen = int(np.argmax(utility - self.beta_per_m * ways))
        return choice_of(view, chosen, f"utility {utility[chosen]:.2f}, way {ways[chosen]:.1f} m")
