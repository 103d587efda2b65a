"""An artificial potential: frontiers attract, other teams repel."""

from __future__ import annotations

from typing import Any

import numpy as np

from swarmscout.core.parameters import Amount, Metres, checked_dataclass
from swarmscout.destinations.crowding import push_kernel
from swarmscout.destinations.path_lengths import choice_of, ways_m
from swarmscout.destinations.selector import Choice
from swarmscout.destinations.view import LeaderView

__all__ = ["Potential"]


@checked_dataclass
class Potential:
    """The frontier with the lowest potential: short paths attract, other teams repel.

    The potential is the path length in metres plus ``push_m3 / 2 · (1 / d - 1 / range_m)²`` for
    each position and each destination of another team at a distance d within ``range_m``.

    Attributes:
        range_m: distance within which other teams repel.
        push_m3: strength of the repulsion.

    Source: Khatib (1986), "Real-time obstacle avoidance for manipulators and mobile robots" (the
        repulsive term); Howard, Matarić, Sukhatme (2002), "Mobile sensor network deployment using
        potential fields" (robots that repel each other). A decentralized method. Here the
        potential is compared at frontiers only, as routes avoid obstacles.
    """

    range_m: Metres = 30.5
    push_m3: Amount = 2020.0

    def choose(self, view: LeaderView, memory: Any) -> Choice:
        """See :class:`swarmscout.destinations.selector.Selector`."""
        others = view.others
        push = np.zeros(len(view.frontiers))
        # No nearer than half a cell: a team may stand on a frontier.
        for points_m in (others.positions_m, others.destinations_m):
            push_kernel(points_m, view.frontiers_m, 0.5 * view.frame.cell_m, self.range_m, push)
        push *= self.push_m3
        ways = ways_m(view)
        chosen = int(np.argmin(ways + push))
        return choice_of(view, chosen, f"way {ways[chosen]:.1f} m, push {push[chosen]:.1f} m")
