"""Right of way: how robots keep clear of each other, each from what it has heard.

A robot knows from beacons where its neighbours are, where they look, and in which direction they
mean to drive. It drives straight toward its waypoint if it expects to meet nobody there. Otherwise
it compares, by the steps until the waypoint, three things: to drive on until something is in the
way, to wait until the way is free, and to turn aside for a few moves and then go on. A detour is
kept until it is done or blocked, so nobody turns to and fro; among equal ones robots keep right.

Of two robots whose ways cross, both know which goes first, and it takes turns; only the other one
gives way. Nobody drives into a place that it knows to be taken. Deviation: the paper does not say
how robots pass each other.

Source: Fiorini and Shiller (1998), "Motion planning in dynamic environments using velocity
obstacles" (headings that lead to a collision within a few steps are left out, others are compared
by the time to the goal); priorities in place of van den Berg, Lin and Manocha (2008), "Reciprocal
velocity obstacles", since robots that only stop, turn or drive cannot each take half of the effort.
"""

from __future__ import annotations

import math

import numpy as np

from swarmscout.core.cells import cell_at
from swarmscout.core.enums import CHARGE, FORWARD, LEFT, OCCUPIED, RIGHT, STOP
from swarmscout.core.jit import inlined, kernel
from swarmscout.core.segments import way_distance2
from swarmscout.mapping.footprint import LABEL_BITS, TIGHT
from swarmscout.planning.neighbours import (
    ALONE,
    JAMMED,
    MOST_NEAR,
    MOVES,
    NEIGHBOUR,
    SECOND_LEG,
    empty_buckets,
    fill_buckets,
    look_round,
    may_meet,
    meets,
    turns_to,
)

__all__ = ["keep_clear"]

WAITS = 3
"""Largest number of steps for which a robot waits for others to pass."""
PATIENCE_STEPS = 4
"""Among others that want to drive on a robot waits for its turn, but not for ever."""
WAIT_COST = 3.0
MOST_DETOUR = 8.0
"""In a crowd a robot rather stays than makes a longer detour, in steps."""
# Sums of steps are not compared more closely than this before they are computed in full.
ROUNDING = 1e-6
# What it costs, in steps, to stop before a robot or a wall.
STOP_COST = 4.0


@inlined
def _is_closed(status, route, x, y, dx, dy, step, rules):  # type: ignore[no-untyped-def]
    """Whether a move leads into an occupied cell, or against what the robot has bumped into."""
    for b in range(route.bump_until.shape[0]):
        if route.bump_until[b] >= step:
            px = route.bump_x_m[b]
            py = route.bump_y_m[b]
            if (
                way_distance2(x, y, dx, dy, px, py) < route.bump_reach_m[b] ** 2
                and (px - x) * dx + (py - y) * dy > 0.0
            ):
                return True
    row, col = cell_at(x + dx, y + dy, rules)
    if row < 0 or row >= rules.rows or col < 0 or col >= rules.columns:
        return True
    cell = row * rules.columns + col
    if status[route.here] & TIGHT:
        # It gets out of cells without room, through any that is not occupied.
        return status[cell] & LABEL_BITS == OCCUPIED and cell != route.here
    return status[cell] & TIGHT != 0


@inlined
def _free_moves(status, route, near, x, y, dx, dy, start, most, step, rules):  # type: ignore[no-untyped-def]
    """How many moves by (dx, dy) are free, of at most `most`, the first one at time `start`."""
    free = most
    for n in range(near.shape[0]):
        if free == 0:
            return 0
        if not may_meet(near[n], x, y, dx, dy, start, free, rules):
            continue
        at_x = x
        at_y = y
        for m in range(free):
            if meets(near[n], at_x, at_y, dx, dy, start + m, rules) != ALONE:
                free = m
                break
            at_x += dx
            at_y += dy
    for m in range(free):
        if _is_closed(status, route, x, y, dx, dy, step, rules):
            return m
        x += dx
        y += dy
    return free


@inlined
def _is_jammed(near, x, y, dx, dy, t, rules):  # type: ignore[no-untyped-def]
    """Whether the first one whom a move comes too near to wants to drive on too."""
    for n in range(near.shape[0]):
        met = meets(near[n], x, y, dx, dy, t, rules)
        if met != ALONE:
            return met == JAMMED
    return False


@inlined
def _second_leg(status, route, near, x, y, gx, gy, start, step, best, rules):  # type: ignore[no-untyped-def]
    """Steps from (x, y) to a goal (gx, gy) that lies straight ahead, more if the way is taken.

    Whether it is taken does not matter where the steps until `start` and these are `best` or more.
    """
    dx = gx - x
    dy = gy - y
    away = (dx * dx + dy * dy) ** 0.5
    moves = away / rules.forward_m
    if moves < 0.5 or start + moves >= best:
        return moves
    scale = rules.forward_m / away
    most = min(SECOND_LEG, int(math.ceil(moves)))
    free = _free_moves(status, route, near, x, y, dx * scale, dy * scale, start, most, step, rules)
    return moves + (STOP_COST - free if free < most else 0.0)


