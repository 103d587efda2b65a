"""Any frontier, with equal probability."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from swarmscout.destinations.path_lengths import choice_of
from swarmscout.destinations.selector import Choice
from swarmscout.destinations.view import LeaderView

__all__ = ["Random"]


@dataclass(frozen=True, slots=True)
class Random:
    """Any frontier, with equal probability: the lower bound for a comparison."""

    def choose(self, view: LeaderView, memory: Any) -> Choice:
        """See :class:`swarmscout.destinations.selector.Selector`."""
        frontiers = len(view.frontiers)
        return choice_of(view, int(view.rng.integers(frontiers)), f"one of {frontiers} at random")
