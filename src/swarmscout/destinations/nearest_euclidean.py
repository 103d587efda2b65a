"""The nearest frontier in a straight line."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from swarmscout.destinations.path_lengths import choice_of
from swarmscout.destinations.selector import Choice
from swarmscout.destinations.view import LeaderView

__all__ = ["NearestEuclidean"]


@dataclass(frozen=True, slots=True)
class NearestEuclidean:
    """The nearest frontier in a straight line from the team; ties go to the first cell.

    Source: Yamauchi (1998), "Frontier-based exploration using multiple robots", Autonomous Agents.
        Decentralized in the original: robots share the map and decide alone.
    """

    def choose(self, view: LeaderView, memory: Any) -> Choice:
        """See :class:`swarmscout.destinations.selector.Selector`."""
        chosen = int(np.argmin(view.distances_m))
        return choice_of(view, chosen, f"nearest, {view.distances_m[chosen]:.2f} m away")
