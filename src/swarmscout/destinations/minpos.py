"""MinPos: the frontier to which the fewest other teams are nearer."""

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
    takes the frontier where its rank is lowest; among several, the one with the shortest path.

    Source: Bautin, Simonin, Charpillet (2012), "MinPos: a novel frontier allocation algorithm for
        multi-robot exploration", ICIRA. Decentralized in the original. Here, unlike there,
        ranks use straight-line distances to a frontier's nearest cell for all teams, the own one
        included; path lengths would need a search for each team.
    """

    def choose(self, view: LeaderView, memory: Any) -> Choice:
        """See :class:`swarmscout.destinations.selector.Selector`."""
        places_m = np.concatenate([np.array([view.position_m]), view.others.positions_m])
        ways = ways_m(view)
        # Frontiers without a path come last, independent of their rank.
        ranks = nearest_to_clusters(places_m, view)[1][view.clusters]
        ranks += len(places_m) * (ways >= NO_WAY_M)
        chosen = int(np.lexsort((ways, ranks))[0])
        return choice_of(view, chosen, f"rank {ranks[chosen]}, way {ways[chosen]:.1f} m")
