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

Most of a large swarm's time is spent here. So cells wait in buckets of nearly equal cost instead of
a heap: within a bucket they come in any order, and one that turns out cheaper after it was settled
is settled again. Once all buckets up to the farthest robot's are empty, every cost up to there is
the least.

Sources: Hart, Nilsson, Raphael (1968), "A formal basis for the heuristic determination of minimum
cost paths"; Dial (1969), "Algorithm 360: shortest-path forest with topological ordering".
"""

from __future__ import annotations

import numpy as np

from swarmscout.core.enums import ROUTE
from swarmscout.core.grid import GridFrame
from swarmscout.core.jit import inlined, kernel
from swarmscout.planning.costs import RouteCosts
from swarmscout.planning.route_table import AT, FAILED_UNTIL, GOAL, LENGTH, NEED, STATION, WANTED

__all__ = ["Search", "plan_routes", "route_cost_field"]

# Flags of a node in the running search; the search's number stands above them.
REACHED, SETTLED, START, OPEN = 1, 2, 4, 8
FLAG_BITS = 4

BUCKETS = 256
UNKNOWN_PRICE = 500
OUTSIDE = -(1 << 30)

DIAGONAL_FIRST = 4
# Orthogonal neighbours first, then diagonal ones: the fixed order among equally good routes.
ROW_STEP = np.array([0, 1, 0, -1, 1, 1, -1, -1], dtype=np.int64)
COL_STEP = np.array([1, 0, -1, 0, 1, -1, -1, 1], dtype=np.int64)
# Which orthogonal neighbours (as bits) a diagonal move passes between.
BETWEEN = np.array([0, 0, 0, 0, 0b0011, 0b0110, 0b1100, 0b1001], dtype=np.int64)


class Search:
    """Scratch memory of the search over one grid, reused from call to call.

    The grid has a rim of one cell here, so that no neighbour has to be looked for outside: P cells.

    Attributes:
        toll: int32[P], what a cell costs per metre in 1/1000; negative: only for robots that stand
            there already.
        filled: int64[2], the first and last row of the grid with tolls of a map.
        nodes: int64[P, 2], per cell: in which search it was touched last with the flags below it,
            and its cost there. Both in one place, for the search spends its time fetching them.
        queue: int32[P, 3], per open cell: those before and after it in its bucket (negative: none),
            and the number of the bucket.
        buckets: int32[BUCKETS], the first cell of each, used in turn; -1 for none.
        searches: int64[1], counts searches.
        lengths: int64[6], the five attributes of ``RouteCosts``, and how many bits of a cost a
            bucket spans: so many that a move changes a cost, with its heuristic, by less than half
            of all buckets.
    """

    def __init__(self, frame: GridFrame, costs: RouteCosts) -> None:
        size = (frame.rows + 2) * (frame.columns + 2)
        self.toll = np.full(size, OUTSIDE, dtype=np.int32)
        self.filled = np.array([0, frame.rows - 1], dtype=np.int64)
        self.nodes = np.zeros((size, 2), dtype=np.int64)
        self.queue = np.zeros((size, 3), dtype=np.int32)
        self.buckets = np.full(BUCKETS, -1, dtype=np.int32)
        self.searches = np.zeros(1, dtype=np.int64)
        most = 4 * costs.diagonal * (costs.base + 1000 + costs.standing)
        bits = max(0, most.bit_length() - (BUCKETS.bit_length() - 2))
        self.lengths = np.array(
            [costs.straight, costs.diagonal, costs.base, costs.least, costs.standing, bits],
            dtype=np.int64,
        )


@inlined
def _toll(price, cell, base):  # type: ignore[no-untyped-def]
    """What a cell costs per metre; negative where it is occupied: as dear as can be."""
    p = price[cell]
    return base + p if p >= 0 else -(base + 1000)


@inlined
def _fill_tolls(price, bounds, filled, toll, columns, base):  # type: ignore[no-untyped-def]
    """Set the tolls of all rows that differ from those of an unknown map, or did before."""
    for row in range(min(filled[0], bounds[0]), max(filled[1], bounds[1]) + 1):
        start = (row + 1) * (columns + 2) + 1
        for col in range(columns):
            toll[start + col] = _toll(price, row * columns + col, base)
    filled[0] = bounds[0]
    filled[1] = bounds[1]


@inlined
def _put(queue, buckets, cell, bucket, current):  # type: ignore[no-untyped-def]
    """Queue a cell; what is too far ahead waits in the last bucket."""
    slot = min(bucket, current + BUCKETS - 1) & (BUCKETS - 1)
    first = buckets[slot]
    queue[cell, 0] = -1 - slot
    queue[cell, 1] = first
    queue[cell, 2] = bucket
    if first >= 0:
        queue[first, 0] = cell
    buckets[slot] = cell


@inlined
def _take(queue, buckets, cell):  # type: ignore[no-untyped-def]
    """Remove a cell from its bucket."""
    before = queue[cell, 0]
    after = queue[cell, 1]
    if before >= 0:
        queue[before, 1] = after
    else:
        buckets[-1 - before] = after
    if after >= 0:
        queue[after, 0] = before


@inlined
def _padded(cell, columns):  # type: ignore[no-untyped-def]
    """A cell of the grid in the numbers of ``Search``, which count the rim too."""
    return cell + 2 * (cell // columns) + columns + 3


@inlined
def _way_out(cell, width, box, straight, diagonal, least):  # type: ignore[no-untyped-def]
    """The least that a way from a cell to the nearest cell of a box can cost."""
    row = cell // width
    col = cell - row * width
    dr = max(box[0] - row, 0, row - box[1])
    dc = max(box[2] - col, 0, col - box[3])
    low = min(dr, dc)
    return (low * diagonal + (max(dr, dc) - low) * straight) * 2 * least


@inlined
def _flags(nodes, cell, now):  # type: ignore[no-untyped-def]
    """The flags of a cell in search number `now`."""
    mark = nodes[cell, 0]
    return mark & ((1 << FLAG_BITS) - 1) if mark >> FLAG_BITS == now else 0


@inlined
def _spread(toll, nodes, queue, buckets, now, seeds, waiting, box, width, lengths):  # type: ignore[no-untyped-def]
    """Settle cells from the seeds until `waiting` starts, and all that cost no more, are."""
    straight, diagonal, least, bits = lengths[0], lengths[1], lengths[2] + lengths[3], lengths[5]
    current = 1 << 40
    for seed in seeds:
        current = min(current, _way_out(seed, width, box, straight, diagonal, least) >> bits)
    n = 0
    for seed in seeds:
        flags = _flags(nodes, seed, now)
        if not flags & OPEN:
            nodes[seed, 0] = (now << FLAG_BITS) | flags | REACHED | OPEN
            nodes[seed, 1] = 0
            bucket = _way_out(seed, width, box, straight, diagonal, least) >> bits
            _put(queue, buckets, seed, bucket, current)
            n += 1
    bound = -1
    while n > 0:
        cell = buckets[current & (BUCKETS - 1)]
        if cell < 0:
            current += 1
            continue
        if waiting <= 0 and current > bound:
            break
        _take(queue, buckets, cell)
        if queue[cell, 2] > current:
            _put(queue, buckets, cell, queue[cell, 2], current)
            continue
        n -= 1
        flags = nodes[cell, 0]
        nodes[cell, 0] = (flags | SETTLED) & ~OPEN
        cost = nodes[cell, 1]
        here = toll[cell]
        if flags & START:
            if not flags & SETTLED:
                waiting -= 1
            bound = max(bound, cost >> bits)
            if here < 0:
                # A robot may leave an occupied cell, but no route leads through it.
                continue
        here = abs(here)
        walls = 0
        for d in range(8):
            new = cell + ROW_STEP[d] * width + COL_STEP[d]
            price = toll[new]
            mark = nodes[new, 0]
            flags = mark & ((1 << FLAG_BITS) - 1) if mark >> FLAG_BITS == now else 0
            if price < 0:
                walls |= 1 << d
                if not flags & START:
                    continue
                price = -price
            length = straight
            if d >= DIAGONAL_FIRST:
                if walls & BETWEEN[d]:
                    continue
                length = diagonal
            total = cost + length * (here + price)
            if not flags & REACHED or total < nodes[new, 1]:
                if flags & OPEN:
                    _take(queue, buckets, new)
                else:
                    n += 1
                nodes[new, 0] = (now << FLAG_BITS) | flags | REACHED | OPEN
                nodes[new, 1] = total
                f = total + _way_out(new, width, box, straight, diagonal, least)
                _put(queue, buckets, new, f >> bits, current)
    while n > 0:
        cell = buckets[current & (BUCKETS - 1)]
        while cell >= 0:
            cell = queue[cell, 1]
            n -= 1
        buckets[current & (BUCKETS - 1)] = -1
        current += 1


@inlined
def _read_off(toll, nodes, now, width, lengths, start, route):  # type: ignore[no-untyped-def]
    """Follow optimal moves from a settled start to cost 0; returns the number of cells."""
    n = 0
    cell = start
    while nodes[cell, 1] > 0:
        here = abs(toll[cell])
        walls = 0
        for d in range(8):
            new = cell + ROW_STEP[d] * width + COL_STEP[d]
            if toll[new] < 0:
                walls |= 1 << d
                continue
            if walls & BETWEEN[d] or not _flags(nodes, new, now) & REACHED:
                continue
            length = lengths[1] if d >= DIAGONAL_FIRST else lengths[0]
            if nodes[new, 1] + length * (here + toll[new]) == nodes[cell, 1]:
                cell = new
                break
        else:
            return -1
        if n < route.shape[0]:
            row = cell // width
            route[n] = (row - 1) * (width - 2) + cell - row * width - 1
        n += 1
    return n


@kernel
def plan_routes(  # type: ignore[no-untyped-def]
    price, bounds, toll, filled, nodes, queue, buckets, searches, lengths, at_cell, dearer,
    standing, docks, plan, route, route_cost, columns, step, events, count,
):  # fmt: skip
    """Plan a route for every robot that needs one.

    Args:
        price: int16[K, C], bounds: int64[K, 2]: see ``OccupancyGrids``.
        toll, filled, nodes, queue, buckets, searches: scratch, see ``Search``.
        lengths: int64[6], see ``Search``.
        at_cell: int64[N], the cell that each robot believes to be in.
        dearer: int64[K, n], cells in which robots stand for long, -1 for none.
        standing: how many entries each row of `dearer` has at most.
        docks: int64[k], cells near the charging stations.
        plan: int64[N, columns], route: int32[N, longest], route_cost: int64[N]: ``RouteTable``.
        columns: of the grid; step: the current step; events, count: see ``core.codes``.
    """
    robots = plan.shape[0]
    width = columns + 2
    base = lengths[2]
    box = np.empty(4, dtype=np.int64)
    seeds = np.empty(max(1, docks.shape[0]), dtype=np.int64)
    loaded = -1
    for i in range(robots):
        if plan[i, NEED] != 1:
            continue
        m = i if price.shape[0] > 1 else 0
        if m != loaded:
            _fill_tolls(price[m], bounds[m], filled, toll, columns, base)
            loaded = m
        goal = plan[i, WANTED]
        for e in range(standing):
            cell = dearer[m, e]
            if cell >= 0:
                fresh = _toll(price[m], cell, base)
                more = lengths[4] if fresh >= 0 else -lengths[4]
                toll[_padded(cell, columns)] = fresh + more
        searches[0] += 1
        now = searches[0]
        waiting = 0
        box[0], box[1], box[2], box[3] = price.shape[1], -1, price.shape[1], -1
        # Everybody who shares this map and wants to get there too.
        for j in range(i, robots):
            if plan[j, NEED] != 1 or plan[j, WANTED] != goal:
                continue
            if price.shape[0] > 1 and j != i:
                continue
            plan[j, NEED] = 2
            start = _padded(at_cell[j], columns)
            if not _flags(nodes, start, now) & START:
                nodes[start, 0] = (now << FLAG_BITS) | START
                waiting += 1
            box[0] = min(box[0], start // width)
            box[1] = max(box[1], start // width)
            box[2] = min(box[2], start % width)
            box[3] = max(box[3], start % width)
        n = 0
        for s in range(docks.shape[0] if goal == STATION else 1):
            seed = docks[s] if goal == STATION else goal
            if price[m, seed] >= 0:
                seeds[n] = _padded(seed, columns)
                n += 1
        _spread(toll, nodes, queue, buckets, now, seeds[:n], waiting, box, width, lengths)
        for j in range(i, robots):
            if plan[j, NEED] != 2:
                continue
            plan[j, NEED] = 0
            plan[j, GOAL] = goal
            plan[j, AT] = 0
            start = _padded(at_cell[j], columns)
            length = -1
            if _flags(nodes, start, now) & SETTLED:
                length = _read_off(toll, nodes, now, width, lengths, start, route[j])
            plan[j, LENGTH] = max(length, 0)
            route_cost[j] = nodes[start, 1] if length >= 0 else -1
            plan[j, FAILED_UNTIL] = 0 if length >= 0 else step + 10
            events[count[0], 0] = ROUTE
            events[count[0], 1] = j
            events[count[0], 2] = length
            events[count[0], 3] = goal
            count[0] += 1
        for e in range(standing):
            cell = dearer[m, e]
            if cell >= 0:
                toll[_padded(cell, columns)] = _toll(price[m], cell, base)


@kernel
def route_cost_field(  # type: ignore[no-untyped-def]
    price, bounds, toll, filled, nodes, queue, buckets, searches, lengths, start, targets, at_most,
    columns, found,
):  # fmt: skip
    """Costs of the best routes from one cell to many: a search that spreads from the start.

    Args:
        price: int16[C], bounds: int64[2]: one map; toll, filled, nodes, queue, buckets, searches:
            scratch, see ``Search``.
        lengths: int64[6], see ``Search``.
        start: flat cell; targets: int64[n], flat cells.
        at_most: the search stops once so many targets (and all at equal cost) are settled.
        columns: of the grid.
        found: int64[n], written: the cost for each target, -1 where it was not settled.
    """
    width = columns + 2
    _fill_tolls(price, bounds, filled, toll, columns, lengths[2])
    searches[0] += 1
    now = searches[0]
    waiting = 0
    for t in range(targets.shape[0]):
        cell = _padded(targets[t], columns)
        if price[targets[t]] >= 0 and not _flags(nodes, cell, now) & START:
            nodes[cell, 0] = (now << FLAG_BITS) | START
            waiting += 1
    waiting = min(waiting, at_most)
    # A box over everything: no heuristic, so cells are settled in the order of their cost.
    box = np.array([0, price.shape[0], 0, price.shape[0]], dtype=np.int64)
    seeds = np.array([_padded(start, columns)], dtype=np.int64)
    if waiting > 0:
        _spread(toll, nodes, queue, buckets, now, seeds, waiting, box, width, lengths)
    for t in range(targets.shape[0]):
        cell = _padded(targets[t], columns)
        found[t] = nodes[cell, 1] if _flags(nodes, cell, now) & SETTLED else -1
