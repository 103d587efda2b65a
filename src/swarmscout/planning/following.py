"""Along a route: when to plan anew, and which action comes next.

A route is kept until its goal changes, a cell on it closes, the robot is pushed off it, or its
cells are used up. Toward its waypoint a robot turns while it is off by more than three quarters of
a turn, and drives otherwise (paper, "Task description": stop, fixed forward motion, fixed
rotations). With half a turn, the least that is possible, it would turn to and fro all the time.

Deviation: the waypoint is the farthest of the next cells of the route to which the straight way is
not occupied. Headings are 40° apart and a grid's moves 45°: from cell to cell it would turn at
nearly every one.
"""

from __future__ import annotations

import math

from swarmscout.core.enums import CHARGE, FORWARD, LEFT, NO_CONTACT, RIGHT, STOP
from swarmscout.core.jit import inlined, kernel
from swarmscout.minds.minds import MODE, TARGET
from swarmscout.planning.route_table import (
    AHEAD,
    AT,
    CLEAR,
    FAILED_UNTIL,
    GOAL,
    LENGTH,
    NEED,
    NOWHERE,
    STATION,
    STUCK,
    WANTED,
)

__all__ = ["find_needs", "steer"]

# A robot this far from where it should be along its route was pushed off it.
OFF_ROUTE_CELLS = 2.5
OFF_ROUTE_M = 2.5
# The waypoint is at most so many cells ahead.
SIGHT_CELLS = 8


