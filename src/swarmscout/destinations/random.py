"""Any frontier, with equal probability."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from swarmscout.destinations.selector import Choice
from swarmscout.destinations.view import LeaderView

__all__ = ["Random"]


@dataclass(frozen=True, slots=True)
class Random:
    """Any frontier, with equal probability: the lower bound for a comparison."""

    def choose(self, view: LeaderView, memory: Any) -> Choice:
        """See :class:`swarmscout.destinations.selector.Selector`."""
        row, col = view.frontiers[view.rng.integers(len(view.frontiers))].tolist()
        return Choice((row, col), reason=f"one of {len(view.frontiers)} at random")
