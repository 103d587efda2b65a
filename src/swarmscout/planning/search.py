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

Routes that lead far are planned in parts (``far_routes``), all others as a whole.

Source: Hart, Nilsson, Raphael (1968), "A formal basis for the heuristic determination of minimum
cost paths".
"""

from __future__ import annotations

import numpy as np

from swarmscout.core.enums import ROUTE as ROUTE_EVENT
from swarmscout.core.events import note
from swarmscout.core.jit import inlined, kernel
from swarmscout.mapping.footprint import enter, get_out
from swarmscout.planning.far_routes import plan_far
from swarmscout.planning.route_table import NEAREST, STATION, by_goal
from swarmscout.planning.spread import FLAG_BITS, SETTLED, START, flags_of, read_off, spread
from swarmscout.planning.tolls import fill_tolls, padded, toll_robots, unpadded

__all__ = ["plan_routes", "route_cost_field"]


@inlined
def _start_all(nodes, routes, group, search, box):  # type: ignore[no-untyped-def]
    """Mark the starts of all robots of a group; returns how many cells."""
    width = search.columns + 2
    waiting = 0
    box[0], box[1], box[2], box[3] = 1 << 60, -1, 1 << 60, -1
    for i in group:
        start = padded(routes[i].here, search.columns)
        if not flags_of(nodes[start], search.count) & START:
            nodes[start].mark = (search.count << FLAG_BITS) | START
            waiting += 1
        box[0] = min(box[0], start // width)
        box[1] = max(box[1], start // width)
        box[2] = min(box[2], start % width)
        box[3] = max(box[3], start % width)
    return waiting


@inlined
def _read_all(price, toll, nodes, routes, cells, group, search, step, events):  # type: ignore[no-untyped-def]
    """Read off the routes of all robots that the running search was for."""
    for i in group:
        route = routes[i]
        route.need = 0
        route.goal = route.wanted
        route.at = 0
        start = padded(route.here, search.columns)
        length = -1
        if flags_of(nodes[start], search.count) & SETTLED:
            length, end, route.way_mm = read_off(price, toll, nodes, search, start, cells[i])
            route.end = unpadded(end, search.columns)
        route.length = max(length, 0)
        route.kept = min(route.length, cells.shape[1])
        route.cost = nodes[start].cost if length >= 0 else -1
        route.failed_until = 0 if length >= 0 else step + 10
        note(events, ROUTE_EVENT, i, length, max(route.goal, STATION))


@inlined
def _name_docks(routes, group, docks, entries, queues):  # type: ignore[no-untyped-def]
    """Let ways to a station end at the dock that the last cell is for."""
    for i in group:
        route = routes[i]
        if route.cost < 0:
            continue
        dock = route.end
        least = 1 << 62
        for d in range(docks.shape[0]):
            queue = queues[docks[d, 1]]
            if queue < least and entries[d] == route.end:
                dock = docks[d, 0]
                least = queue
        route.end = dock


@kernel
def plan_routes(  # type: ignore[no-untyped-def]
    price, status, bounds, changed, toll, nodes, buckets, regions, state, marks, docks, queues,
    reach, routes, cells, step, events,
):  # fmt: skip
    """Plan a route for every robot that needs one, to a cell or to a station (`state[0].home`).

    Args:
        price: int16[R, C], status: uint8[R, C'], bounds: int64[R, 2], changed: int64[R, T]: see
            ``OccupancyGrids``.
        toll, nodes, buckets, regions, state: scratch, see ``Search``.
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
    costs = np.zeros(max(1, docks.shape[0]), dtype=np.int64)
    entries = np.empty(docks.shape[0], dtype=np.int64)
    columns = search.columns
    rows = price.shape[1] // columns
    loaded = -1
    robots, groups = by_goal(routes, search.home)
    for i in robots:
        m = routes[i].map
        routes[i].here = get_out(status[m], routes[i].here, rows, columns, reach[1])
    for g in range(groups.shape[0]):
        group = robots[groups[g, 0] : groups[g, 1]]
        i = group[0]
        goal = routes[i].wanted
        m = routes[i].map
        if m != loaded:
            if loaded >= 0:
                toll_robots(
                    price[loaded], status[loaded], toll, marks[loaded], regions.labelled, search,
                    False,
                )  # fmt: skip
            fill_tolls(m, price, status, bounds, changed, toll, regions.labelled, search)
            toll_robots(price[m], status[m], toll, marks[m], regions.labelled, search, True)
            for d in range(docks.shape[0] if search.home else 0):
                entries[d] = enter(status[m], docks[d, 0], rows, columns, reach[0])
            loaded = m
        n = 0
        for d in range(docks.shape[0] if goal <= STATION else 1):
            seed = (
                entries[d] if goal <= STATION else enter(status[m], goal, rows, columns, reach[0])
            )
            other = goal < NEAREST and docks[d, 1] != NEAREST - 1 - goal
            if seed >= 0 and not other:
                seeds[n] = padded(seed, columns)
                costs[n] = queues[m, docks[d, 1]] if goal == STATION else 0
                n += 1
        if search.far > 0:
            left = plan_far(
                group, seeds[:n], costs, price[m], toll, nodes, buckets, regions, search, routes,
                cells, step, events,
            )  # fmt: skip
            group = group[:left]
            if left == 0:
                continue
        search.count += 2
        waiting = _start_all(nodes, routes, group, search, box)
        spread(toll, nodes, buckets, seeds[:n], costs, waiting, box, search)
        _read_all(price[m], toll, nodes, routes, cells, group, search, step, events)
        if goal in (STATION, NEAREST):
            _name_docks(routes, group, docks, entries, queues[m])
    if loaded >= 0:
        toll_robots(
            price[loaded], status[loaded], toll, marks[loaded], regions.labelled, search,
            False,
        )  # fmt: skip


@kernel
def route_cost_field(  # type: ignore[no-untyped-def]
    m,
    price,
    status,
    bounds,
    changed,
    toll,
    nodes,
    buckets,
    labelled,
    state,
    start,
    targets,
    at_most,
    found,
):
    """Costs of the best routes from one cell to many: a search that spreads from the start.

    Args:
        m: which map. price, status, bounds, changed: see :func:`plan_routes`.
        toll, nodes, buckets, labelled, state: scratch, see ``Search``.
        start: flat cell; targets: int64[n], flat cells with room, or -1.
        at_most: the search stops once this many targets (and all at equal cost) are settled.
        found: int64[n], written: the cost for each target, -1 where it was not settled.
    """
    search = state[0]
    fill_tolls(m, price, status, bounds, changed, toll, labelled, search)
    search.count += 2
    waiting = 0
    for t in range(targets.shape[0]):
        if targets[t] < 0:
            continue
        cell = padded(targets[t], search.columns)
        if not flags_of(nodes[cell], search.count) & START:
            nodes[cell].mark = (search.count << FLAG_BITS) | START
            waiting += 1
    waiting = min(waiting, at_most)
    # A box over everything: no heuristic, so cells are settled in the order of their cost.
    box = np.array([0, price.shape[1], 0, price.shape[1]], dtype=np.int64)
    seeds = np.array([padded(start, search.columns)], dtype=np.int64)
    if waiting > 0:
        spread(toll, nodes, buckets, seeds, np.zeros(1, dtype=np.int64), waiting, box, search)
    for t in range(targets.shape[0]):
        found[t] = -1
        if targets[t] >= 0:
            node = nodes[padded(targets[t], search.columns)]
            if flags_of(node, search.count) & SETTLED:
                found[t] = node.cost
