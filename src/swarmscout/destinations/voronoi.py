"""Frontiers in the team's own Voronoi cell first."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from swarmscout.destinations.path_lengths import choice_of, ways_m
from swarmscout.destinations.selector import Choice
from swarmscout.destinations.view import LeaderView

__all__ = ["Voronoi"]


@dataclass(frozen=True, slots=True)
class Voronoi:
    """The nearest frontier that is nearer to the own team than to any other; else the nearest.

    Source: Solanas, Garcia (2004), "Coordinated multi-robot exploration through unsupervised
        clustering of unknown space", IROS: frontiers of the own region first. In the original a
        central k-means makes the regions. Decentralized here: each leader uses the Voronoi cell of
        its own position among those of other teams as last heard, by path length.
    """

    def choose(self, view: LeaderView, memory: Any) -> Choice:
        """See :class:`swarmscout.destinations.selector.Selector`."""
        ways = ways_m(view)
        own = view.in_own_voronoi_cell
        if own.any():
            chosen = int(np.argmin(np.where(own, ways, np.inf)))
            return choice_of(view, chosen, f"nearest in the own cell, way {ways[chosen]:.1f} m")
        chosen = int(np.argmin(ways))
        return choice_of(view, chosen, f"none in the own cell: nearest, way {ways[chosen]:.1f} m")
