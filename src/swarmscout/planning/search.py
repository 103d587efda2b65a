"""A* over the occupancy grid, with occupancy probability as cost (paper, "Task description").

Moves go to the 8 neighbours. A move costs its length times the mean price of the two cells, where a
cell's price per metre is 1 + p ("length") or p alone ("probability", the paper to the letter).
Deviation: the scenario ``paper`` takes 1 + p, so that well-seen cells are not almost free; and
cells round a robot that is known to stand, or to drive the other way, are dearer.
Cells without room for a body are impassable, those in which it may touch a wall are dearer, and
corners are not cut. Costs are integers, so optimal is exact. A goal beside a wall, as frontier
cells often are, stands for the nearest cell clear of walls.

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

from swarmscout.core.enums import ROUTE as ROUTE_EVENT
from swarmscout.core.events import note
from swarmscout.core.jit import inlined, kernel
from swarmscout.mapping.footprint import enter, get_out
from swarmscout.planning.route_table import NEAREST, STATION
from swarmscout.planning.search_memory import BUCKETS
from swarmscout.planning.tolls import fill_tolls, padded, toll_robots, untoll_robots

__all__ = ["plan_routes", "route_cost_field"]

# Flags of a node in the running search; the search's number stands above them.
REACHED, SETTLED, START, OPEN, SEED = 1, 2, 4, 8, 16
FLAG_BITS = 5

DIAGONAL_FIRST = 4
# Orthogonal neighbours first, then diagonal ones: the fixed order among equally good routes.
ROW_STEP = np.array([0, 1, 0, -1, 1, 1, -1, -1], dtype=np.int64)
COL_STEP = np.array([1, 0, -1, 0, 1, -1, -1, 1], dtype=np.int64)
# Which orthogonal neighbours (as bits) a diagonal move passes between.
BETWEEN = np.array([0, 0, 0, 0, 0b0011, 0b0110, 0b1100, 0b1001], dtype=np.int64)


@inlined
def _put(nodes, buckets, cell, bucket, current):  # type: ignore[no-untyped-def]
    """Queue a cell; what is too far ahead waits in the last bucket."""
    slot = min(bucket, current + BUCKETS - 1) & (BUCKETS - 1)
    first = buckets[slot]
    node = nodes[cell]
    node.before = -1 - slot
    node.after = first
    node.bucket = bucket
    if first >= 0:
        nodes[first].before = cell
    buckets[slot] = cell


@inlined
def _take(nodes, buckets, cell):  # type: ignore[no-untyped-def]
    """Remove a cell from its bucket."""
    before = nodes[cell].before
    after = nodes[cell].after
    if before >= 0:
        nodes[before].after = after
    else:
        buckets[-1 - before] = after
    if after >= 0:
        nodes[after].before = before


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
def _flags(node, now):  # type: ignore[no-untyped-def]
    """The flags of a cell in search number `now`."""
    return node.mark & ((1 << FLAG_BITS) - 1) if node.mark >> FLAG_BITS == now else 0


@inlined
def _seed(nodes, buckets, seeds, costs, box, width, search):  # type: ignore[no-untyped-def]
    """Queue the seeds at their costs; returns the first bucket and the number of open cells."""
    least = search.base + search.least
    current = 1 << 40
    for a in range(seeds.shape[0]):
        out = _way_out(seeds[a], width, box, search.straight, search.diagonal, least)
        current = min(current, (costs[a] + out) >> search.bits)
    n = 0
    for a in range(seeds.shape[0]):
        seed = seeds[a]
        flags = _flags(nodes[seed], search.count)
        if flags & OPEN:
            if nodes[seed].cost <= costs[a]:
                continue
            _take(nodes, buckets, seed)
            n -= 1
        nodes[seed].mark = (search.count << FLAG_BITS) | flags | REACHED | OPEN | SEED
        nodes[seed].cost = costs[a]
        out = _way_out(seed, width, box, search.straight, search.diagonal, least)
        _put(nodes, buckets, seed, (costs[a] + out) >> search.bits, current)
        n += 1
    return current, n


@inlined
def _spread(toll, nodes, buckets, seeds, costs, waiting, box, search):  # type: ignore[no-untyped-def]
    """Settle cells from the seeds until `waiting` starts, and all that cost no more, are."""
    straight, diagonal, bits = search.straight, search.diagonal, search.bits
    least, now, width = search.base + search.least, search.count, search.columns + 2
    current, n = _seed(nodes, buckets, seeds, costs, box, width, search)
    bound = -1
    while n > 0:
        cell = buckets[current & (BUCKETS - 1)]
        if cell < 0:
            current += 1
            continue
        if waiting <= 0 and current > bound:
            break
        _take(nodes, buckets, cell)
        node = nodes[cell]
        if node.bucket > current:
            _put(nodes, buckets, cell, node.bucket, current)
            continue
        n -= 1
        flags = node.mark
        node.mark = (flags | SETTLED) & ~OPEN
        cost = node.cost
        here = toll[cell]
        if flags & START:
            if not flags & SETTLED:
                waiting -= 1
            bound = max(bound, cost >> bits)
            if here < 0:
                # A robot may leave a closed cell, but no route leads through it.
                continue
        here = abs(here)
        walls = 0
        for d in range(8):
            new = cell + ROW_STEP[d] * width + COL_STEP[d]
            price = toll[new]
            near = nodes[new]
            flags = _flags(near, now)
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
            if not flags & REACHED or total < near.cost:
                if flags & OPEN:
                    _take(nodes, buckets, new)
                else:
                    n += 1
                near.mark = (now << FLAG_BITS) | (flags & ~SEED) | REACHED | OPEN
                near.cost = total
                f = total + _way_out(new, width, box, straight, diagonal, least)
                _put(nodes, buckets, new, f >> bits, current)
    while n > 0:
        cell = buckets[current & (BUCKETS - 1)]
        while cell >= 0:
            cell = nodes[cell].after
            n -= 1
        buckets[current & (BUCKETS - 1)] = -1
        current += 1


@inlined
def _read_off(price, toll, nodes, search, start, route):  # type: ignore[no-untyped-def]
    """Follow optimal moves from a settled start to a seed.

    Returns:
        The number of cells (-1: there is no way), the seed, and the length in mm, of which what is
        not known to be free counts twice.
    """
    now, width = search.count, search.columns + 2
    n = 0
    way_mm = 0
    cell = start
    while not nodes[cell].mark & SEED:
        here = abs(toll[cell])
        walls = 0
        for d in range(8):
            new = cell + ROW_STEP[d] * width + COL_STEP[d]
            if toll[new] < 0:
                walls |= 1 << d
                continue
            if walls & BETWEEN[d] or not _flags(nodes[new], now) & REACHED:
                continue
            length = search.diagonal if d >= DIAGONAL_FIRST else search.straight
            if nodes[new].cost + length * (here + toll[new]) == nodes[cell].cost:
                cell = new
                break
        else:
            return -1, cell, 0
        row = cell // width
        flat = (row - 1) * (width - 2) + cell - row * width - 1
        way_mm += length if price[flat] < search.proven else 2 * length
        if n < route.shape[0]:
            route[n] = flat
        n += 1
    return n, cell, way_mm


@inlined
def _start_all(nodes, routes, i, search, box):  # type: ignore[no-untyped-def]
    """Mark the starts of all robots that share i's map and goal; returns how many cells."""
    width = search.columns + 2
    waiting = 0
    box[0], box[1], box[2], box[3] = 1 << 60, -1, 1 << 60, -1
    for j in range(i, routes.shape[0]):
        route = routes[j]
        if route.need != 1 or route.wanted != routes[i].wanted or route.map != routes[i].map:
            continue
        route.need = 2
        start = padded(route.here, search.columns)
        if not _flags(nodes[start], search.count) & START:
            nodes[start].mark = (search.count << FLAG_BITS) | START
            waiting += 1
        box[0] = min(box[0], start // width)
        box[1] = max(box[1], start // width)
        box[2] = min(box[2], start % width)
        box[3] = max(box[3], start % width)
    return waiting


@inlined
def _read_all(price, toll, nodes, routes, cells, i, search, step, events):  # type: ignore[no-untyped-def]
    """Read off the routes of all robots that the running search was for."""
    goal = routes[i].wanted
    for j in range(i, routes.shape[0]):
        route = routes[j]
        if route.need != 2:
            continue
        route.need = 3 if goal in (STATION, NEAREST) else 0
        route.goal = goal
        route.at = 0
        start = padded(route.here, search.columns)
        length = -1
        if _flags(nodes[start], search.count) & SETTLED:
            length, end, route.way_mm = _read_off(price, toll, nodes, search, start, cells[j])
            route.end = end - 2 * (end // (search.columns + 2)) - search.columns - 1
        route.length = max(length, 0)
        route.cost = nodes[start].cost if length >= 0 else -1
        route.failed_until = 0 if length >= 0 else step + 10
        note(events, ROUTE_EVENT, j, length, max(goal, STATION))


@inlined
def _name_docks(routes, docks, status, queues, rows, columns, reach):  # type: ignore[no-untyped-def]
    """Let ways to a station that were just read off end at the dock that the last cell is for."""
    for route in routes:
        if route.need != 3:
            continue
        route.need = 0
        if route.cost < 0:
            continue
        dock = route.end
        least = 1 << 62
        for d in range(docks.shape[0]):
            queue = queues[docks[d, 1]]
            if queue < least and enter(status, docks[d, 0], rows, columns, reach) == route.end:
                dock = docks[d, 0]
                least = queue
        route.end = dock


@kernel
def plan_routes(  # type: ignore[no-untyped-def]
    price, status, bounds, toll, nodes, buckets, state, marks, docks, queues, reach, routes,
    cells, step, events,
):  # fmt: skip
    """Plan a route for every robot that needs one, to a cell or to a station (`state[0].home`).

    Args:
        price: int16[R, C], status: uint8[R, C'], bounds: int64[R, 2]: see ``OccupancyGrids``.
        toll, nodes, buckets, state: scratch, see ``Search``.
        marks: int64[R, N], where robots are, see ``mark_robots``.
        docks: int64[k, 2], cells near the charging stations, and which station each is near.
        queues: int64[R, S], what queueing at each station costs: of those that are free to choose,
            robots take the one with the least sum of way and queue.
        reach: float64[2], how far a goal's and a robot's place may be from a cell with room.
        routes: ROUTE[N], cells: int32[N, longest]: ``RouteTable``.
        step: the current step; events: see ``EventLog``.
    """
    search = state[0]
    box = np.empty(4, dtype=np.int64)
    seeds = np.empty(max(1, docks.shape[0]), dtype=np.int64)
    columns = search.columns
    rows = price.shape[1] // columns
    costs = np.zeros(max(1, docks.shape[0]), dtype=np.int64)
    loaded = -1
    for i in range(routes.shape[0]):
        if routes[i].need == 1 and (routes[i].wanted <= STATION) == search.home:
            own_status = status[routes[i].map]
            routes[i].here = get_out(own_status, routes[i].here, rows, columns, reach[1])
    for i in range(routes.shape[0]):
        goal = routes[i].wanted
        if routes[i].need != 1 or (goal <= STATION) != search.home:
            continue
        m = routes[i].map
        if m != loaded:
            fill_tolls(price[m], status[m], bounds[m], toll, search)
            loaded = m
        toll_robots(price[m], status[m], toll, marks[m], search)
        search.count += 2
        waiting = _start_all(nodes, routes, i, search, box)
        n = 0
        for d in range(docks.shape[0] if goal <= STATION else 1):
            seed = docks[d, 0] if goal <= STATION else goal
            other = goal < NEAREST and docks[d, 1] != NEAREST - 1 - goal
            seed = enter(status[m], seed, rows, columns, reach[0])
            if seed >= 0 and not other:
                seeds[n] = padded(seed, columns)
                costs[n] = queues[m, docks[d, 1]] if goal == STATION else 0
                n += 1
        _spread(toll, nodes, buckets, seeds[:n], costs, waiting, box, search)
        _read_all(price[m], toll, nodes, routes, cells, i, search, step, events)
        if goal in (STATION, NEAREST):
            _name_docks(routes, docks, status[m], queues[m], rows, columns, reach[0])
        untoll_robots(price[m], status[m], toll, marks[m], search)


@kernel
def route_cost_field(  # type: ignore[no-untyped-def]
    price, status, bounds, toll, nodes, buckets, state, start, targets, at_most, found
):
    """Costs of the best routes from one cell to many: a search that spreads from the start.

    Args:
        price: int16[C], status: uint8[C'], bounds: int64[2]: one map.
        toll, nodes, buckets, state: scratch, see ``Search``.
        start: flat cell; targets: int64[n], flat cells with room, or -1.
        at_most: the search stops once this many targets (and all at equal cost) are settled.
        found: int64[n], written: the cost for each target, -1 where it was not settled.
    """
    search = state[0]
    fill_tolls(price, status, bounds, toll, search)
    search.count += 2
    waiting = 0
    for t in range(targets.shape[0]):
        if targets[t] < 0:
            continue
        cell = padded(targets[t], search.columns)
        if not _flags(nodes[cell], search.count) & START:
            nodes[cell].mark = (search.count << FLAG_BITS) | START
            waiting += 1
    waiting = min(waiting, at_most)
    # A box over everything: no heuristic, so cells are settled in the order of their cost.
    box = np.array([0, price.shape[0], 0, price.shape[0]], dtype=np.int64)
    seeds = np.array([padded(start, search.columns)], dtype=np.int64)
    if waiting > 0:
        _spread(toll, nodes, buckets, seeds, np.zeros(1, dtype=np.int64), waiting, box, search)
    for t in range(targets.shape[0]):
        found[t] = -1
        if targets[t] >= 0:
            node = nodes[padded(targets[t], search.columns)]
            if _flags(node, search.count) & SETTLED:
                found[t] = node.cost
