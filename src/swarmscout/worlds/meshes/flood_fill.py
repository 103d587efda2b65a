"""One floor per cell: what a flood through the spans reaches first."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from swarmscout.core.grid import GridFrame
from swarmscout.worlds.meshes.span_graph import SpanGraph, ranks_from
from swarmscout.worlds.meshes.span_heightfield import Spans

__all__ = ["FloodedFloor", "flood_fill"]

_ROOMY_M = 1.0


@dataclass(frozen=True, eq=False)
class FloodedFloor:
    """What was reached, as rasters that are cut to it.

    Attributes:
        frame: where they lie.
        floor_m: float32[rows, cols], NaN where nothing was reached.
        ceiling_m: float32[rows, cols], infinite under open sky, NaN where nothing was reached.
        brink: bool[rows, cols], reached cells that have to be wall, because a neighbour that was
            reached too is not linked: at a thin wall, a ledge, or where another level begins.
        other_level: how many cells have more than one floor that was reached.
    """

    frame: GridFrame
    floor_m: NDArray[np.float32]
    ceiling_m: NDArray[np.float32]
    brink: NDArray[np.bool_]
    other_level: int


def flood_fill(
    spans: Spans,
    links: SpanGraph,
    frame: GridFrame,
    members: NDArray[np.bool_],
    start: int,
    roof: bool = False,
) -> FloodedFloor:
    """Flood from a span; where floors lie one above the other the one reached first counts.

    The flood goes through places with head room first, and then through low ones; with a roof
    it goes under it first, or the land above a cave would take the cells of the cave.

    Args:
        spans: room over floors.
        links: between them.
        frame: the whole raster.
        members: bool[n], the spans connected with the start.
        start: the span to set out from.
        roof: whether only floor under a ceiling counts.
    """
    ranks = ranks_from(links, members, start)
    # Spans with head room first, or the pocket under a ramp would take cells from the ramp.
    roomy = members & (spans.ceiling_m - spans.floor_m >= _ROOMY_M)
    for sooner in (roomy, roomy & np.isfinite(spans.ceiling_m)) if roof else (roomy,):
        if sooner[start]:
            first = ranks_from(links, sooner, start)
            ranks = np.where(first >= 0, first, ranks + np.where(ranks >= 0, len(ranks), 0))
    reached = np.flatnonzero(ranks >= 0)
    # By cell, and within a cell by rank: the first of each cell is kept.
    order = reached[np.lexsort((ranks[reached], spans.cell[reached]))]
    cells = spans.cell[order]
    first = np.ones(len(order), dtype=np.bool_)
    first[1:] = cells[1:] != cells[:-1]
    kept = order[first].astype(np.int32)
    several = int(np.count_nonzero(np.diff(np.append(np.flatnonzero(first), len(cells))) > 1))

    row, col = np.divmod(spans.cell[kept], frame.columns)
    top, left = int(row.min()) - 1, int(col.min()) - 1
    shape = int(row.max()) - top + 2, int(col.max()) - left + 2
    window = GridFrame(
        round((left + round(frame.origin_x_m / frame.cell_m)) * frame.cell_m, 9),
        round((top + round(frame.origin_y_m / frame.cell_m)) * frame.cell_m, 9),
        frame.cell_m, *shape,
    )  # fmt: skip
    span_of = np.full(shape, -1, dtype=np.int32)
    span_of[row - top, col - left] = kept
    floor, ceiling = (
        np.where(span_of >= 0, heights[span_of], np.float32(np.nan))
        for heights in (spans.floor_m, spans.ceiling_m)
    )
    brink = np.zeros(shape, dtype=np.bool_)
    for axis, to, walled in (
        (1, links.east, links.walled_east),
        (0, links.north, links.walled_north),
    ):
        here, there = _neighbours(span_of, axis)
        apart = (here >= 0) & (there >= 0) & (to[here] != there)
        wall = walled[here]
        # The cell of the wall, or the higher of two floors: there is an edge where it ends.
        height, other = _neighbours(floor, axis)
        mine = np.where(wall == 0, height >= other, wall == 1)
        near, far = _neighbours(brink, axis)
        near |= apart & mine
        far |= apart & ~mine
    return FloodedFloor(window, floor, ceiling, brink, several)


def _neighbours(raster: NDArray[Any], axis: int) -> tuple[NDArray[Any], NDArray[Any]]:
    """Views of all cells that have a neighbour to the north (0) or east (1), and of those."""
    return (raster[:-1], raster[1:]) if axis == 0 else (raster[:, :-1], raster[:, 1:])