@inlined
def _worth_trying(me, gx, gy, dx, dy, spent, best, rules):  # type: ignore[no-untyped-def]
    """The largest number of moves after which the straight way on could still make less time."""
    for m in range(MOVES, 0, -1):
        rest_x = gx - (me.x_m + m * dx)
        rest_y = gy - (me.y_m + m * dy)
        moves = (rest_x * rest_x + rest_y * rest_y) ** 0.5 / rules.forward_m
        if spent + m + moves < best:
            return m
    return 0


@inlined
def _best_detour(me, status, route, near, wanted, step, headings, best, rules):  # type: ignore[no-untyped-def]
    """The heading, and moves along it, that make the least time to the waypoint.

    Args:
        best: only ways that take fewer steps than this are looked for.

    Returns:
        The heading in ticks, and the number of moves; 0 moves: none is better.
    """
    ticks = headings.shape[0]
    best_heading = 0
    best_moves = 0
    gx = me.x_m + route.wish_x_m
    gy = me.y_m + route.wish_y_m
    least = (route.wish_x_m**2 + route.wish_y_m**2) ** 0.5 / rules.forward_m - ROUNDING
    straight = turns_to(me.heading, wanted, rules.turn_ticks, ticks)
    half = ticks // (2 * rules.turn_ticks * rules.aside)
    for k in range(2 * half + 1):
        # Right before left: among equals robots keep right.
        side = -(k + 1) // 2 if k % 2 == 1 else k // 2
        if abs(side) * rules.aside + least >= best:
            break
        turns = straight + side * rules.aside
        heading = (me.heading + turns * rules.turn_ticks) % ticks
        turns = abs(turns_to(me.heading, heading, rules.turn_ticks, ticks))
        dx = rules.forward_m * headings[heading, 0]
        dy = rules.forward_m * headings[heading, 1]
        before = turns + abs(side) * rules.aside
        if before + least >= best:
            continue
        most = _worth_trying(me, gx, gy, dx, dy, before, best, rules)
        free = _free_moves(status, route, near, me.x_m, me.y_m, dx, dy, turns, most, step, rules)
        for m in range(1, free + 1):
            spent = turns + m + abs(side) * rules.aside
            x = me.x_m + m * dx
            y = me.y_m + m * dy
            time = spent + _second_leg(status, route, near, x, y, gx, gy, spent, step, best, rules)
            if time < best:
                best, best_heading, best_moves = time, heading, m
    return best_heading, best_moves


@inlined
def _way_back(me, status, route, heard, around, near, step, headings, rules):  # type: ignore[no-untyped-def]
    """The heading, and moves along it, that lead out of a crowd; 0 moves: it is shut in.

    Who stands at the rim makes room this way for those in the middle, who cannot.
    """
    ticks = headings.shape[0]
    out_x = 0.0
    out_y = 0.0
    for j in around:
        dx = me.x_m - heard[j].x_m
        dy = me.y_m - heard[j].y_m
        away2 = max(dx * dx + dy * dy, rules.radius_m * rules.radius_m)
        out_x += dx / away2
        out_y += dy / away2
    length = max((out_x * out_x + out_y * out_y) ** 0.5, 1e-9)
    best = -math.inf
    best_heading = 0
    best_moves = 0
    half = ticks // (2 * rules.turn_ticks * rules.aside)
    for k in range(-half, half + 1):
        turns = k * rules.aside
        heading = (me.heading + turns * rules.turn_ticks) % ticks
        dx = rules.forward_m * headings[heading, 0]
        dy = rules.forward_m * headings[heading, 1]
        free = _free_moves(
            status, route, near, me.x_m, me.y_m, dx, dy, abs(turns), MOVES, step, rules
        )
        outward = (out_x * headings[heading, 0] + out_y * headings[heading, 1]) / length
        good = free + 2.0 * outward - 0.3 * abs(turns)
        if free >= 1 and good > best:
            best, best_heading, best_moves = good, heading, free
    return best_heading, best_moves


@inlined
def _turn_or_drive(turns):  # type: ignore[no-untyped-def]
    """The action that brings a robot onto a heading some turns to its left, or along it."""
    if turns == 0:
        return FORWARD
    return LEFT if turns > 0 else RIGHT


@inlined
def _set_out(me, route, heading, moves, turn, ticks):  # type: ignore[no-untyped-def]
    """Begin a detour of some moves; returns the action."""
    me.aim = heading
    route.aim = heading
    turns = turns_to(me.heading, heading, turn, ticks)
    route.made = 1 if turns == 0 else 0
    route.ahead = moves - route.made
    return _turn_or_drive(turns)


@inlined
def _heading_of(dx, dy, ticks):  # type: ignore[no-untyped-def]
    """The heading toward (dx, dy), in ticks."""
    return int(round(math.atan2(dy, dx) * ticks / (2.0 * math.pi))) % ticks


