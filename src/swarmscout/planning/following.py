"""Along a route: when to plan anew, and which action comes next.

A route is kept until its goal changes, a cell on it closes, the robot is pushed off it, or its
cells are used up. Toward the next waypoint a robot turns while it is off by more than half a turn,
and drives otherwise (paper, "Task description": stop, fixed forward motion, fixed rotations).
"""

from __future__ import annotations

import math

from swarmscout.core.codes import CHARGE, FORWARD, LEFT, NO_CONTACT, RIGHT, STOP
from swarmscout.core.jit import kernel
from swarmscout.minds.minds import DESTINATION, MODE
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

# A robot this many cells away from its next waypoint was pushed off its route.
OFF_ROUTE_CELLS = 2.5


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
        wanted = STATION if state[i, MODE] == CHARGE else state[i, DESTINATION]
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
            waypoint = route[i, plan[i, AT]]
            dx = ox + (waypoint % columns + 0.5) * cell_m - reading[i, 0]
            dy = oy + (waypoint // columns + 0.5) * cell_m - reading[i, 1]
            need = dx * dx + dy * dy > (OFF_ROUTE_CELLS * cell_m) ** 2
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
    state, reading, sending, contact, stations, dock_m, plan, route, table,
    half_turn, waypoint_m, ox, oy, cell_m, columns, action,
):  # fmt: skip
    """Choose each robot's next action from its own route, pose and bumps.

    Deviation: where something blocks the way twice, the robot keeps right: it turns right once,
    moves on there, longer each time, and then takes up its route. Two robots that meet head-on
    part; one that fails again turns on, so in a crowd or a corner it tries every heading in turn.

    Args:
        state: int64[N, columns], reading: float64[N, 4], sending: bool[N]: ``Minds``.
        contact: int64[N], what each robot felt at its last move.
        stations: float64[k, 2]; dock_m: near enough to a station to charge, in metres.
        plan, route: ``RouteTable``; table: float64[3600, 2] of (cos, sin).
        half_turn: half of one rotation, in ticks; waypoint_m: this near to a waypoint, the robot
            goes on to the next.
        ox, oy, cell_m, columns: the grid's frame.
        action: int64[N], written: STOP, FORWARD, LEFT or RIGHT.
    """
    cos_half = table[half_turn, 0]
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
        while plan[i, AT] < longest:
            waypoint = route[i, plan[i, AT]]
            dx = ox + (waypoint % columns + 0.5) * cell_m - x
            dy = oy + (waypoint // columns + 0.5) * cell_m - y
            if dx * dx + dy * dy > waypoint_m * waypoint_m:
                break
            plan[i, AT] += 1
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
        if along >= cos_half * (dx * dx + dy * dy) ** 0.5:
            action[i] = FORWARD
            plan[i, CLEAR] += 1
            if plan[i, CLEAR] >= 4:
                plan[i, STUCK] = 0
        elif across > 0.0:
            action[i] = LEFT
        else:
            action[i] = RIGHT
