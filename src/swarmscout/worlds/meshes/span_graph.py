"""From which floor one can drive onto which: spans as a graph, flooded by SciPy.

Where floors lie one above the other (a spiral, a bridge, two levels of a mine) a raster cannot
distinguish them; the graph of spans can.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array
from scipy.sparse.csgraph import breadth_first_order, connected_components

from swarmscout.core.grid import GridFrame
from swarmscout.core.jit import inlined, kernel
from swarmscout.worlds.meshes.span_heightfield import Spans
from swarmscout.worlds.meshes.walls import EAST, NORTH, Walls

__all__ = ["SpanGraph", "build_span_graph", "connected_spans", "ranks_from"]


@dataclass(frozen=True, eq=False)
class SpanGraph:
    """Which span of a neighbouring cell one can drive onto.

    Attributes:
        east: int32[n], for each span a span of the cell to the east, or −1.
        north: int32[n], the same to the north.
        walled_east: int8[n]: 0 no wall stands between a span and its eastern neighbour; 1 one does,
            in the span's own cell; 2 in the neighbour's.
        walled_north: int8[n], the same to the north.
    """

    east: NDArray[np.int32]
    north: NDArray[np.int32]
    walled_east: NDArray[np.int8]
    walled_north: NDArray[np.int8]


def build_span_graph(
    spans: Spans, walls: Walls, frame: GridFrame, step_m: float, clearance_m: float
) -> SpanGraph:
    """Link the spans of neighbouring cells that a robot can drive between, both ways.

    Args:
        spans: room over floors.
        walls: what stands between neighbours.
        frame: the raster.
        step_m: most difference in height between two neighbouring floors, and the highest wall
            that is driven over.
        clearance_m: how much room over both floors they must share.
    """
    found = []
    for offset, direction in ((1, EAST), (frame.columns, NORTH)):
        first = np.searchsorted(spans.cell, spans.cell + offset).astype(np.int32)
        key = 2 * spans.cell.astype(np.int64) + direction
        wall = np.searchsorted(walls.key, key).astype(np.int64)
        found += _link(
            spans.cell, spans.floor_m, spans.ceiling_m, first, offset,
            walls.key, walls.bottom_m, walls.top_m, walls.mine, wall, key, step_m, clearance_m,
        )  # fmt: skip
    east, walled_east, north, walled_north = found
    return SpanGraph(east, north, walled_east, walled_north)


def connected_spans(links: SpanGraph) -> NDArray[np.int32]:
    """Number connected spans alike: int32[n], from 0."""
    if not len(links.east):
        return np.empty(0, dtype=np.int32)
    labels: NDArray[np.int32] = connected_components(_graph(links), directed=False)[1]
    return labels


def ranks_from(links: SpanGraph, members: NDArray[np.bool_], start: int) -> NDArray[np.int32]:
    """In which order a flood from one span reaches the others.

    Args:
        links: of all spans.
        members: bool[n], the spans connected with the start.
        start: the span it sets out from, a member.

    Returns:
        int32[n], from 0; −1 for spans that are not reached.
    """
    among = np.flatnonzero(members)
    number = np.full(len(members), -1, dtype=np.int32)
    number[among] = np.arange(len(among), dtype=np.int32)
    east, north = links.east[among], links.north[among]
    inner = SpanGraph(
        np.where(east >= 0, number[east], -1), np.where(north >= 0, number[north], -1),
        links.walled_east[among], links.walled_north[among],
    )  # fmt: skip
    order = breadth_first_order(
        _graph(inner), int(number[start]), directed=False, return_predecessors=False
    )
    ranks = np.full(len(members), -1, dtype=np.int32)
    ranks[among[order]] = np.arange(len(order), dtype=np.int32)
    return ranks


def _graph(links: SpanGraph) -> csr_array:
    """The links as a matrix: row i holds the neighbours of span i to the east and north."""
    both = np.stack((links.east, links.north), axis=1)
    there = both >= 0
    ends = np.zeros(len(both) + 1, dtype=np.int32)
    np.cumsum(there.sum(axis=1), out=ends[1:])
    targets = both[there]
    ones = np.ones(len(targets), dtype=np.float64)
    return csr_array((ones, targets, ends), shape=(len(both), len(both)))


@inlined
def _wall_between(keys, bottom, top, mine, at, key, low, high):  # type: ignore[no-untyped-def]
    """0, or 1 or 2 for the side on which a wall stands that reaches between two heights."""
    while at < len(keys) and keys[at] == key:
        if bottom[at] < high and top[at] > low:
            return 1 if mine[at] else 2
        at += 1
    return 0


@kernel
def _link(  # type: ignore[no-untyped-def]
    cell, floor, ceiling, first, offset, keys, bottom, top, mine, wall, key, step, clearance
):
    """For each span the one over there that one can drive onto, and the wall between if any."""
    last_low, last_wall = np.int64(0), np.int64(0)
    to = np.full(len(cell), -1, dtype=np.int32)
    walled = np.zeros(len(cell), dtype=np.int8)
    for span in range(len(cell)):
        low, at = first[span], wall[span]
        if span > 0 and cell[span - 1] == cell[span]:
            # A cell's spans are sorted by height: what lay too low for the last one still does.
            low, at = last_low, last_wall
        while low < len(cell) and cell[low] == cell[span] + offset:
            if floor[low] >= floor[span] - step - 1e-3:
                break
            low += 1
        while at < len(keys) and keys[at] == key[span] and top[at] <= floor[span] + step:
            at += 1
        last_low, last_wall = low, at
        other = low
        while other < len(cell) and cell[other] == cell[span] + offset:
            if floor[other] > floor[span] + step + 1e-3:
                break
            level = max(floor[span], floor[other])
            lid = min(ceiling[span], ceiling[other])
            near = abs(floor[span] - floor[other]) <= step
            if near and lid - level >= clearance - 1e-6:
                between = _wall_between(
                    keys, bottom, top, mine, at, key[span], level + step, level + clearance
                )
                if between == 0:
                    to[span] = other
                    walled[span] = 0
                    break
                walled[span] = between
            other += 1
    return to, walled
