"""Whom a robot has near it, and what it expects of them, as far as it has heard.

Robots are looked for in buckets, so that a swarm of thousands costs a thousand times one robot.
"""

from __future__ import annotations

import math

import numpy as np

from swarmscout.core.cells import cell_of
from swarmscout.core.enums import CHARGE
from swarmscout.core.grid import GRID
from swarmscout.core.jit import inlined
from swarmscout.core.segments import way_distance2
from swarmscout.mapping.footprint import STATION_ZONE

__all__ = [
    "ALONE",
    "CLEAR_M",
    "FAR",
    "JAMMED",
    "MOST_NEAR",
    "MOVES",
    "NEIGHBOUR",
    "RIGHTS",
    "SECOND_LEG",
    "TAKEN",
    "empty_buckets",
    "fill_buckets",
    "look_round",
    "may_meet",
    "meets",
    "turns_to",
]

RIGHTS = np.dtype(
    [
        *GRID.descr,  # the frame of the map
        ("edge_m", "f8"),  # of the buckets in which robots look for each other
        ("bucket_rows", "i8"),
        ("bucket_columns", "i8"),
        ("radius_m", "f8"),  # the robots' body
        ("forward_m", "f8"),
        ("turn_ticks", "i8"),
        ("aside", "i8"),  # turns between two headings that are compared
    ],
    align=True,
)
"""How robots keep clear of each other."""

NEIGHBOUR = np.dtype(
    [
        ("x_m", "f8"),
        ("y_m", "f8"),
        ("dx_m", "f8"),  # one move in the direction in which it means to drive
        ("dy_m", "f8"),
        ("starts", "i8"),  # turns until it looks there; FAR: it stands
        ("following", "i8"),  # the next robot in its bucket, or -1
        ("wants", "?"),  # it wants to drive
        ("charges", "?"),  # it has to charge
        ("first", "?"),  # it goes first: that depends on who looks
        ("known", "?"),  # the above has been found out, apart from its place
    ],
    align=True,
)
"""What a robot expects of one that is near."""

MOST_NEAR = 48
MOVES = 5
"""Number of moves looked ahead."""
SECOND_LEG = 3
"""Number of moves looked ahead after a detour."""
CLEAR_M = 0.01
"""Where beacons say that bodies nearly touch, rounding must not decide."""
SLACK_M = 1e-6
"""Who is farther away by this than bodies touch surely is, however numbers are rounded."""
TURN_STEPS = 20
"""Number of steps after which the order of robots rotates."""
BUSY_STEPS = 6
"""A robot that has stayed in place for this many steps is not expected to drive on: otherwise two
robots would wait for each other."""
FAR = 1 << 20
ALONE, JAMMED, TAKEN = 0, 1, 2
"""What a move runs into: nothing, a robot that wants to drive on too, or one that stays."""


