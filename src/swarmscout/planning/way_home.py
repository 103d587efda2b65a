"""When the way home asks a robot to go and charge.

A robot knows a way to a station that is no longer than the one it last looked up and what it has
driven since, for it can drive back as it came. Only when its charge would soon not suffice for that
does it look the way up again, on its own map: the way to the best station by way and queue, see
:mod:`swarmscout.planning.docking`. So few searches are needed, and those of robots with the same
map are one, since all look in the same steps. A robot that is held up on its way, until its charge
does not suffice for what is left, looks for a nearer station.
"""

from __future__ import annotations

import numpy as np

from swarmscout.core.cells import cell_of
from swarmscout.core.enums import EXPLORE, FORWARD, NO_CONTACT
from swarmscout.core.jit import inlined, kernel
from swarmscout.planning.route_table import NEAREST, NO_PLACE, NOWHERE, STATION

__all__ = ["LOOK_EVERY", "ask_ways", "take_nearest", "take_ways"]

LOOK_EVERY = 5
"""Robots look their way home up in the same steps, so that one search serves many."""

AHEAD_M = 8.0
"""They look while their charge would suffice for so much more way: others may have come to the
station since, and the best one by way and queue may lie farther away."""

WORTH_IT = 0.7
"""Who runs out of charge turns to a nearer station if its way is at most this share."""


@inlined
def _looks(me, route, rules):  # type: ignore[no-untyped-def]
    """The stations among which a robot has to look for one: STATION, NEAREST, or NOWHERE."""
    if me.mode == EXPLORE:
        needed = (me.way_m + AHEAD_M) * rules.share_per_m + rules.share_reserve
        return STATION if me.charge < needed else NOWHERE
    # On its way it was held up, and passes by other stations.
    short = me.charge < (route.length - route.at) * rules.cell_m * rules.share_per_m
    return NEAREST if short and me.station >= 0 and me.place == NO_PLACE else NOWHERE


@kernel
def ask_ways(own, ear, action, contact, routes, home, rules, step):  # type: ignore[no-untyped-def]
    """Keep account of each robot's way home, and find out who has to look it up again.

    Args:
        own: MIND[N], `way_m` is written; ear: int64[N], see ``Knowledge``.
        action, contact: int64[N], what each robot did last, and what it felt.
        routes: ROUTE[N], see ``RouteTable``.
        home: ROUTE[N], written: the ways that are looked up.
        rules: DOCKING[1]; step: the current step.

    Returns:
        How many robots look.
    """
    rules = rules[0]
    asks = 0
    for i in range(own.shape[0]):
        me = own[i]
        route = home[i]
        route.need = 0
        if not me.thinks:
            continue
        if me.mode != EXPLORE:
            # It will explore again when it has charged, and is at a station then.
            me.way_m = rules.range_m
        elif action[i] == FORWARD and contact[i] == NO_CONTACT:
            me.way_m += rules.forward_m
        wanted = _looks(me, routes[i], rules)
        if step % LOOK_EVERY == 0 and wanted != NOWHERE:
            route.need = 1
            route.wanted = wanted
            route.here = cell_of(me.x_m, me.y_m, rules)
            route.map = ear[i]
            route.end = -1
            route.goal = NOWHERE
            asks += 1
    return asks


@kernel
def take_ways(own, home, stations):  # type: ignore[no-untyped-def]
    """Take over the ways that were looked up.

    Args:
        own: MIND[N], `way_m` is written.
        home: ROUTE[N], see :func:`ask_ways`.
        stations: float64[k, 2].
    """
    for i in range(own.shape[0]):
        route = home[i]
        if route.goal != STATION:
            continue
        route.goal = NOWHERE
        me = own[i]
        if route.cost >= 0:
            me.way_m = route.way_mm / 1000.0
        elif me.way_m == np.inf:
            # Its map shows no way yet: twice the straight one, until it has seen more.
            for s in range(stations.shape[0]):
                dx = stations[s, 0] - me.x_m
                dy = stations[s, 1] - me.y_m
                me.way_m = min(me.way_m, 2.0 * (dx * dx + dy * dy) ** 0.5)


@kernel
def take_nearest(own, home, routes, docks, rules):  # type: ignore[no-untyped-def]
    """A robot whose charge does not suffice any more turns to a station that is much nearer.

    Args:
        own: MIND[N], `station` is written.
        home: ROUTE[N], see :func:`ask_ways`.
        routes: ROUTE[N], see ``RouteTable``; `tried` is written.
        docks: int64[n, 2], see ``dock_cells``; rules: DOCKING[1].
    """
    for i in range(own.shape[0]):
        route = home[i]
        if route.goal != NEAREST:
            continue
        route.goal = NOWHERE
        left_m = (routes[i].length - routes[i].at) * rules[0].cell_m
        if route.cost < 0 or route.way_mm > 1000.0 * WORTH_IT * left_m:
            continue
        for d in range(docks.shape[0]):
            if docks[d, 0] == route.end and docks[d, 1] != own[i].station:
                own[i].station = docks[d, 1]
                routes[i].tried = 0
                break
