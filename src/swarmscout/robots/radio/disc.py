"""A radio of a fixed range: two robots hear each other up to a distance, walls or not."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import KDTree

from swarmscout.core.links import Links
from swarmscout.robots.bodies import Bodies
from swarmscout.worlds.world import World

__all__ = ["Disc", "near_pairs"]


@dataclass(frozen=True)
class Disc:
    """Robots hear each other up to a distance, through walls too.

    Attributes:
        range_m: the longest distance between centres, in metres.
    """

    range_m: float = 10.0

    def links(self, step: int, bodies: Bodies, world: World) -> Links:
        """Pairs of robots within range."""
        robots = len(bodies.alive)
        pairs = near_pairs(bodies.position, self.range_m)
        if len(pairs) == robots * (robots - 1) // 2:
            return Links.full(robots)
        both = np.concatenate((pairs, pairs[:, ::-1]))
        return Links.of_pairs(robots, both[:, 0], both[:, 1])


def near_pairs(position: NDArray[np.float64], range_m: float) -> NDArray[np.int64]:
    """Pairs of robots that are near each other.

    Args:
        position: float64[N, 2] in metres.
        range_m: the longest distance.

    Returns:
        int64[M, 2], each pair once, the lower robot first.
    """
    if len(position) < 2:
        return np.zeros((0, 2), dtype=np.int64)
    pairs: NDArray[np.int64] = KDTree(position).query_pairs(range_m, output_type="ndarray")
    return pairs.astype(np.int64)
