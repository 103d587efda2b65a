"""Routes that lead far, planned in parts over the regions of the map: see ``regions``.

Deviation: the paper plans each route as a whole.
"""

from __future__ import annotations

import numpy as np

from swarmscout.core.enums import ROUTE as ROUTE_EVENT
from swarmscout.core.events import note
from swarmscout.core.jit import allocating, inlined
from swarmscout.mapping.occupancy import TILE
from swarmscout.planning.regions import NO_REGION, find_far_ways, list_cells, region_of, way_ahead
from swarmscout.planning.route_table import STATION
from swarmscout.planning.spread import FLAG_BITS, SETTLED, START, flags_of, read_off, spread
from swarmscout.planning.tolls import padded, unpadded

__all__ = ["plan_far"]

AHEAD = 4
"""Number of regions over which one part of a route leads."""


@inlined
def _is_far(here, seeds, search):  # type: ignore[no-untyped-def]
    """Whether a padded cell is far from all seeds, so that its way may lead far."""
    width = search.columns + 2
    for seed in seeds:
        rows = abs(seed // width - here // width)
        cols = abs(seed % width - here % width)
        if max(rows, cols) < search.far * TILE // 2:
            return False
    return True


@allocating
def _plan_part(i, region, price, toll, nodes, buckets, regions, search, routes, cells):  # type: ignore[no-untyped-def]
    """Plan the first part of a robot's route: the best way to any cell of a region.

    Returns:
        The number of cells on it, -1: there is none.
    """
    columns = search.columns
    rows = price.shape[0] // columns
    width = columns + 2
    seeds = np.empty(TILE * TILE, dtype=np.int64)
    n = list_cells(region, regions, rows, columns, seeds)
    for k in range(n):
        seeds[k] = padded(seeds[k], columns)
    search.count += 2
    start = padded(routes[i].here, columns)
    nodes[start].mark = (search.count << FLAG_BITS) | START
    row = start // width
    box = np.array([row, row, start - row * width, start - row * width], dtype=np.int64)
    costs = np.zeros(n, dtype=np.int64)
    spread(toll, nodes, buckets, seeds[:n], costs, 1, box, search)
    if not flags_of(nodes[start], search.count) & SETTLED:
        return -1
    length, _, routes[i].way_mm = read_off(price, toll, nodes, search, start, cells[i])
    routes[i].cost = nodes[start].cost
    return length


@allocating
def plan_far(  # type: ignore[no-untyped-def]
    group, seeds, costs, price, toll, nodes, buckets, regions, search, routes, cells, step, events
):  # fmt: skip
    """Plan parts of routes for those of a group to whom the goal is far.

    Args:
        group: int64[n], robots that share a map and a goal; written: those who still need a route.
        seeds: int64[k], padded cells of the goal; costs: int64[k], what each costs besides.
        price: int16[C], of the map; toll, nodes, buckets, regions, search: see ``Search``.
        routes: ROUTE[N], cells: int32[N, longest]: ``RouteTable``.
        step: the current step; events: see ``EventLog``.

    Returns:
        How many still need a route: they come first in `group`.
    """
    columns = search.columns
    rows = price.shape[0] // columns
    far = np.empty(group.shape[0], dtype=np.bool_)
    starts = np.empty(group.shape[0], dtype=np.int64)
    n = 0
    for k in range(group.shape[0]):
        i = group[k]
        here = routes[i].here
        far[k] = _is_far(padded(here, columns), seeds, search)
        starts[n] = here
        n += far[k]
    if n == 0:
        return group.shape[0]
    goals = np.empty(seeds.shape[0], dtype=np.int64)
    for g in range(seeds.shape[0]):
        goals[g] = unpadded(seeds[g], columns)
    search.count += 2
    now = search.count
    find_far_ways(toll, regions, goals, costs, starts[:n], search, rows)
    left = 0
    for k in range(group.shape[0]):
        i = group[k]
        route = routes[i]
        tiles = 0
        region = NO_REGION
        if far[k]:
            region = region_of(route.here, toll, regions, rows, columns)
        if region != NO_REGION and regions.reached[region] == now:
            ahead, tiles, rest_mm = way_ahead(region, AHEAD, regions, search)
        length = 0
        # With a table of single cells ways are measured, not driven.
        drives = cells.shape[1] > 1
        if tiles > search.far and drives:
            length = _plan_part(
                i, ahead, price, toll, nodes, buckets, regions, search, routes, cells
            )  # fmt: skip
        if tiles <= search.far or length < 0:
            group[left] = i
            left += 1
            continue
        if drives:
            route.cost += regions.cost[ahead]
            route.way_mm += rest_mm
        else:
            route.cost = regions.cost[region]
            route.way_mm = way_ahead(region, 0, regions, search)[2]
        route.need = 0
        route.goal = route.wanted
        route.at = 0
        route.end = -1
        route.kept = min(length, cells.shape[1])
        route.length = length + (tiles - AHEAD) * TILE
        route.failed_until = 0
        note(events, ROUTE_EVENT, i, route.length, max(route.goal, STATION))
    return left
