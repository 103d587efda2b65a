"""Where fewest other teams are nearer: MinPos."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from swarmscout.destinations.crowding import nearest_to_clusters
from swarmscout.destinations.path_lengths import NO_WAY_M, choice_of, ways_m
from swarmscout.destinations.selector import Choice
from swarmscout.destinations.view import LeaderView

__all__ = ["MinPos"]


@dataclass(frozen=True, slots=True)
class MinPos:
    """The frontier (a group of cells) to which fewest other teams are nearer; then the nearest.

    The leader's rank at a frontier is the number of other teams that are strictly nearer to it. It
    goes to the frontier where its rank is lowest, to the nearest by way among several.

    Source: Bautin, Simonin, Charpillet (2012), "MinPos: a novel frontier allocation algorithm for
        multi-robot exploration", ICIRA. Decentralized in the original. Here, unlike there,
        distances in ranks are straight lines to a frontier's nearest cell, for the own team and
        others alike; ways of all teams to all frontiers would cost a search for each team.
    """

    def choose(self, view: LeaderView, memory: Any) -> Choice:
        """See :class:`swarmscout.destinations.selector.Selector`."""
        places_m = np.concatenate([np.array([view.position_m]), view.others.positions_m])
        ways = ways_m(view)
        # Frontiers without a way come last, whatever their rank.
        ranks = nearest_to_clusters(places_m, view)[1][view.clusters]
        ranks += len(places_m) * (ways >= NO_WAY_M)
        chosen = int(np.lexsort((ways, ranks))[0])
        return choice_of(view, chosen, f"rank {ranks[chosen]}, way {ways[chosen]:.1f} m")
