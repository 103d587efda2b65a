"""When a team needs a new destination, and how members learn of it.

"After any member reaches the assigned target, the leader selects a new target" (paper, "Task
description"). Deviation: the scenario ``paper`` also drops a destination that is not a candidate of
the task any more or overdue, and a team avoids for a while what it gave up; ``paper-literal`` does
not. A place whose frontiers persist although robots stood within reach is closed in the end, for
all robots that heard of it, as all have the same sensor (:mod:`swarmscout.minds.given_up`); a place
that a team could not get to is avoided by that team alone.
"""

from __future__ import annotations

import math

import numpy as np

from swarmscout.core.cells import offset
from swarmscout.core.enums import (
    DROP,
    NO_CAUSE,
    NONE_YET,
    NOT_CANDIDATE,
    OVERDUE,
    REACHED,
    UNREACHABLE,
)
from swarmscout.core.events import note
from swarmscout.core.grid import GRID
from swarmscout.core.jit import inlined, kernel
from swarmscout.minds.given_up import FOR_GOOD, avoided_until, place_of, remember
from swarmscout.minds.modes import is_on_task

__all__ = [
    "RENEWAL",
    "avoid_given_up",
    "due_step",
    "find_stale",
    "report_reached",
    "share_destinations",
]

NEAR_M = 2.0
"""A leader this near to a frontier that vanishes may have seen it off."""

RENEWAL = np.dtype(
    [
        *GRID.descr,  # the frame of the map
        ("candidate_bit", "i8"),  # in a cell's mark, see CheckedTask
        ("reach_m", "f8"),  # this near to the destination's centre it is reached
        ("stale_rule", "?"),  # also drop what is not a candidate any more, or overdue
        ("avoid_steps", "i8"),  # for this long a team avoids a cell that it gave up
        ("closes", "?"),  # places are closed in the end, see CheckedTask
        ("place_cells", "i8"),  # edge of a place, in cells: see ``minds.given_up``
    ],
    align=True,
)
"""The rules of renewal."""


def due_step(step: int, distance_m: float, forward_m: float, factor: float, extra: int) -> int:
    """The step after which a destination chosen now is overdue.

    Args:
        step: the current step.
        distance_m: straight distance to the destination; forward_m: length of a move.
        factor, extra: overdue after `factor` times the straight time plus `extra` steps.
    """
    return step + math.ceil(factor * distance_m / forward_m) + extra


@kernel
def report_reached(own, notices, routes, rules):  # type: ignore[no-untyped-def]
    """Each member tells its leader when it has reached the team's destination.

    Where a body has no room in reach of it, it is reached at the end of the route.

    Args:
        own: MIND[N]; notices: NOTICE[N], `reached` is written.
        routes: ROUTE[N], see ``RouteTable``.
        rules: RENEWAL[1].
    """
    rules = rules[0]
    for i in range(own.shape[0]):
        me = own[i]
        notices[i].reached = -1
        cell = me.destination
        if not me.thinks or cell < 0 or not is_on_task(me.mode):
            continue
        dx, dy = offset(cell, me.x_m, me.y_m, rules)
        route = routes[i]
        ended = route.goal == cell and route.cost >= 0 and route.at >= route.length
        if ended or dx * dx + dy * dy <= rules.reach_m * rules.reach_m:
            notices[i].reached = cell


@inlined
def _hear_reports(own, ear, heard, notices, step):  # type: ignore[no-untyped-def]
    """Leaders whose team has reached its destination hear of it: cause REACHED."""
    for i in range(own.shape[0]):
        own[i].cause = NO_CAUSE
    for j in range(notices.shape[0]):
        if notices[j].reached < 0:
            continue
        # The notice is addressed to j's leader, which reads it if it heard j in this step.
        i = notices[j].leader
        if heard[ear[i], j].step == step and notices[j].reached == own[i].destination:
            own[i].cause = REACHED


@inlined
def _cause(me, candidate, no_route, stale_rule, step):  # type: ignore[no-untyped-def]
    """Why a leader's team needs a destination, a code of CAUSES."""
    if me.destination < 0:
        return NONE_YET
    if me.cause == REACHED:
        return REACHED
    if stale_rule and not candidate:
        return NOT_CANDIDATE
    if no_route:
        return UNREACHABLE
    if stale_rule and step > me.due_at:
        return OVERDUE
    return NO_CAUSE