@inlined
def _drive(me, status, route, heard, around, near, i, step, headings, rules):  # type: ignore[no-untyped-def]
    """One robot's action; `aim` and its detour are written."""
    ticks = headings.shape[0]
    turn = rules.turn_ticks
    wx = route.wish_x_m
    wy = route.wish_y_m
    away = (wx * wx + wy * wy) ** 0.5
    course = route.course if route.course >= 0 else _heading_of(wx, wy, ticks)
    turns = turns_to(me.heading, course, turn, ticks)
    heading = (me.heading + turns * turn) % ticks
    dx = rules.forward_m * headings[heading, 0]
    dy = rules.forward_m * headings[heading, 1]
    most = min(MOVES, max(1, int(math.ceil(away / rules.forward_m))))
    x = me.x_m
    y = me.y_m
    free = _free_moves(status, route, near, x, y, dx, dy, abs(turns), most, step, rules)
    if route.ahead > 0 and (free < most or route.made == 0):
        kept = turns_to(me.heading, route.aim, turn, ticks)
        ax = rules.forward_m * headings[route.aim, 0]
        ay = rules.forward_m * headings[route.aim, 1]
        # While it turns, others come and go: it looks again before it drives.
        if kept != 0 or _free_moves(status, route, near, x, y, ax, ay, 0, 1, step, rules) > 0:
            me.aim = route.aim
            if kept == 0:
                route.ahead -= 1
                route.made += 1
            return _turn_or_drive(kept)
    route.ahead = 0
    me.aim = heading
    if free == most:
        return _turn_or_drive(turns)
    # Who goes to charge makes no room: where it insists, those that have charged get out behind.
    lost = max(me.still, route.idle // 2) if me.mode != CHARGE else 0
    if free == 0 and lost >= PATIENCE_STEPS + (i + step) % PATIENCE_STEPS:
        back, moves = _way_back(me, status, route, heard, around, near, step, headings, rules)
        if moves > 0:
            return _set_out(me, route, back, moves, turn, ticks)
    # To drive on as far as it is free, to wait, or to turn aside?
    time = abs(turns) + away / rules.forward_m + MOST_DETOUR
    stay = True
    if free > 0:
        stay = False
        time = abs(turns) + away / rules.forward_m + STOP_COST + (most - free)
    wait = 0
    for w in range(1, WAITS + 1):
        start = max(abs(turns), w)
        if start + away / rules.forward_m >= time:
            break
        # To turn takes as long as to wait: that is not free, as just seen.
        if (
            start > abs(turns)
            and _free_moves(status, route, near, x, y, dx, dy, start, most, step, rules) == most
        ):
            time = start + away / rules.forward_m + 0.5
            wait = w
            stay = False
            break
    patient = free == 0 and wait == 0 and me.still < PATIENCE_STEPS
    if patient and _is_jammed(near, x, y, dx, dy, abs(turns), rules):
        time = abs(turns) + away / rules.forward_m + WAIT_COST
        wait = 1
        stay = False
    wanted = _heading_of(wx, wy, ticks)
    other, moves = _best_detour(me, status, route, near, wanted, step, headings, time, rules)
    if moves > 0:
        return _set_out(me, route, other, moves, turn, ticks)
    if turns == 0 and (stay or wait > 0):
        return STOP
    return _turn_or_drive(turns)


@inlined
def _look_and_drive(  # type: ignore[no-untyped-def]
    me, status, route, heard, chain, seen, around, near, i, step, headings, rules
):
    """One robot's action among those that it knows near it."""
    n, met = look_round(
        me, heard, status, chain, seen, around, near, i, step, headings, rules
    )  # fmt: skip
    return _drive(me, status, route, heard, around[:n], near[:met], i, step, headings, rules)


@kernel
def keep_clear(own, status, heard, listeners, groups, routes, headings, rules, chain, step, action):  # type: ignore[no-untyped-def]
    """Choose each robot's action toward its waypoint so that it keeps clear of others.

    Args:
        own: MIND[N], `aim` is written: the heading in which a robot means to drive, -1: it stands.
        status: uint8[R, C']: ``OccupancyGrids``.
        heard: BEACON[R, N]; listeners: int64[N]; groups: int64[A, 3]: see ``Knowledge``.
        routes: ROUTE[N]: the wish says where the waypoint is; detours are written.
        headings: float64[3600, 2] of (cos, sin); rules: RIGHTS[1].
        chain: int64[buckets], scratch: the first robot in each bucket, all -1 between calls.
        step: the current step.
        action: int64[N], written where a robot wants to drive.
    """
    rules = rules[0]
    around = np.empty(MOST_NEAR + 1, dtype=np.int64)
    near = np.empty(MOST_NEAR + 1, dtype=NEIGHBOUR)
    seen = np.empty(own.shape[0], dtype=NEIGHBOUR)
    for a in range(groups.shape[0]):
        row = groups[a, 0]
        fill_buckets(heard[row], chain, seen, rules)
        for k in range(groups[a, 1], groups[a, 2]):
            i = listeners[k]
            me = own[i]
            route = routes[i]
            me.aim = -1
            if route.wish_x_m == 0.0 and route.wish_y_m == 0.0:
                route.ahead = 0
                continue
            action[i] = _look_and_drive(
                me,
                status[row],
                route,
                heard[row],
                chain,
                seen,
                around,
                near,
                i,
                step,
                headings,
                rules,
            )
        empty_buckets(heard[row], chain, rules)
