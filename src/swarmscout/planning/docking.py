"""Charging: at which station, and at which place there.

Of several stations a robot takes the one with the least sum of way and queue, from what it has
heard of robots that charge or go to charge. Near it, it takes a place inside the range that no
other robot has taken; where two took the same in one step, the one with more charge takes another.
If there is none it waits where it is, and those with the least charge go first.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from swarmscout.core.cells import offset
from swarmscout.core.enums import CHARGE
from swarmscout.core.grid import GRID, GridFrame
from swarmscout.core.jit import inlined, kernel
from swarmscout.mapping.footprint import TIGHT
from swarmscout.planning.route_table import NEAREST, NO_PLACE, STATION, WAITS

__all__ = [
    "DOCKING",
    "ChargingRules",
    "choose_places",
    "docking_rules",
    "take_stations",
    "weigh_stations",
]

DOCKING = np.dtype(
    [
        *GRID.descr,  # the frame of the map
        ("range_m", "f8"),  # of a station
        ("near_m", "f8"),  # this near to its station a robot takes a place there, or waits
        ("apart_m", "f8"),  # places are at least so far from each other and from what stands there
        ("forward_m", "f8"),
        ("share_per_m", "f8"),  # charge that the way takes, see ChargingRules
        ("share_reserve", "f8"),
        ("crowd", "i8"),  # cost of a robot that charges at a station or is on its way there …
        ("wait", "i8"),  # … and for the time in which it blocks a place, if all are taken
    ],
    align=True,
)
"""How robots get to a station and to a place there."""

IN_THE_WAY = 4
"""A robot that is silent near a station weighs as much as this many that charge there."""

HEARD_STEPS = 50
"""What was said longer ago does not count any more."""

STANDS_STEPS = 3
"""A robot that has not moved for so long keeps the places round it taken."""

CROWD_M = 2.0
"""Each robot at a station, or on its way there, counts as much as so much more way: a station that
many come to at once jams, since those that have charged do not get out."""

FULL_TIMES = 3
"""Once half of the places are taken or claimed, each further robot weighs this many times more."""

NEAR_M = 1.5
"""So far outside the range robots take a place, or wait for one."""

MARGIN_M = 0.2
"""Between bodies in neighbouring places there is at least so much room."""


@dataclass(frozen=True)
class ChargingRules:
    """What a robot knows of its battery and of stations.

    Attributes:
        range_m: the largest distance at which a station charges.
        share_per_m, share_reserve: charge, as shares of the capacity, that the way home takes per
            metre, and a reserve; both 0: the way does not matter.
        occupied_m: the way that a robot drives in the time in which another one charges.
    """

    range_m: float = 1.5
    share_per_m: float = 0.0
    share_reserve: float = 0.0
    occupied_m: float = 5.0


def docking_rules(
    frame: GridFrame, charging: ChargingRules, radius_m: float, forward_m: float
) -> NDArray[np.void]:
    """DOCKING[1].

    Args:
        frame: the grid. charging: batteries and stations.
        radius_m: half of a robot's diameter. forward_m: length of one move.
    """
    rules = np.zeros(1, dtype=DOCKING)
    rule = rules[0]
    frame.write_into(rule)
    for name in ("range_m", "share_per_m", "share_reserve"):
        rule[name] = getattr(charging, name)
    rule["near_m"] = charging.range_m + NEAR_M
    rule["apart_m"] = 2.0 * radius_m + MARGIN_M
    rule["forward_m"] = forward_m
    # In the unit of costs, see RouteCosts.
    rule["crowd"] = round(2e6 * CROWD_M)
    rule["wait"] = round(2e6 * charging.occupied_m)
    return rules


@kernel
def weigh_stations(heard, routes, status, stations, places, queues, rules, step):  # type: ignore[no-untyped-def]
    """What queueing at each station costs, as the robots know that look for one.

    Args:
        heard: BEACON[R, N], see ``Knowledge``; routes: ROUTE[N].
        status: uint8[R, C'], see ``OccupancyGrids``.
        stations: float64[k, 2]; places: int64[k, P], see ``lay_places``.
        queues: int64[R, k], written for the rows of robots that look.
        rules: DOCKING[1]; step: the current step.
    """
    rules = rules[0]
    if stations.shape[0] == 0:
        return
    for i in range(routes.shape[0]):
        if routes[i].need == 1 and NEAREST <= routes[i].wanted <= STATION:
            queues[routes[i].map, 0] = -1
    for i in range(routes.shape[0]):
        m = routes[i].map
        looks = routes[i].need == 1 and NEAREST <= routes[i].wanted <= STATION
        if not looks or queues[m, 0] >= 0:
            continue
        queues[m] = 0
        for j in range(heard.shape[1]):
            other = heard[m, j]
            if other.step >= max(0, step - HEARD_STEPS):
                if other.station >= 0:
                    queues[m, other.station] += 1
            elif other.step >= 0:
                # It may have no charge left, and stand in the way for good.
                for s in range(stations.shape[0]):
                    dx = other.x_m - stations[s, 0]
                    dy = other.y_m - stations[s, 1]
                    if dx * dx + dy * dy <= rules.near_m * rules.near_m:
                        queues[m, s] += IN_THE_WAY
        for s in range(stations.shape[0]):
            load = queues[m, s]
            room = 0
            for cell in places[s]:
                room += cell >= 0 and not status[m, cell] & TIGHT
            queues[m, s] = (load + FULL_TIMES * max(0, load - room // 2)) * rules.crowd
            queues[m, s] += max(0, load + 1 - room) * rules.wait // max(1, room)


@kernel
def take_stations(own, routes, docks, queues):  # type: ignore[no-untyped-def]
    """A robot that was free to choose takes the station that its route leads to.

    Args:
        own: MIND[N], `station` is written; routes: ROUTE[N], `goal` is written.
        docks: int64[n, 2], see ``dock_cells``; queues: int64[R, k].
    """
    for i in range(own.shape[0]):
        me = own[i]
        route = routes[i]
        if me.mode != CHARGE:
            continue
        if route.goal < NEAREST and route.failed_until > 0:
            # No way leads there: next time it asks for any.
            me.station = -1
        if route.goal != STATION or route.cost < 0:
            continue
        for d in range(docks.shape[0]):
            s = docks[d, 1]
            if docks[d, 0] == route.end and (
                me.station < 0 or queues[route.map, s] < queues[route.map, me.station]
            ):
                me.station = s
        route.goal = NEAREST - 1 - me.station


@inlined
def _squared(cell, x, y, rules):  # type: ignore[no-untyped-def]
    """Squared distance of a point from the centre of a cell."""
    dx, dy = offset(cell, x, y, rules)
    return dx * dx + dy * dy


@inlined
def _gives_way(heard, i, step):  # type: ignore[no-untyped-def]
    """Whether another robot, with less charge, has taken the same place as i."""
    mine = heard[i]
    for j in range(heard.shape[0]):
        if j == i or heard[j].step != step or heard[j].place != mine.place:
            continue
        if heard[j].charge < mine.charge or (heard[j].charge == mine.charge and j < i):
            return True
    return False


@inlined
def _look_round(heard, still, i, x, y, places, taken, rules, step):  # type: ignore[no-untyped-def]
    """Mark the places of a station at (x, y) that are taken; returns how many go before i."""
    for p in range(places.shape[0]):
        taken[p] = False
    ahead = 0
    for j in range(heard.shape[0]):
        other = heard[j]
        if j == i or other.step < max(0, step - HEARD_STEPS):
            continue
        dx = other.x_m - x
        dy = other.y_m - y
        if dx * dx + dy * dy > rules.near_m * rules.near_m:
            continue
        if other.place == WAITS and other.station == heard[i].station:
            ahead += other.charge < heard[i].charge or (other.charge == heard[i].charge and j < i)
        stands = still[j] >= STANDS_STEPS
        for p in range(places.shape[0]):
            near = stands and _squared(places[p], other.x_m, other.y_m, rules) < rules.apart_m**2
            taken[p] = taken[p] or other.place == places[p] or near
    return ahead


@inlined
def _nearest_free(me, status, places, taken, tried, ahead, rules):  # type: ignore[no-untyped-def]
    """The free place nearest to a robot; WAITS if others go first, NO_PLACE if none is of use."""
    usable = 0
    free = 0
    best = NO_PLACE
    least = np.inf
    for p in range(places.shape[0]):
        if places[p] < 0 or status[places[p]] & TIGHT != 0 or tried & (1 << p):
            continue
        usable += 1
        if taken[p]:
            continue
        free += 1
        away = _squared(places[p], me.x_m, me.y_m, rules)
        if away < least:
            best = places[p]
            least = away
    if usable == 0:
        return NO_PLACE
    return best if free > ahead else WAITS


@kernel
def choose_places(own, ear, heard, still, status, routes, stations, places, rules, step):  # type: ignore[no-untyped-def]
    """Near its station, each robot that charges takes a free place inside the range, or waits.

    Args:
        own: MIND[N], `station` and `place` are written; ear: int64[N], see ``Knowledge``.
        heard: BEACON[R, N], still: int64[R, N], see ``Knowledge``.
        status: uint8[R, C'], see ``OccupancyGrids``.
        routes: ROUTE[N], see ``RouteTable``; `tried` is written.
        stations: float64[k, 2]; places: int64[k, P], see ``lay_places``.
        rules: DOCKING[1]; step: the current step.
    """
    rules = rules[0]
    taken = np.empty(places.shape[1], dtype=np.bool_)
    for i in range(own.shape[0]):
        me = own[i]
        route = routes[i]
        if not me.thinks:
            continue
        if me.mode != CHARGE:
            me.station = -1
            me.place = NO_PLACE
            route.tried = 0
            continue
        if me.station < 0:
            continue
        x = stations[me.station, 0]
        y = stations[me.station, 1]
        if (me.x_m - x) ** 2 + (me.y_m - y) ** 2 > rules.near_m * rules.near_m:
            me.place = NO_PLACE
            continue
        row = heard[ear[i]]
        if me.place >= 0:
            failed = route.goal == me.place and route.failed_until > 0
            if route.goal == me.place and route.at >= route.length:
                # A body has no room at some places, and stops as near to them as it can.
                off2 = (me.x_m - x) ** 2 + (me.y_m - y) ** 2
                failed = failed or off2 > rules.range_m * rules.range_m
            # Who stands at its place keeps it.
            if not failed and (route.at >= route.length or not _gives_way(row, i, step)):
                continue
            if failed:
                for p in range(places.shape[1]):
                    if places[me.station, p] == me.place:
                        route.tried |= 1 << p
        ahead = _look_round(row, still[ear[i]], i, x, y, places[me.station], taken, rules, step)
        me.place = _nearest_free(
            me, status[ear[i]], places[me.station], taken, route.tried, ahead, rules
        )