@kernel
def find_stale(own, ear, heard, notices, marks, given_up, routes, rules, step, events):  # type: ignore[no-untyped-def]
    """Each leader decides whether its team needs a new destination; `cause` says why.

    What it gives up goes into its notice. A leader that found none lately does not need one yet.

    Args:
        own: MIND[N], written: cause, destination, doubts; ear, heard, notices: see ``Knowledge``.
        marks: uint8[R, C'], which cells are candidates, see ``CheckedTask``.
        given_up: GIVEN_UP[N, 256], see ``Minds``; routes: ROUTE[N], see ``RouteTable``.
        rules: RENEWAL[1]; step: the current step; events: see ``EventLog``.

    Returns:
        How many leaders need a destination.
    """
    rules = rules[0]
    asking = 0
    _hear_reports(own, ear, heard, notices, step)
    for i in range(own.shape[0]):
        me = own[i]
        notices[i].given_up = -1
        if not me.thinks or me.leader != i or not is_on_task(me.mode):
            me.cause = NO_CAUSE
            continue
        cell = me.destination
        if cell < 0 and step < me.look_at:
            me.cause = NO_CAUSE
            continue
        candidate = cell >= 0 and marks[ear[i], cell] & rules.candidate_bit != 0
        closed = cell >= 0 and avoided_until(given_up[i], place_of(cell, rules)) == FOR_GOOD
        no_route = routes[i].failed_until > 0
        me.cause = _cause(me, candidate and not closed, no_route, rules.stale_rule, step)
        if me.cause == NO_CAUSE:
            continue
        asking += 1
        if cell < 0:
            continue
        me.destination = -1
        me.doubts = me.doubts or me.cause == UNREACHABLE
        note(events, DROP, i, me.cause, cell)
        dx, dy = offset(cell, me.x_m, me.y_m, rules)
        near = dx * dx + dy * dy <= NEAR_M * NEAR_M
        failed = near if me.cause == NOT_CANDIDATE else candidate
        if rules.avoid_steps > 0 and not closed and failed:
            notices[i].given_up = cell
            notices[i].why = me.cause
    return asking


@kernel
def avoid_given_up(own, ear, heard, notices, avoided, avoided_next, given_up, rules, step):  # type: ignore[no-untyped-def]
    """Robots remember what leaders gave up, whichever robot leads their team next.

    Args:
        own: MIND[N], written: doubts; ear, heard, notices: see ``Knowledge``.
        avoided, avoided_next, given_up: see ``Minds``; written.
        rules: RENEWAL[1]; step: the current step.
    """
    rules = rules[0]
    # Who gave something up; and whether that concerns other teams, too.
    givers = np.empty(notices.shape[0], dtype=np.int64)
    places = np.empty(notices.shape[0], dtype=np.int64)
    public = np.empty(notices.shape[0], dtype=np.bool_)
    n = 0
    for j in range(notices.shape[0]):
        told = notices[j]
        if told.given_up >= 0:
            givers[n] = j
            places[n] = place_of(told.given_up, rules)
            public[n] = told.why == REACHED or told.why == NOT_CANDIDATE
            n += 1
    for i in range(own.shape[0]):
        me = own[i]
        if not me.thinks:
            continue
        row = heard[ear[i]]
        for g in range(n):
            told = notices[givers[g]]
            ours = told.team == me.team
            if row[givers[g]].step != step:
                continue
            me.doubts = me.doubts or told.why == UNREACHABLE
            if ours and told.why != NOT_CANDIDATE:
                slot = avoided_next[i] % avoided.shape[1]
                avoided[i, slot, 0] = told.given_up
                avoided[i, slot, 1] = step + rules.avoid_steps
                avoided_next[i] += 1
            if rules.closes and (ours or public[g]):
                remember(given_up[i], places[g], told.why, ours, rules.avoid_steps, step)


@kernel
def share_destinations(own, ear, heard, notices, step):  # type: ignore[no-untyped-def]
    """Members take over their leader's destination as it is now, where they hear it.

    Args:
        own: MIND[N], written: destination, due_at, target.
        ear, heard, notices: see ``Knowledge``; step: the current step.
    """
    for i in range(own.shape[0]):
        me = own[i]
        leader = me.leader
        if (
            me.thinks
            and leader != i
            and is_on_task(me.mode)
            and heard[ear[i], leader].step == step
            and notices[leader].step == step
            and notices[leader].team == me.team
        ):
            me.destination = notices[leader].destination
            me.due_at = notices[leader].due_at
        me.target = me.destination