@inlined
def _offset(cell, x, y, ox, oy, cell_m, columns):  # type: ignore[no-untyped-def]
    """From a point to the centre of a cell, in metres."""
    return (
        ox + (cell % columns + 0.5) * cell_m - x,
        oy + (cell // columns + 0.5) * cell_m - y,
    )


@inlined
def _line_is_free(price, u, v, du, dv, columns):  # type: ignore[no-untyped-def]
    """Whether no cell that a line from (u, v) by (du, dv) passes, in cells, is occupied.

    Source: Amanatides, Woo (1987), "A fast voxel traversal algorithm for ray tracing".
    """
    rows = price.shape[0] // columns
    col = int(math.floor(u))
    row = int(math.floor(v))
    step_u = 1 if du > 0.0 else -1
    step_v = 1 if dv > 0.0 else -1
    per_u = abs(1.0 / du) if du != 0.0 else math.inf
    per_v = abs(1.0 / dv) if dv != 0.0 else math.inf
    next_u = (col + 1 - u if du > 0.0 else u - col) * per_u if du != 0.0 else math.inf
    next_v = (row + 1 - v if dv > 0.0 else v - row) * per_v if dv != 0.0 else math.inf
    while True:
        if row < 0 or row >= rows or col < 0 or col >= columns or price[row * columns + col] < 0:
            return False
        if min(next_u, next_v) > 1.0:
            return True
        if next_u < next_v:
            col += step_u
            next_u += per_u
        else:
            row += step_v
            next_v += per_v


@inlined
def _lane_is_free(price, x, y, dx, dy, half_width_m, ox, oy, cell_m, columns):  # type: ignore[no-untyped-def]
    """Whether neither side of a straight lane from (x, y) by (dx, dy) meets an occupied cell."""
    across = half_width_m / (dx * dx + dy * dy) ** 0.5
    for side in (-across, across):
        u = (x - side * dy - ox) / cell_m
        v = (y + side * dx - oy) / cell_m
        if not _line_is_free(price, u, v, dx / cell_m, dy / cell_m, columns):
            return False
    return True


@kernel
def find_needs(  # type: ignore[no-untyped-def]
    state, reading, sending, price, counts, still, heard_reading, long_still,
    plan, route, at_cell, dearer, ox, oy, cell_m, columns, step,
):  # fmt: skip
    """Say where each robot wants to go, and whether it needs a route for that.

    Args:
        state: int64[N, columns], reading: float64[N, 4], sending: bool[N]: ``Minds``.
        price: int16[K, C], counts: int64[K, 4]: ``OccupancyGrids``; counts[:, 0] says how many
            cells closed in the last update.
        still: int64[K, N], heard_reading: float64[K, N, 4]: what is known of the others.
        long_still: robots that have not moved for so many steps make routes dearer.
        plan: int64[N, columns], route: int32[N, longest]: ``RouteTable``.
        at_cell: int64[N], written: the cell that each robot believes to be in.
        dearer: int64[K, N], written: cells of robots that stand for long, and -1.
        ox, oy, cell_m, columns: the grid's frame; step: the current step.

    Returns:
        How many robots need a route.
    """
    robots = state.shape[0]
    maps = price.shape[0]
    rows = price.shape[1] // columns
    needs = 0
    for k in range(maps):
        for j in range(robots):
            dearer[k, j] = -1
            if still[k, j] >= long_still:
                row = int(math.floor((heard_reading[k, j, 1] - oy) / cell_m))
                col = int(math.floor((heard_reading[k, j, 0] - ox) / cell_m))
                if 0 <= row < rows and 0 <= col < columns:
                    dearer[k, j] = row * columns + col
    for i in range(robots):
        plan[i, NEED] = 0
        if not sending[i]:
            plan[i, WANTED] = NOWHERE
            continue
        row = min(rows - 1, max(0, int(math.floor((reading[i, 1] - oy) / cell_m))))
        col = min(columns - 1, max(0, int(math.floor((reading[i, 0] - ox) / cell_m))))
        at_cell[i] = row * columns + col
        wanted = STATION if state[i, MODE] == CHARGE else state[i, TARGET]
        plan[i, WANTED] = wanted
        if wanted == NOWHERE:
            plan[i, GOAL] = NOWHERE
            plan[i, LENGTH] = 0
            plan[i, FAILED_UNTIL] = 0
            continue
        if plan[i, GOAL] != wanted:
            need = True
        elif plan[i, FAILED_UNTIL] > 0:
            need = step >= plan[i, FAILED_UNTIL]
        elif plan[i, AT] >= plan[i, LENGTH]:
            need = False
        elif plan[i, AT] >= route.shape[1]:
            need = True
        else:
            dx, dy = _offset(
                route[i, plan[i, AT]], reading[i, 0], reading[i, 1], ox, oy, cell_m, columns
            )
            need = dx * dx + dy * dy > max(OFF_ROUTE_CELLS * cell_m, OFF_ROUTE_M) ** 2
            m = i if maps > 1 else 0
            if counts[m, 0] > 0:
                before = at_cell[i]
                for a in range(plan[i, AT], min(plan[i, LENGTH], route.shape[1])):
                    cell = route[i, a]
                    # The two cells beside a diagonal move count too: no corner is cut.
                    beside = before // columns * columns + cell % columns
                    across = cell // columns * columns + before % columns
                    if price[m, cell] < 0 or (
                        a > plan[i, AT] and (price[m, beside] < 0 or price[m, across] < 0)
                    ):
                        need = True
                        break
                    before = cell
        if need:
            plan[i, NEED] = 1
            needs += 1
    return needs


@kernel
def steer(  # type: ignore[no-untyped-def]
    state, reading, sending, price, contact, stations, dock_m, plan, route, table,
    most_off, waypoint_m, half_width_m, ox, oy, cell_m, columns, action,
):  # fmt: skip
    """Choose each robot's next action from its own route, pose and bumps.

    Deviation: where something blocks the way twice, the robot keeps right: it turns right once,
    moves on there, longer each time, and then takes up its route. Two robots that meet head-on
    part; one that fails again turns on, so in a crowd or a corner it tries every heading in turn.

    Args:
        state: int64[N, columns], reading: float64[N, 4], sending: bool[N]: ``Minds``.
        price: int16[K, C]: ``OccupancyGrids``.
        contact: int64[N], what each robot felt at its last move.
        stations: float64[k, 2]; dock_m: near enough to a station to charge, in metres.
        plan, route: ``RouteTable``; table: float64[3600, 2] of (cos, sin).
        most_off: a robot that is off by more turns, in ticks; waypoint_m: this near to a cell of
            the route, the robot goes on to the next.
        half_width_m: of the lane that has to be free on the straight way to a waypoint.
        ox, oy, cell_m, columns: the grid's frame.
        action: int64[N], written: STOP, FORWARD, LEFT or RIGHT.
    """
    cos_off = table[most_off, 0]
    for i in range(state.shape[0]):
        action[i] = STOP
        if not sending[i] or plan[i, WANTED] == NOWHERE:
            continue
        blocked = contact[i] != NO_CONTACT
        x = reading[i, 0]
        y = reading[i, 1]
        longest = min(plan[i, LENGTH], route.shape[1])
        dx = 0.0
        dy = 0.0
        m = i if price.shape[0] > 1 else 0
        while plan[i, AT] < longest:
            dx, dy = _offset(route[i, plan[i, AT]], x, y, ox, oy, cell_m, columns)
            if dx * dx + dy * dy > waypoint_m * waypoint_m:
                break
            plan[i, AT] += 1
        # Where something was in the way, it goes from cell to cell.
        sight = SIGHT_CELLS if plan[i, STUCK] == 0 and not blocked else 1
        for a in range(min(longest, plan[i, AT] + sight) - 1, plan[i, AT], -1):
            far_x, far_y = _offset(route[i, a], x, y, ox, oy, cell_m, columns)
            if not _lane_is_free(
                price[m], x, y, far_x, far_y, half_width_m, ox, oy, cell_m, columns
            ):
                continue
            # What lies before it is as good as driven once the robot is nearer to what follows.
            while plan[i, AT] < a:
                ax, ay = _offset(route[i, plan[i, AT] + 1], x, y, ox, oy, cell_m, columns)
                if ax * ax + ay * ay > dx * dx + dy * dy:
                    break
                plan[i, AT] += 1
                dx = ax
                dy = ay
            dx = far_x
            dy = far_y
            break
        if plan[i, GOAL] == STATION and (blocked or plan[i, AT] >= longest):
            docked = False
            for s in range(stations.shape[0]):
                sx = stations[s, 0] - x
                sy = stations[s, 1] - y
                if sx * sx + sy * sy <= dock_m * dock_m:
                    docked = True
            if docked:
                # It stays: what blocked it is most likely another robot that charges.
                plan[i, AT] = plan[i, LENGTH]
                continue
        if blocked:
            plan[i, STUCK] += 1
            plan[i, CLEAR] = 0
            plan[i, AHEAD] = 0
            if plan[i, STUCK] >= 2:
                action[i] = RIGHT
                plan[i, AHEAD] = min(5, plan[i, STUCK] // 2)
                continue
        if plan[i, AHEAD] > 0:
            plan[i, AHEAD] -= 1
            action[i] = FORWARD
            continue
        if plan[i, AT] >= longest:
            continue
        tick = int(reading[i, 2])
        along = dx * table[tick, 0] + dy * table[tick, 1]
        across = dy * table[tick, 0] - dx * table[tick, 1]
        if along >= cos_off * (dx * dx + dy * dy) ** 0.5:
            action[i] = FORWARD
            plan[i, CLEAR] += 1
            if plan[i, CLEAR] >= 4:
                plan[i, STUCK] = 0
        elif across > 0.0:
            action[i] = LEFT
        else:
            action[i] = RIGHT