@inlined
def turns_to(heading, wanted, turn, ticks):  # type: ignore[no-untyped-def]
    """How many turns, to the left if positive, bring a heading nearest to another one."""
    off = wanted - heading
    if off >= ticks - ticks // 2:
        off -= ticks
    elif off < -(ticks // 2):
        off += ticks
    turns = (abs(off) + turn // 2) // turn
    return turns if off > 0 else -turns


@inlined
def _bucket(x, y, rules):  # type: ignore[no-untyped-def]
    """Row and column of the bucket of a believed position; those off the map are in the rim."""
    row = int(math.floor((y - rules.origin_y_m) / rules.edge_m))
    col = int(math.floor((x - rules.origin_x_m) / rules.edge_m))
    row = min(rules.bucket_rows - 1, max(0, row))
    return row, min(rules.bucket_columns - 1, max(0, col))


@inlined
def fill_buckets(heard, chain, seen, rules):  # type: ignore[no-untyped-def]
    """Put the robots that a row has heard of into buckets.

    Args:
        heard: BEACON[N].
        chain: int64[buckets], written: the first robot in each bucket; all -1 before.
        seen: NEIGHBOUR[N], written: where each robot is.
        rules: RIGHTS.
    """
    for j in range(heard.shape[0] - 1, -1, -1):
        if heard[j].step >= 0:
            robot = seen[j]
            robot.x_m = heard[j].x_m
            robot.y_m = heard[j].y_m
            robot.known = False
            row, col = _bucket(robot.x_m, robot.y_m, rules)
            robot.following = chain[row * rules.bucket_columns + col]
            chain[row * rules.bucket_columns + col] = j


@inlined
def empty_buckets(heard, chain, rules):  # type: ignore[no-untyped-def]
    """Empty the buckets again."""
    for j in range(heard.shape[0]):
        if heard[j].step >= 0:
            row, col = _bucket(heard[j].x_m, heard[j].y_m, rules)
            chain[row * rules.bucket_columns + col] = -1


@inlined
def _expect(robot, beacon, step, headings, rules):  # type: ignore[no-untyped-def]
    """Write down what is expected of a robot; it is the same for all that look."""
    robot.known = True
    robot.charges = beacon.mode == CHARGE
    robot.wants = beacon.step == step and beacon.aim >= 0
    robot.dx_m = 0.0
    robot.dy_m = 0.0
    robot.starts = FAR
    if robot.wants and beacon.still < BUSY_STEPS:
        robot.dx_m = rules.forward_m * headings[beacon.aim, 0]
        robot.dy_m = rules.forward_m * headings[beacon.aim, 1]
        ticks = headings.shape[0]
        robot.starts = abs(turns_to(beacon.heading, beacon.aim, rules.turn_ticks, ticks))


@inlined
def _rank(j, shift, robots):  # type: ignore[no-untyped-def]
    """The place of a robot in the order, which has been shifted by some places."""
    return j + shift if j + shift < robots else j + shift - robots


@inlined
def _can_be_met(other, first, x, y, rules):  # type: ignore[no-untyped-def]
    """Whether any way of a robot at (x, y), of the moves looked ahead, can lead to a neighbour.

    After t steps the robot is at most t moves away. It gives way only to neighbours that go first;
    the present place of the others matters in the first step only.
    """
    dx = other.x_m - x
    dy = other.y_m - y
    apart = 2.0 * rules.radius_m + CLEAR_M + SLACK_M
    stands = other.starts == FAR
    near_m = (MOVES + SECOND_LEG if stands else 1) * rules.forward_m + apart
    # Who drives away with enough of a lead is not caught up with.
    lead_m = other.starts * rules.forward_m + apart
    leaves = dx * other.dx_m + dy * other.dy_m >= lead_m * rules.forward_m
    # Without branches, which could not be foreseen.
    return (dx * dx + dy * dy <= near_m * near_m) | (first & (not stands) & (not leaves))


@inlined
def _list_near(me, chain, seen, around, i, reach, rules):  # type: ignore[no-untyped-def]
    """List the robots within reach; returns how many, or as many as there is room for."""
    low_row, low_col = _bucket(me.x_m - reach, me.y_m - reach, rules)
    high_row, high_col = _bucket(me.x_m + reach, me.y_m + reach, rules)
    n = 0
    for row in range(low_row, high_row + 1):
        for bucket in range(
            row * rules.bucket_columns + low_col, row * rules.bucket_columns + high_col + 1
        ):
            j = chain[bucket]
            while j >= 0:
                dx = seen[j].x_m - me.x_m
                dy = seen[j].y_m - me.y_m
                # Written in any case, and kept if it counts: whether it does cannot be foreseen.
                around[n] = j
                n += (j != i) & (dx * dx + dy * dy <= reach * reach)
                if n == around.shape[0]:
                    return n
                j = seen[j].following
    return n


@inlined
def look_round(me, heard, status, chain, seen, around, near, i, step, headings, rules):  # type: ignore[no-untyped-def]
    """List the robots near robot i, and what it expects of those it can meet.

    In a dense crowd it looks less far.

    Args:
        heard, chain, seen: of :func:`fill_buckets`. status: uint8[C'], of the robot's map.
        around: int64[MOST_NEAR + 1], written: the robots that are near.
        near: NEIGHBOUR[MOST_NEAR + 1], written: those that it can meet in the moves looked ahead.

    Returns:
        How many robots are near, and how many of them it can meet.
    """
    reach = 2.0 * MOVES * rules.forward_m + 2.0 * rules.radius_m
    n = _list_near(me, chain, seen, around, i, reach, rules)
    while n > MOST_NEAR:
        reach *= 0.7
        n = _list_near(me, chain, seen, around, i, reach, rules)
    robots = heard.shape[0]
    shift = step // TURN_STEPS % robots
    rank = _rank(i, shift, robots)
    charges = heard[i].mode == CHARGE
    met = 0
    for k in range(n):
        j = around[k]
        if not seen[j].known:
            _expect(seen[j], heard[j], step, headings, rules)
        first = _rank(j, shift, robots) < rank
        if seen[j].charges != charges:
            # Who has to charge cannot wait; but who has charged leaves before others come in.
            explorer = heard[i] if seen[j].charges else heard[j]
            leaves = status[cell_of(explorer.x_m, explorer.y_m, rules)] & STATION_ZONE != 0
            first = seen[j].charges != leaves
        near[met] = seen[j]
        near[met].first = first
        met += _can_be_met(seen[j], first, me.x_m, me.y_m, rules)
    return n, met


@inlined
def meets(other, x, y, dx, dy, t, rules):  # type: ignore[no-untyped-def]
    """Whether a move from (x, y) by (dx, dy), t steps from now, comes too near to a neighbour.

    Returns:
        ALONE, JAMMED (it wants to drive on too) or TAKEN (it stays).
    """
    apart = 2.0 * rules.radius_m + CLEAR_M
    if t == 0 or other.starts == FAR:
        # Where it is now; who is too near already may drive away.
        gap2 = way_distance2(x, y, dx, dy, other.x_m, other.y_m)
        ex = x + dx - other.x_m
        ey = y + dy - other.y_m
        away = ex * dx + ey * dy > 0.0 and gap2 >= (x - other.x_m) ** 2 + (y - other.y_m) ** 2
        if gap2 < apart * apart and not away:
            return JAMMED if other.wants else TAKEN
    if other.first and other.starts != FAR:
        made = max(0, t - other.starts)
        vx = other.dx_m if t >= other.starts else 0.0
        vy = other.dy_m if t >= other.starts else 0.0
        ox = other.x_m + made * other.dx_m
        oy = other.y_m + made * other.dy_m
        # Seen from it, this robot moves by the relative motion.
        if way_distance2(x, y, dx - vx, dy - vy, ox, oy) < apart * apart:
            return JAMMED
    return ALONE


@inlined
def _passes_by(px, py, dx, dy, apart):  # type: ignore[no-untyped-def]
    """Whether a way from the origin by (dx, dy), however far, surely keeps apart from a point."""
    along = px * dx + py * dy
    across = px * dy - py * dx
    length2 = dx * dx + dy * dy
    away2 = px * px + py * py
    return away2 > apart * apart and (along <= 0.0 or across * across > apart * apart * length2)


@inlined
def may_meet(other, x, y, dx, dy, start, most, rules):  # type: ignore[no-untyped-def]
    """Whether it is worth looking move by move if `most` moves by (dx, dy) meet a neighbour."""
    apart = 2.0 * rules.radius_m + CLEAR_M + SLACK_M
    px = other.x_m - x
    py = other.y_m - y
    away2 = px * px + py * py
    drives = other.first and other.starts != FAR
    if drives and start >= other.starts:
        made = start - other.starts
        vx = other.dx_m
        vy = other.dy_m
        if not _passes_by(px + made * vx, py + made * vy, dx - vx, dy - vy, apart):
            return True
        # In the first step it counts where it is, too.
        return start == 0 and away2 <= (rules.forward_m + apart) ** 2
    if drives:
        moves = most + max(0, start + most - other.starts)
        return away2 <= (moves * rules.forward_m + apart) ** 2
    if other.starts != FAR:
        return start == 0 and away2 <= (rules.forward_m + apart) ** 2
    return away2 <= (most * rules.forward_m + apart) ** 2 and not _passes_by(px, py, dx, dy, apart)
