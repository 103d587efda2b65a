"""A* over the occupancy grid, with occupancy probability as cost (paper, "Task description").

Moves go to the 8 neighbours. A move costs its length times the mean price of the two cells, where a
cell's price per metre is 1 + p ("length") or p alone ("probability", the paper to the letter).
Deviation: the scenario ``paper`` takes 1 + p, so that well-seen cells are not almost free; and a
cell in which a robot is known to stand for long is dearer.
Occupied cells are impassable and corners are not cut. Costs are integers, so optimal is exact.

The search runs backwards, from the goal to the robots: members of a team share their destination,
and one search serves all that ask in the same step. Routes are then read off in a fixed order of
directions among *all* optimal ones, so a route depends on map, start and goal, and not on who else
asked.

Source: Hart, Nilsson, Raphael (1968), "A formal basis for the heuristic determination of minimum
cost paths".
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from swarmscout.core.codes import ROUTE
from swarmscout.core.grid import GridFrame
from swarmscout.core.jit import inlined, kernel
from swarmscout.planning.route_table import AT, FAILED_UNTIL, GOAL, LENGTH, NEED, STATION, WANTED

__all__ = ["RouteCosts", "Search", "plan_routes", "route_cost_field"]

CELL_BITS = 24
"""Heap keys hold the cell in the lower bits and the cost above them."""

# Flags of a node in the running search; the search's number stands above them.
REACHED, SETTLED, START = 1, 2, 4
FLAG_BITS = 3

DIAGONAL_FIRST = 4
# Orthogonal neighbours first, then diagonal ones: the fixed order among equally good routes.
ROW_STEP = np.array([0, 1, 0, -1, 1, 1, -1, -1], dtype=np.int64)
COL_STEP = np.array([1, 0, -1, 0, 1, -1, -1, 1], dtype=np.int64)


@dataclass(frozen=True, slots=True)
class RouteCosts:
    """What moving costs, in integers.

    Attributes:
        straight: length of a move to an orthogonal neighbour, in mm.
        diagonal: of one to a diagonal neighbour.
        base: added to the price of every cell, in 1/1000: 1000 for "length", 0 for "probability".
        least: the lowest price of a cell without the base, in 1/1000 (for the heuristic).
        standing: added to the price of a cell in which a robot is known to stand for long.
    """

    straight: int
    diagonal: int
    base: int
    least: int
    standing: int = 3000

    def in_metres(self, cost: int | NDArray[np.int64]) -> float | NDArray[np.float64]:
        """A cost as metres of free way (price 1)."""
        return cost / 2e6


class Search:
    """Scratch memory of the search over one grid, reused from call to call.

    Attributes:
        nodes: int64[C, 2], per cell: in which search it was touched last with the flags below it,
            and its cost there. Both in one place, for the search spends its time fetching them.
        extra: int64[C], added to the price of a cell; 0 between calls.
        heap: int64[8 C + 16]: a cell is pushed at most once per neighbour that improves it.
        searches: int64[1], counts searches.
    """

    def __init__(self, frame: GridFrame) -> None:
        self.nodes = np.zeros((frame.size, 2), dtype=np.int64)
        self.extra = np.zeros(frame.size, dtype=np.int64)
        self.heap = np.zeros(8 * frame.size + 16, dtype=np.int64)
        self.searches = np.zeros(1, dtype=np.int64)


@inlined
def _push(heap, n, key):  # type: ignore[no-untyped-def]
    """Add a key to a binary heap of n; returns n + 1."""
    child = n
    while child > 0:
        parent = (child - 1) >> 1
        if heap[parent] <= key:
            break
        heap[child] = heap[parent]
        child = parent
    heap[child] = key
    return n + 1


@inlined
def _pop(heap, n):  # type: ignore[no-untyped-def]
    """Remove the least key heap[0] from a binary heap of n; returns n - 1."""
    n -= 1
    key = heap[n]
    parent = 0
    while True:
        child = 2 * parent + 1
        if child >= n:
            break
        if child + 1 < n and heap[child + 1] < heap[child]:
            child += 1
        if heap[child] >= key:
            break
        heap[parent] = heap[child]
        parent = child
    heap[parent] = key
    return n


@inlined
def _way_out(row, col, box, straight, diagonal, price):  # type: ignore[no-untyped-def]
    """The least that a way from a cell to the nearest cell of a box can cost."""
    dr = max(box[0] - row, 0, row - box[1])
    dc = max(box[2] - col, 0, col - box[3])
    low = min(dr, dc)
    return (low * diagonal + (max(dr, dc) - low) * straight) * 2 * price


@inlined
def _step_price(price, extra, cell, base):  # type: ignore[no-untyped-def]
    p = price[cell]
    if p < 0:
        # Only where a robot stands already, or starts from: as dear as can be.
        p = 1000
    return base + p + extra[cell]


@inlined
def _may_step(price, row, col, new_row, new_col, columns):  # type: ignore[no-untyped-def]
    """Whether a diagonal move cuts no corner."""
    return price[row * columns + new_col] >= 0 and price[new_row * columns + col] >= 0


@inlined
def _flags(nodes, cell, now):  # type: ignore[no-untyped-def]
    """The flags of a cell in search number `now`."""
    mark = nodes[cell, 0]
    return mark & (REACHED | SETTLED | START) if mark >> FLAG_BITS == now else 0


@inlined
def _spread(price, extra, nodes, now, heap, n, waiting, box, rows, columns, lengths):  # type: ignore[no-untyped-def]
    """Settle cells from the seeds in the heap until `waiting` starts, and all that ties, are."""
    straight, diagonal, base, least = lengths[0], lengths[1], lengths[2], lengths[3]
    bound = -1
    while n > 0:
        key = heap[0]
        cell = key & ((1 << CELL_BITS) - 1)
        if waiting <= 0 and (key >> CELL_BITS) > bound:
            break
        n = _pop(heap, n)
        flags = _flags(nodes, cell, now)
        if flags & SETTLED:
            continue
        nodes[cell, 0] |= SETTLED
        so_far = nodes[cell, 1]
        if flags & START:
            waiting -= 1
            bound = max(bound, so_far)
            if price[cell] < 0:
                # A robot may leave an occupied cell, but no route leads through it.
                continue
        row = cell // columns
        col = cell - row * columns
        here = _step_price(price, extra, cell, base)
        for d in range(8):
            new_row = row + ROW_STEP[d]
            new_col = col + COL_STEP[d]
            if new_row < 0 or new_row >= rows or new_col < 0 or new_col >= columns:
                continue
            new = new_row * columns + new_col
            flags = _flags(nodes, new, now)
            if flags & SETTLED or (price[new] < 0 and not flags & START):
                continue
            length = straight
            if d >= DIAGONAL_FIRST:
                if not _may_step(price, row, col, new_row, new_col, columns):
                    continue
                length = diagonal
            total = so_far + length * (here + _step_price(price, extra, new, base))
            if not flags & REACHED or total < nodes[new, 1]:
                nodes[new, 0] = (now << FLAG_BITS) | flags | REACHED
                nodes[new, 1] = total
                f = total + _way_out(new_row, new_col, box, straight, diagonal, base + least)
                n = _push(heap, n, (f << CELL_BITS) | new)
    return n


@inlined
def _read_off(price, extra, nodes, now, rows, columns, lengths, start, route):  # type: ignore[no-untyped-def]
    """Follow optimal moves from a settled start to cost 0; returns the number of cells."""
    n = 0
    cell = start
    while nodes[cell, 1] > 0:
        row = cell // columns
        col = cell % columns
        here = _step_price(price, extra, cell, lengths[2])
        for d in range(8):
            new_row = row + ROW_STEP[d]
            new_col = col + COL_STEP[d]
            if new_row < 0 or new_row >= rows or new_col < 0 or new_col >= columns:
                continue
            new = new_row * columns + new_col
            if not _flags(nodes, new, now) & REACHED or price[new] < 0:
                continue
            length = lengths[0]
            if d >= DIAGONAL_FIRST:
                if not _may_step(price, row, col, new_row, new_col, columns):
                    continue
                length = lengths[1]
            there = _step_price(price, extra, new, lengths[2])
            if nodes[new, 1] + length * (here + there) == nodes[cell, 1]:
                cell = new
                break
        else:
            return -1
        if n < route.shape[0]:
            route[n] = cell
        n += 1
    return n


@kernel
def plan_routes(  # type: ignore[no-untyped-def]
    price, extra, nodes, searches, heap, lengths, at_cell, dearer, standing, docks,
    plan, route, route_cost, columns, step, events, count,
):  # fmt: skip
    """Plan a route for every robot that needs one.

    Args:
        price: int16[K, C], see ``OccupancyGrids``.
        extra, nodes, searches, heap: scratch, see ``Search``.
        lengths: int64[5]: straight, diagonal, base, least, standing, see ``RouteCosts``.
        at_cell: int64[N], the cell that each robot believes to be in.
        dearer: int64[K, n], cells in which robots stand for long, -1 for none.
        standing: how many entries each row of `dearer` has at most.
        docks: int64[k], cells near the charging stations.
        plan: int64[N, columns], route: int32[N, longest], route_cost: int64[N]: ``RouteTable``.
        columns: of the grid; step: the current step; events, count: see ``core.codes``.
    """
    robots = plan.shape[0]
    rows = price.shape[1] // columns
    box = np.empty(4, dtype=np.int64)
    for i in range(robots):
        if plan[i, NEED] != 1:
            continue
        m = i if price.shape[0] > 1 else 0
        goal = plan[i, WANTED]
        for e in range(standing):
            if dearer[m, e] >= 0:
                extra[dearer[m, e]] = lengths[4]
        searches[0] += 1
        now = searches[0]
        waiting = 0
        box[0], box[1], box[2], box[3] = rows, -1, columns, -1
        # Everybody who shares this map and wants to get there too.
        for j in range(i, robots):
            if plan[j, NEED] != 1 or plan[j, WANTED] != goal:
                continue
            if price.shape[0] > 1 and j != i:
                continue
            plan[j, NEED] = 2
            cell = at_cell[j]
            if not _flags(nodes, cell, now) & START:
                nodes[cell, 0] = (now << FLAG_BITS) | START
                waiting += 1
            box[0] = min(box[0], cell // columns)
            box[1] = max(box[1], cell // columns)
            box[2] = min(box[2], cell % columns)
            box[3] = max(box[3], cell % columns)
        n = 0
        for s in range(docks.shape[0] if goal == STATION else 1):
            seed = docks[s] if goal == STATION else goal
            flags = _flags(nodes, seed, now)
            if price[m, seed] >= 0 and not flags & REACHED:
                nodes[seed, 0] = (now << FLAG_BITS) | flags | REACHED
                nodes[seed, 1] = 0
                f = _way_out(
                    seed // columns, seed % columns, box, lengths[0], lengths[1],
                    lengths[2] + lengths[3],
                )  # fmt: skip
                n = _push(heap, n, (f << CELL_BITS) | seed)
        _spread(price[m], extra, nodes, now, heap, n, waiting, box, rows, columns, lengths)
        for j in range(i, robots):
            if plan[j, NEED] != 2:
                continue
            plan[j, NEED] = 0
            plan[j, GOAL] = goal
            plan[j, AT] = 0
            start = at_cell[j]
            length = -1
            if _flags(nodes, start, now) & SETTLED:
                length = _read_off(
                    price[m], extra, nodes, now, rows, columns, lengths, start, route[j]
                )
            plan[j, LENGTH] = max(length, 0)
            route_cost[j] = nodes[start, 1] if length >= 0 else -1
            plan[j, FAILED_UNTIL] = 0 if length >= 0 else step + 10
            events[count[0], 0] = ROUTE
            events[count[0], 1] = j
            events[count[0], 2] = length
            events[count[0], 3] = goal
            count[0] += 1
        for e in range(standing):
            if dearer[m, e] >= 0:
                extra[dearer[m, e]] = 0


@kernel
def route_cost_field(  # type: ignore[no-untyped-def]
    price, extra, nodes, searches, heap, lengths, start, targets, at_most, columns, found
):
    """Costs of the best routes from one cell to many: a search that spreads from the start.

    Args:
        price: int16[C], one map; extra, nodes, searches, heap: scratch, see ``Search``.
        lengths: int64[5], see ``RouteCosts``.
        start: flat cell; targets: int64[n], flat cells.
        at_most: the search stops once so many targets (and all at equal cost) are settled.
        columns: of the grid.
        found: int64[n], written: the cost for each target, -1 where it was not settled.
    """
    rows = price.shape[0] // columns
    searches[0] += 1
    now = searches[0]
    waiting = 0
    for t in range(targets.shape[0]):
        if price[targets[t]] >= 0 and not _flags(nodes, targets[t], now) & START:
            nodes[targets[t], 0] = (now << FLAG_BITS) | START
            waiting += 1
    waiting = min(waiting, at_most)
    # A box over everything: no heuristic, so cells are settled in the order of their cost.
    box = np.array([0, rows, 0, columns], dtype=np.int64)
    nodes[start, 0] = (now << FLAG_BITS) | _flags(nodes, start, now) | REACHED
    nodes[start, 1] = 0
    if waiting > 0:
        n = _push(heap, 0, start)
        _spread(price, extra, nodes, now, heap, n, waiting, box, rows, columns, lengths)
    for t in range(targets.shape[0]):
        settled = _flags(nodes, targets[t], now) & SETTLED
        found[t] = nodes[targets[t], 1] if settled else -1
