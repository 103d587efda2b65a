"""Pulled by frontiers, pushed off by other teams: an artificial potential."""

from __future__ import annotations

from typing import Any

import numpy as np
from pydantic.dataclasses import dataclass

from swarmscout.core.parameters import STRICT, Amount, Metres
from swarmscout.destinations.crowding import push_kernel
from swarmscout.destinations.path_lengths import choice_of, ways_m
from swarmscout.destinations.selector import Choice
from swarmscout.destinations.view import LeaderView

__all__ = ["Potential"]


@dataclass(frozen=True, slots=True, config=STRICT)
class Potential:
    """The frontier with the lowest potential: ways pull, other teams and their destinations push.

    The potential is the way in metres plus, for each other team's place and destination at a
    distance d within ``range_m``, ``push_m3 / 2 · (1 / d - 1 / range_m)²``.

    Attributes:
        range_m: others push up to here.
        push_m3: how hard.

    Source: Khatib (1986), "Real-time obstacle avoidance for manipulators and mobile robots" (the
        repulsive term); Howard, Matarić, Sukhatme (2002), "Mobile sensor network deployment using
        potential fields" (robots that push each other). A local method; here the potential is
        compared at frontiers only, as routes avoid obstacles by themselves.
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
