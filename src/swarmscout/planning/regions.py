"""Regions of a map: what is connected within a tile, for ways that lead far.

A search for a route to a goal far away would look at each cell for which the cost is less, on a
large map at millions. So only the first part of such a route is planned cell by cell. Where it
leads to is found in the graph of regions: a region is the connected open cells of a tile, and two
are neighbours if cells of theirs are. Regions are connected exactly where cells are. What it costs
to get from one to the next is estimated, by the mean price of their cells.

Source: Botea, Müller, Schaeffer (2004), "Near optimal hierarchical path-finding"; regions instead
of entrances, as Sturtevant (2007), "Memory-efficient abstractions for pathfinding".
"""

from __future__ import annotations

import heapq
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from swarmscout.core.grid import GridFrame
from swarmscout.core.jit import allocating, inlined
from swarmscout.mapping.occupancy import TILE

__all__ = [
    "TILE",
    "Regions",
    "blank_regions",
    "find_far_ways",
    "list_cells",
    "region_of",
    "way_ahead",
]

MOST = 16
"""Regions of a tile; if there are more, the last one is what is left, connected or not."""

WINDOW = 4
"""Steps over which the length of a way is measured."""

CLOSED = 255
NO_REGION = -1


class Regions(NamedTuple):
    """Scratch memory of the search over regions; C cells, T tiles, M = 16 T regions.

    Attributes:
        piece: uint8[C], which region of its tile a cell belongs to; CLOSED for none.
        labelled: bool[T], whether that is known for the present tolls.
        whole: bool[T], whether a tile has no closed cell.
        toll: int64[M], the mean of a region's cells.
        reached: int64[M], in which search a region was reached last.
        cost: int64[M], estimated cost to the goal; toward: int64[M], the next region on the way
            there, NO_REGION at the goal.
        queue: int64[TILE²], cells of a tile.
        tiles: int64[2], tiles in a column and in a row.
    """

    piece: NDArray[np.uint8]
    labelled: NDArray[np.bool_]
    whole: NDArray[np.bool_]
    toll: NDArray[np.int64]
    reached: NDArray[np.int64]
    cost: NDArray[np.int64]
    toward: NDArray[np.int64]
    queue: NDArray[np.int64]
    tiles: NDArray[np.int64]


