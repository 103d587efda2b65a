"""Much unknown area within reach, over a short path."""

from __future__ import annotations

from typing import Any

import numpy as np

from swarmscout.core.parameters import Amount, Metres, checked_dataclass
from swarmscout.destinations.path_lengths import choice_of, ways_m
from swarmscout.destinations.selector import Choice
from swarmscout.destinations.view import LeaderView

__all__ = ["InformationGain"]


@checked_dataclass
class InformationGain:
    """Most unknown area within the sensor's reach, discounted by the length of the path.

    The leader takes the frontier with the highest ``A · exp(-decay_per_m · L)``, where A is the
    unknown area within reach of it and L the length of the path to it.

    Attributes:
        reach_m: radius around a frontier in which unknown area counts.
        decay_per_m: rate at which the gain decays with the path length.

    Source: González-Baños, Latombe (2002), "Navigation strategies for exploring indoor
        environments", International Journal of Robotics Research. The original is for one robot, so
        it is decentralized. A counts the cells in a disc instead of casting rays.
    """

    reach_m: Metres = 1.9
    decay_per_m: Amount = 0.33

    def choose(self, view: LeaderView, memory: Any) -> Choice:
        """See :class:`swarmscout.destinations.selector.Selector`."""
        ways = ways_m(view)
        areas = view.unknown_m2(self.reach_m)
        # The logarithm of the score: far frontiers stay comparable where exp would give 0.
        chosen = int(np.argmax(np.log(np.maximum(areas, 1e-9)) - self.decay_per_m * ways))
        return choice_of(
            view, chosen, f"{areas[chosen]:.2f} m² unknown in reach, way {ways[chosen]:.1f} m"
        )
