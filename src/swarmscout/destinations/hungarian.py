"""The cheapest assignment of frontiers to all teams, from which each leader takes its own row."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from swarmscout.destinations.crowding import nearest_to_clusters
from swarmscout.destinations.path_lengths import choice_of, ways_m
from swarmscout.destinations.selector import Choice
from swarmscout.destinations.view import LeaderView

__all__ = ["Hungarian"]


@dataclass(frozen=True, slots=True)
class Hungarian:
    """The own row of the cheapest assignment of frontiers (groups of cells) to all teams.

    No two teams get the same frontier, and the sum of distances is minimal. With fewer frontiers
    than teams, a leader that gets none takes the nearest.

    Source: Kuhn (1955), "The Hungarian method for the assignment problem"; for exploration Ko,
        Stewart, Fox, Konolige, Limketkai (2003), IROS. Central in the original. Decentralized
        here: each leader solves the problem for all teams as last heard, its own included, and
        takes its own row. Distances are straight lines, so that leaders with the same knowledge
        solve the same problem.
    """

    def choose(self, view: LeaderView, memory: Any) -> Choice:
        """See :class:`swarmscout.destinations.selector.Selector`."""
        # Importing it takes longer than a mission with another selector.
        from scipy.optimize import linear_sum_assignment

        # In the order of leaders, for every solver: among several cheapest, all take the same one.
        own = int(np.searchsorted(view.others.leaders, view.robot))
        places_m = np.insert(view.others.positions_m, own, view.position_m, axis=0)
        teams, assigned = linear_sum_assignment(nearest_to_clusters(places_m, view)[0])
        ways = ways_m(view)
        mine = np.isin(view.clusters, assigned[teams == own])
        if mine.any():
            reason = "assigned among {} teams, way {:.1f} m"
        else:
            mine = np.ones(len(ways), dtype=np.bool_)
            reason = "none left of {} teams: the nearest, way {:.1f} m"
        chosen = int(np.argmin(np.where(mine, ways, np.inf)))
        return choice_of(view, chosen, reason.format(len(places_m), ways[chosen]))
