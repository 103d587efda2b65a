"""The reasons that the paper reports for its language model, as a score."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from swarmscout.core.parameters import Metres, checked_dataclass
from swarmscout.destinations.crowding import crowding
from swarmscout.destinations.path_lengths import choice_of
from swarmscout.destinations.selector import Choice
from swarmscout.destinations.view import LeaderView

__all__ = ["LlmLike"]


@checked_dataclass
class LlmLike:
    """A score of the paper's reasons: near, away from others, many frontiers, few obstacles.

    The score of a cell, in metres, falls with the straight-line distance, with nearness to other
    teams' destinations, and for each obstacle cell among its 8 neighbours; it rises for each
    frontier cell among them. It uses only what the paper's prompt contains.

    Attributes:
        apart_m: distance beyond which other teams' destinations cost nothing.
        shyness_m: cost of another team's destination in the same place.
        frontier_m: gain per frontier neighbour.
        obstacle_m: cost per obstacle neighbour.

    Source: paper, "LLM-based destination selection" (the reasons of its figure), as a formula.
        Decentralized like the paper's LLM: each leader scores by what it has heard.
    """

    apart_m: Metres = 25.0
    shyness_m: Metres = 17.0
    frontier_m: Metres = 0.098
    obstacle_m: Metres = 7.6

    def choose(self, view: LeaderView, memory: Any) -> Choice:
        """See :class:`swarmscout.destinations.selector.Selector`."""
        chosen = int(np.argmax(self.scores(view)))
        reason = (
            f"{view.distances_m[chosen]:.1f} m away, {view.frontier_neighbours[chosen]} frontier "
            f"and {view.obstacle_neighbours[chosen]} obstacle neighbours"
        )
        return choice_of(view, chosen, reason)

    def scores(self, view: LeaderView) -> NDArray[np.float64]:
        """float64[F], the score of each frontier, in metres."""
        return (
            self.frontier_m * view.frontier_neighbours
            - self.obstacle_m * view.obstacle_neighbours
            - view.distances_m
            - self.shyness_m * crowding(view.others.destinations_m, view, self.apart_m)
        )