def blank_regions(frame: GridFrame) -> Regions:
    """Scratch memory for a grid."""
    tiles = np.array([-(-frame.rows // TILE), -(-frame.columns // TILE)], dtype=np.int64)
    count = int(tiles.prod())
    return Regions(
        piece=np.zeros(frame.size, dtype=np.uint8),
        labelled=np.zeros(count, dtype=np.bool_),
        whole=np.zeros(count, dtype=np.bool_),
        toll=np.zeros(MOST * count, dtype=np.int64),
        reached=np.full(MOST * count, -1, dtype=np.int64),
        cost=np.zeros(MOST * count, dtype=np.int64),
        toward=np.zeros(MOST * count, dtype=np.int64),
        queue=np.zeros(TILE * TILE, dtype=np.int64),
        tiles=tiles,
    )


@inlined
def _bounds(tile, rows, columns, regions):  # type: ignore[no-untyped-def]
    """First row and column of a tile, and those behind its last."""
    top = tile // regions.tiles[1] * TILE
    left = tile % regions.tiles[1] * TILE
    return top, left, min(rows, top + TILE), min(columns, left + TILE)


@inlined
def _flood(cell, piece, toll, bounds, columns, regions):  # type: ignore[no-untyped-def]
    """Give a cell, and all that it is connected with in its tile, to a piece.

    Returns:
        The sum of their tolls, and how many they are.
    """
    top, left, bottom, right = bounds
    regions.piece[cell] = piece
    regions.queue[0] = cell
    head = 0
    tail = 1
    total = 0
    while head < tail:
        cell = regions.queue[head]
        head += 1
        row = cell // columns
        col = cell - row * columns
        total += toll[(row + 1) * (columns + 2) + col + 1]
        for d in range(4):
            near_row = row + (d == 0) - (d == 1)
            near_col = col + (d == 2) - (d == 3)
            if not (top <= near_row < bottom and left <= near_col < right):
                continue
            near = near_row * columns + near_col
            if regions.piece[near] != CLOSED:
                continue
            if toll[(near_row + 1) * (columns + 2) + near_col + 1] >= 0:
                regions.piece[near] = piece
                regions.queue[tail] = near
                tail += 1
    return total, tail


@inlined
def _label(tile, toll, regions, rows, columns):  # type: ignore[no-untyped-def]
    """Find the regions of a tile, unless they are known."""
    if regions.labelled[tile]:
        return
    regions.labelled[tile] = True
    bounds = _bounds(tile, rows, columns, regions)
    top, left, bottom, right = bounds
    closed = 0
    total = 0
    for row in range(top, bottom):
        for col in range(left, right):
            price = toll[(row + 1) * (columns + 2) + col + 1]
            closed += price < 0
            total += price
    regions.whole[tile] = closed == 0
    # Most tiles of a large map have no closed cell.
    first = 0 if closed == 0 else CLOSED
    for row in range(top, bottom):
        regions.piece[row * columns + left : row * columns + right] = first
    if closed == 0:
        regions.toll[tile * MOST] = total // ((bottom - top) * (right - left))
        return
    piece = 0
    sums = 0
    cells = 0
    for row in range(top, bottom):
        for col in range(left, right):
            cell = row * columns + col
            if regions.piece[cell] != CLOSED or toll[(row + 1) * (columns + 2) + col + 1] < 0:
                continue
            total, count = _flood(cell, piece, toll, bounds, columns, regions)
            if piece < MOST - 1:
                regions.toll[tile * MOST + piece] = total // count
                piece += 1
            else:
                sums += total
                cells += count
                regions.toll[tile * MOST + piece] = sums // cells


@inlined
def region_of(cell, toll, regions, rows, columns):  # type: ignore[no-untyped-def]
    """The region of a flat cell; of one that is closed, that of a cell beside it; or NO_REGION."""
    row = cell // columns
    col = cell - row * columns
    for d in range(5):
        near_row = row + (d == 1) - (d == 2)
        near_col = col + (d == 3) - (d == 4)
        if not (0 <= near_row < rows and 0 <= near_col < columns):
            continue
        tile = near_row // TILE * regions.tiles[1] + near_col // TILE
        _label(tile, toll, regions, rows, columns)
        piece = regions.piece[near_row * columns + near_col]
        if piece != CLOSED:
            return tile * MOST + piece
    return NO_REGION


@inlined
def list_cells(region, regions, rows, columns, cells):  # type: ignore[no-untyped-def]
    """Write the flat cells of a region into int64[TILE²]; returns how many."""
    top, left, bottom, right = _bounds(region // MOST, rows, columns, regions)
    n = 0
    for row in range(top, bottom):
        for col in range(left, right):
            if regions.piece[row * columns + col] == region % MOST:
                cells[n] = row * columns + col
                n += 1
    return n


@inlined
def _beyond(tile, side, regions):  # type: ignore[no-untyped-def]
    """The tile on one side (up, down, right, left) of another; -1: there is none."""
    row = tile // regions.tiles[1]
    col = tile - row * regions.tiles[1]
    row += (side == 0) - (side == 1)
    col += (side == 2) - (side == 3)
    if not (0 <= row < regions.tiles[0] and 0 <= col < regions.tiles[1]):
        return -1
    return row * regions.tiles[1] + col


@inlined
def _across(side, k, bounds):  # type: ignore[no-untyped-def]
    """The k-th cell along one side of a tile: its row and column, and those of the cell beyond."""
    top, left, bottom, right = bounds
    if side == 0:
        return bottom - 1, left + k, bottom, left + k
    if side == 1:
        return top, left + k, top - 1, left + k
    if side == 2:
        return top + k, right - 1, top + k, right
    return top + k, left, top + k, left - 1


@allocating
def find_far_ways(toll, regions, goals, costs, starts, search, rows):  # type: ignore[no-untyped-def]
    """Search the regions from goals until those of all starts are reached, or no other is left.

    Args:
        toll: see ``Search``; regions: written.
        goals: int64[n], flat cells; costs: int64[n], what each costs besides.
        starts: int64[k], flat cells.
        search: SEARCH, see there.
        rows: of the grid.
    """
    columns, now = search.columns, search.count
    heap = [(np.int64(0), np.int64(0))]
    heap.pop()
    for g in range(goals.shape[0]):
        region = region_of(goals[g], toll, regions, rows, columns)
        if region != NO_REGION and (
            regions.reached[region] != now or costs[g] < regions.cost[region]
        ):
            regions.reached[region] = now
            regions.cost[region] = costs[g]
            regions.toward[region] = NO_REGION
            heapq.heappush(heap, (np.int64(costs[g]), np.int64(region)))
    waiting = np.empty(starts.shape[0], dtype=np.int64)
    left = 0
    for s in range(starts.shape[0]):
        waiting[left] = region_of(starts[s], toll, regions, rows, columns)
        left += waiting[left] != NO_REGION
    while left > 0 and len(heap) > 0:
        cost, region = heapq.heappop(heap)
        if cost > regions.cost[region]:
            continue
        s = 0
        while s < left:
            if waiting[s] == region:
                left -= 1
                waiting[s] = waiting[left]
            else:
                s += 1
        tile = region // MOST
        bounds = _bounds(tile, rows, columns, regions)
        for side in range(4):
            beyond = _beyond(tile, side, regions)
            if beyond < 0:
                continue
            _label(beyond, toll, regions, rows, columns)
            last = np.int64(NO_REGION)
            length = bounds[3] - bounds[1] if side < 2 else bounds[2] - bounds[0]
            if regions.whole[tile] and regions.whole[beyond]:
                length = 1
            for k in range(length):
                row, col, to_row, to_col = _across(side, k, bounds)
                piece = regions.piece[to_row * columns + to_col]
                if regions.piece[row * columns + col] != region % MOST or piece == CLOSED:
                    continue
                other = beyond * MOST + piece
                if other == last:
                    continue
                last = other
                total = cost + TILE * search.straight * (regions.toll[region] + regions.toll[other])
                if regions.reached[other] != now or total < regions.cost[other]:
                    regions.reached[other] = now
                    regions.cost[other] = total
                    regions.toward[other] = region
                    heapq.heappush(heap, (np.int64(total), np.int64(other)))


@inlined
def way_ahead(region, steps, regions, search):  # type: ignore[no-untyped-def]
    """Follow the way from a region to the goal.

    Returns:
        The region a number of steps ahead; the number of steps to the goal; and the length of the
        way behind the former in mm, of which what is not known to be free counts twice.
    """
    ahead = region
    n = 0
    way_mm = 0
    window = region
    while regions.toward[region] != NO_REGION:
        region = regions.toward[region]
        n += 1
        if n == steps:
            ahead = region
            window = region
            way_mm = 0
        elif n % WINDOW == 0 or regions.toward[region] == NO_REGION:
            # Over a few tiles at a time: a way does not go round the corner of each.
            cols = abs(region // MOST % regions.tiles[1] - window // MOST % regions.tiles[1])
            rows = abs(region // MOST // regions.tiles[1] - window // MOST // regions.tiles[1])
            low = min(rows, cols)
            length = TILE * (low * search.diagonal + (max(rows, cols) - low) * search.straight)
            unknown = 500 + search.unproven
            price = min(unknown, max(0, regions.toll[region] - search.base))
            way_mm += length + length * price // unknown
            window = region
    return ahead, n, way_mm
