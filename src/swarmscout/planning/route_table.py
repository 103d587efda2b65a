"""All robots' routes as an array of records; record i belongs to robot i."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from swarmscout.core.jit import allocating, inlined

__all__ = [
    "BUMPS",
    "NEAREST",
    "NOWHERE",
    "NO_PLACE",
    "ROUTE",
    "STATION",
    "WAITS",
    "RouteTable",
    "blank_routes",
    "by_goal",
    "station_goal",
]

BUMPS = 6
"""So many bumps a robot remembers."""

ROUTE = np.dtype(
    [
        ("goal", "i8"),  # where the route leads: flat cell, NOWHERE, STATION or one below it
        ("length", "i8"),  # cells on it
        ("kept", "i8"),  # of which so many are in the table; the rest is planned later
        ("at", "i8"),  # the next one to drive to
        ("here", "i8"),  # the cell that the robot believes to be in
        ("map", "i8"),  # the row of the map that it plans on
        ("need", "i8"),  # 1: a route has to be planned in this step
        ("wanted", "i8"),  # where the robot wants to go now
        ("failed_until", "i8"),  # there was no route: do not try again before this step
        ("wish_x_m", "f8"),  # from the robot to its waypoint; both 0: it does not want to drive
        ("wish_y_m", "f8"),
        ("course", "i8"),  # the heading at which it drives there, in ticks; -1: it turns first
        ("aim", "i8"),  # the heading of a detour, in ticks
        ("ahead", "i8"),  # moves of the detour still to be made
        ("made", "i8"),  # moves of it that were made
        ("anchor_x_m", "f8"),  # where the robot was when it last got away from where it stood
        ("anchor_y_m", "f8"),
        ("tracked", "i8"),  # the goal for which progress is counted
        ("least", "i8"),  # the fewest cells that were left to it
        ("idle", "i8"),  # steps since they became fewer
        ("again", "i8"),  # 1: plan anew, for there was no progress
        ("bump_x_m", "f8", (BUMPS,)),  # what the robot lately bumped into
        ("bump_y_m", "f8", (BUMPS,)),
        ("bump_reach_m", "f8", (BUMPS,)),  # nearer to it there is no way
        ("bump_until", "i8", (BUMPS,)),  # remembered until this step
        ("bumps", "i8"),  # counts them
        ("cost", "i8"),  # of the whole route when planned, see RouteCosts; -1: there is none
        ("way_mm", "i8"),  # its length, of which what is not known to be free counts twice
        ("end", "i8"),  # the last cell of the whole route
        ("tried", "i8"),  # bits: places of its station to which it has found no way
    ],
    align=True,
)
"""One robot's route."""

NOWHERE = -1
STATION = -2
"""As a goal: the best charging station by way and queue; NEAREST - 1 - s is station s alone."""
NEAREST = -3
"""As a goal: the nearest charging station, whoever queues there."""

NO_PLACE = -1
"""As a robot's place at its station: none yet."""
WAITS = -2
"""As a robot's place at its station: all are taken, it waits near by."""

LONGEST = 256
"""A route keeps at most this many cells; what lies behind is planned when they are used up."""


@inlined
def station_goal(me):  # type: ignore[no-untyped-def]
    """Where a robot that charges wants to go: its place, its station, or the best station."""
    if me.place >= 0:
        return me.place
    if me.place == WAITS:
        return NOWHERE
    return STATION if me.station < 0 else NEAREST - 1 - me.station


@allocating
def by_goal(routes, home):  # type: ignore[no-untyped-def]
    """The robots that ask for a route, those that share a map and a goal together.

    Args:
        routes: ROUTE[N]; home: whether those to stations are asked for, or those to cells.

    Returns:
        int64[n], the robots, in order within each group; int64[groups, 2], where each group begins
        and ends, in the order of their first robots.
    """
    robots = np.empty(routes.shape[0], dtype=np.int64)
    keys = np.empty(routes.shape[0], dtype=np.int64)
    n = 0
    for i in range(routes.shape[0]):
        if routes[i].need == 1 and (routes[i].wanted <= STATION) == home:
            robots[n] = i
            keys[n] = (routes[i].map << 32) + routes[i].wanted
            n += 1
    order = np.argsort(keys[:n], kind="mergesort")
    begins = np.full(n, -1, dtype=np.int64)
    for k in range(n):
        if k == 0 or keys[order[k]] != keys[order[k - 1]]:
            begins[order[k]] = k
    groups = np.empty((n, 2), dtype=np.int64)
    found = 0
    for begin in begins:
        if begin >= 0:
            end = begin + 1
            while end < n and keys[order[end]] == keys[order[begin]]:
                end += 1
            groups[found] = begin, end
            found += 1
    return robots[order], groups[:found]


@dataclass(slots=True)
class RouteTable:
    """Where N robots are going.

    Attributes:
        state: ROUTE[N].
        cells: int32[N, 256], flat cells from the one after the start to the goal.
    """

    state: NDArray[np.void]
    cells: NDArray[np.int32]

    def ahead(self, robot: int) -> NDArray[np.int32]:
        """int32[n]: the flat cells that a robot still has to drive through."""
        route = self.state[robot]
        return self.cells[robot, route["at"] : route["kept"]]


def blank_routes(robots: int, longest: int = LONGEST) -> RouteTable:
    """N robots that go nowhere.

    Args:
        robots: N. longest: cells that a route keeps.
    """
    state = np.zeros(robots, dtype=ROUTE)
    state["goal"] = state["wanted"] = NOWHERE
    state["cost"] = -1
    return RouteTable(state=state, cells=np.zeros((robots, longest), dtype=np.int32))
