"""The plan of a maze: a net of small tubes between the points of an irregular lattice.

Source: for the net, Gabriel and Sokal, "A new statistical approach to geographic variation
analysis", 1969: two points are joined if no third lies in the circle over their connection, so that
no two tubes cross. Anastomosing ("maze") lava tubes look much like that.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from swarmscout.core.streams import stream
from swarmscout.worlds.passages import Passage, smooth_noise
from swarmscout.worlds.tube_parameters import TubeParameters

__all__ = ["plan_maze"]

_MAZE = 4
_CELLS_PER_WIDTH = 3.3
_KEPT = 0.5
"""Share of the net's tubes that stay, beyond those that hold it together."""
_MOUTH_M = 10.4


def plan_maze(parameters: TubeParameters) -> list[Passage]:
    """Plan the passages of a maze.

    Args:
        parameters: the maze's looks; its mesh is about three times the mean width of a tube.

    Returns:
        The passages; the first point of the first one is the mouth.
    """
    rng = stream(parameters.seed, "world", _MAZE)
    nodes = _nodes(rng, parameters)
    edges = _thinned(rng, nodes, _gabriel_edges(nodes))
    mouth = int(np.argmin(nodes[:, 0]))
    # The mouth's own tube comes first, and starts there.
    edges.sort(key=lambda edge: mouth not in edge)
    passages = []
    for number, (one, other) in enumerate(edges):
        if number == 0 and other == mouth:
            one, other = other, one
        passages.append(_tube(rng, parameters, nodes[one], nodes[other], number == 0))
    return passages


def _nodes(rng: np.random.Generator, parameters: TubeParameters) -> NDArray[np.float64]:
    """float64[n, 2]: random points in the square, no two near each other."""
    apart = _CELLS_PER_WIDTH * parameters.width_m
    tries = int(12.0 * (parameters.size_m / apart) ** 2) + 30
    points = np.round(rng.uniform(0.0, parameters.size_m, size=(tries, 2)), 6)
    nodes = np.empty_like(points)
    count = 0
    for point in points:
        gaps = point - nodes[:count]
        if (gaps[:, 0] ** 2 + gaps[:, 1] ** 2 >= apart * apart).all():
            nodes[count] = point
            count += 1
    return nodes[:count].copy()


def _gabriel_edges(nodes: NDArray[np.float64]) -> list[tuple[int, int]]:
    edges = []
    for one in range(len(nodes)):
        others = nodes[one + 1 :]
        middle = (nodes[one] + others) / 2
        radius2 = ((nodes[one] - middle) ** 2).sum(axis=1)
        across = nodes[None, :, 0] - middle[:, None, 0]
        up = nodes[None, :, 1] - middle[:, None, 1]
        near = (across * across + up * up < radius2[:, None] - 1e-6).any(axis=1)
        edges += [(one, one + 1 + int(other)) for other in np.flatnonzero(~near)]
    return edges


def _thinned(
    rng: np.random.Generator, nodes: NDArray[np.float64], edges: list[tuple[int, int]]
) -> list[tuple[int, int]]:
    """Leave some tubes out, in random order, but none that holds the net together."""
    group = list(range(len(nodes)))

    def root(node: int) -> int:
        while group[node] != node:
            node = group[node]
        return node

    kept = []
    for index, keep in zip(rng.permutation(len(edges)), rng.uniform(size=len(edges)), strict=True):
        one, other = edges[index]
        joins = root(one) != root(other)
        if joins:
            group[root(one)] = root(other)
        if joins or keep < _KEPT:
            kept.append((one, other))
    return sorted(kept)


def _tube(
    rng: np.random.Generator,
    parameters: TubeParameters,
    first: NDArray[np.float64],
    last: NDArray[np.float64],
    is_mouth: bool,
) -> Passage:
    """A winding tube between two points."""
    along = last - first
    length = float(np.sqrt((along * along).sum()))
    count = max(int(length), 4) + 1
    at = np.linspace(0.0, 1.0, count)
    aside = np.array([-along[1], along[0]]) / length
    hill = 1.0 - (2.0 * at - 1.0) ** 4
    sway = 0.75 * parameters.winding * parameters.width_m
    stray = sway * (0.65 * smooth_noise(rng, count, 9.0) + 0.25 * smooth_noise(rng, count, 4.0))
    points = first + at[:, None] * along + (stray * hill)[:, None] * aside
    half = parameters.width_m / 2 * float(rng.uniform(0.75, 1.15))
    vary = 0.75 * smooth_noise(rng, count, 8.0) + 0.35 * smooth_noise(rng, count, 4.0)
    widths = half * (1.0 + parameters.width_variation * vary)
    widths = np.clip(widths, parameters.narrowest_m / 2, parameters.widest_m / 2)
    if is_mouth:
        near = np.maximum(1.0 - (np.arange(count) / 9.0) ** 2, 0.0) ** 2
        widths = widths + np.maximum(_MOUTH_M / 2 - widths, 0.0) * near
    return Passage("trunk" if is_mouth else "braid", np.round(points, 6), widths)
