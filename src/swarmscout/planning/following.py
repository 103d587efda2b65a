"""Along a route: when to plan anew, and which action comes next.

A route is kept until its goal changes, a cell on it closes, the robot is pushed off it, or its
cells are used up. Toward its waypoint a robot turns while it is off by more than three quarters of
a turn, and drives otherwise (paper, "Task description": stop, fixed forward motion, fixed
rotations). With half a turn, the least that is possible, it would turn to and fro all the time.

Deviation: the waypoint is the farthest of the next cells of the route to which the straight way
has room for the robot. Headings are 40° apart and a grid's moves 45°: from cell to cell it would
turn at nearly every one. And where a move at its heading would bring it near to what is occupied, a
robot takes the heading on the other side of its course.
"""

from __future__ import annotations

import math

import numpy as np

from swarmscout.core.cells import offset
from swarmscout.core.enums import CHARGE, FORWARD, LEFT, NO_CONTACT, OCCUPIED, RIGHT, STOP
from swarmscout.core.jit import inlined, kernel
from swarmscout.mapping.footprint import LABEL_BITS, TIGHT
from swarmscout.mapping.occupancy import CLOSED
from swarmscout.planning.route_table import NOWHERE, STATION

__all__ = ["DRIVING", "find_needs", "mark_standing", "steer"]

DRIVING = np.dtype(
    [
        ("origin_x_m", "f8"),  # the grid's frame
        ("origin_y_m", "f8"),
        ("cell_m", "f8"),
        ("rows", "i8"),
        ("columns", "i8"),
        ("long_still", "i8"),  # robots that have not moved for this many steps make routes dearer
        ("most_off", "i8"),  # a robot whose heading is off by more turns, in ticks
        ("turn_ticks", "i8"),  # of one rotation
        ("ahead_m", "f8"),  # what has to be free of walls for a move
        ("stride", "i8"),  # cells between two that may be waypoints
        ("waypoint_m", "f8"),  # this near to a cell of the route, the robot goes on to the next
        ("radius_m", "f8"),  # of a robot
        ("half_width_m", "f8"),  # of the lane that has to be free on the way to a waypoint
        ("dock_m", "f8"),  # near enough to a station to charge
    ],
    align=True,
)
"""How robots follow their routes."""

# A robot this far from where it should be along its route was pushed off it.
OFF_ROUTE_CELLS = 2.5
OFF_ROUTE_M = 2.5
# The waypoint is at most so many strides ahead.
SIGHT_STRIDES = 8


@inlined
def _line_is_free(status, u, v, du, dv, grid, body):  # type: ignore[no-untyped-def]
    """Whether no cell that a line from (u, v) by (du, dv) passes, in cells, is occupied.

    For the line on which a body's centre moves (`body`), none may be without room.

    Source: Amanatides, Woo (1987), "A fast voxel traversal algorithm for ray tracing".
    """
    rows = grid.rows
    columns = grid.columns
    col = int(math.floor(u))
    row = int(math.floor(v))
    step_u = 1 if du > 0.0 else -1
    step_v = 1 if dv > 0.0 else -1
    per_u = abs(1.0 / du) if du != 0.0 else math.inf
    per_v = abs(1.0 / dv) if dv != 0.0 else math.inf
    next_u = (col + 1 - u if du > 0.0 else u - col) * per_u if du != 0.0 else math.inf
    next_v = (row + 1 - v if dv > 0.0 else v - row) * per_v if dv != 0.0 else math.inf
    while True:
        if row < 0 or row >= rows or col < 0 or col >= columns:
            return False
        cell = status[row * columns + col]
        if (cell & TIGHT != 0) if body else (cell & LABEL_BITS == OCCUPIED):
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
def _lane_is_free(status, x, y, dx, dy, half_width_m, grid):  # type: ignore[no-untyped-def]
    """Whether a straight lane from (x, y) by (dx, dy) has room for a robot.

    What lies between its sides and is occupied leaves no room in its middle.
    """
    across = half_width_m / (dx * dx + dy * dy) ** 0.5
    for side in (0.0, -across, across):
        u = (x - side * dy - grid.origin_x_m) / grid.cell_m
        v = (y + side * dx - grid.origin_y_m) / grid.cell_m
        du = dx / grid.cell_m
        dv = dy / grid.cell_m
        if not _line_is_free(status, u, v, du, dv, grid, side == 0.0):
            return False
    return True


@inlined
def _cell_at(x, y, grid):  # type: ignore[no-untyped-def]
    """Row and column of a point; they may lie outside the grid."""
    return (
        int(math.floor((y - grid.origin_y_m) / grid.cell_m)),
        int(math.floor((x - grid.origin_x_m) / grid.cell_m)),
    )


@kernel
def mark_standing(heard, still, rows, grid, standing):  # type: ignore[no-untyped-def]
    """List the cells in which robots are known to stand for long.

    Args:
        heard: BEACON[R, N], still: int64[R, N], rows: int64[A]: see ``Knowledge``.
        grid: DRIVING[1].
        standing: int64[R, N], written for the rows in use: flat cells, or -1.
    """
    grid = grid[0]
    for r in rows:
        for j in range(heard.shape[1]):
            standing[r, j] = -1
            if still[r, j] >= grid.long_still:
                row, col = _cell_at(heard[r, j].x_m, heard[r, j].y_m, grid)
                if 0 <= row < grid.rows and 0 <= col < grid.columns:
                    standing[r, j] = row * grid.columns + col


@inlined
def _way_is_closed(status, route, cells, columns):  # type: ignore[no-untyped-def]
    """Whether a cell of what is left of a route, or one beside a diagonal move, has no room."""
    before = route.here
    for a in range(route.at, min(route.length, cells.shape[0])):
        cell = cells[a]
        # The two cells beside a diagonal move count too: no corner is cut.
        beside = before // columns * columns + cell % columns
        across = cell // columns * columns + before % columns
        if status[cell] & TIGHT or (a > route.at and (status[beside] | status[across]) & TIGHT):
            return True
        before = cell
    return False


@kernel
def find_needs(own, ear, status, counts, routes, cells, grid, step):  # type: ignore[no-untyped-def]
    """Say where each robot wants to go, and whether it needs a route for that.

    Args:
        own: MIND[N]; ear: int64[N], see ``Knowledge``.
        status: uint8[R, C'], counts: int64[R, 4]: ``OccupancyGrids``; counts[:, 0] says how many
            cells closed in the last update.
        routes: ROUTE[N], cells: int32[N, longest]: ``RouteTable``.
        grid: DRIVING[1]; step: the current step.

    Returns:
        How many robots need a route.
    """
    grid = grid[0]
    needs = 0
    for i in range(own.shape[0]):
        me = own[i]
        route = routes[i]
        route.need = 0
        if not me.thinks:
            route.wanted = NOWHERE
            continue
        row, col = _cell_at(me.x_m, me.y_m, grid)
        row = min(grid.rows - 1, max(0, row))
        col = min(grid.columns - 1, max(0, col))
        route.here = row * grid.columns + col
        route.map = ear[i]
        wanted = STATION if me.mode == CHARGE else me.target
        route.wanted = wanted
        if wanted == NOWHERE:
            route.goal = NOWHERE
            route.length = 0
            route.failed_until = 0
            continue
        if route.goal != wanted:
            need = True
        elif route.failed_until > 0:
            need = step >= route.failed_until
        elif route.at >= route.length:
            need = False
        elif route.at >= cells.shape[1]:
            need = True
        else:
            dx, dy = offset(cells[i, route.at], me.x_m, me.y_m, grid)
            need = dx * dx + dy * dy > max(OFF_ROUTE_CELLS * grid.cell_m, OFF_ROUTE_M) ** 2
            m = ear[i]
            if counts[m, CLOSED] > 0 and not need:
                need = _way_is_closed(status[m], route, cells[i], grid.columns)
        if need:
            route.need = 1
            needs += 1
    return needs


@inlined
def _next_waypoint(me, route, cells, status, sight, grid):  # type: ignore[no-untyped-def]
    """Go on along a route to the farthest cell with a free lane; returns the offset to it.

    Looked at are the `sight` next cells, a stride apart.
    """
    longest = min(route.length, cells.shape[0])
    dx = 0.0
    dy = 0.0
    while route.at < longest:
        dx, dy = offset(cells[route.at], me.x_m, me.y_m, grid)
        if dx * dx + dy * dy > grid.waypoint_m * grid.waypoint_m:
            break
        route.at += 1
    for a in range(min(longest, route.at + sight) - 1, route.at, -grid.stride):
        far_x, far_y = offset(cells[a], me.x_m, me.y_m, grid)
        if not _lane_is_free(status, me.x_m, me.y_m, far_x, far_y, grid.half_width_m, grid):
            continue
        # What lies before it is as good as driven once the robot is nearer to what follows.
        while route.at < a:
            ax, ay = offset(cells[route.at + 1], me.x_m, me.y_m, grid)
            if ax * ax + ay * ay > dx * dx + dy * dy:
                break
            route.at += 1
            dx = ax
            dy = ay
        return far_x, far_y
    return dx, dy


@inlined
def _may_move(status, me, heading, headings, grid):  # type: ignore[no-untyped-def]
    """Whether a move at a heading keeps clear of what is known to be occupied."""
    dx = grid.ahead_m * headings[heading, 0]
    dy = grid.ahead_m * headings[heading, 1]
    return _lane_is_free(status, me.x_m, me.y_m, dx, dy, grid.radius_m, grid)


@inlined
def _toward(status, me, dx, dy, headings, grid):  # type: ignore[no-untyped-def]
    """The action that brings a robot toward a waypoint at (dx, dy).

    Of the two headings on either side of its course it drives at the one that keeps clear of walls.
    """
    enough = headings[grid.most_off, 0] * (dx * dx + dy * dy) ** 0.5
    along = dx * headings[me.heading, 0] + dy * headings[me.heading, 1]
    across = dy * headings[me.heading, 0] - dx * headings[me.heading, 1]
    side = 1 if across > 0.0 else -1
    turn = LEFT if across > 0.0 else RIGHT
    if along < enough:
        return turn
    if not _may_move(status, me, me.heading, headings, grid):
        other = (me.heading + side * grid.turn_ticks) % headings.shape[0]
        turned = dx * headings[other, 0] + dy * headings[other, 1]
        if turned >= enough and (turned > along or _may_move(status, me, other, headings, grid)):
            return turn
    return FORWARD


@inlined
def _is_docked(me, stations, dock_m):  # type: ignore[no-untyped-def]
    """Whether a robot is near enough to a station to charge."""
    for s in range(stations.shape[0]):
        dx = stations[s, 0] - me.x_m
        dy = stations[s, 1] - me.y_m
        if dx * dx + dy * dy <= dock_m * dock_m:
            return True
    return False


@kernel
def steer(own, ear, status, contact, stations, routes, cells, headings, grid, action):  # type: ignore[no-untyped-def]
    """Choose each robot's next action from its own route, pose and bumps.

    Deviation: where something blocks the way twice, the robot keeps right: it turns right once,
    moves on there, longer each time, and then takes up its route. Two robots that meet head-on
    part; one that fails again turns on, so in a crowd or a corner it tries every heading in turn.

    Args:
        own: MIND[N]; ear: int64[N], see ``Knowledge``; status: uint8[R, C'], ``OccupancyGrids``.
        contact: int64[N], what each robot felt at its last move.
        stations: float64[k, 2].
        routes: ROUTE[N], cells: int32[N, longest]: ``RouteTable``.
        headings: float64[3600, 2] of (cos, sin); grid: DRIVING[1].
        action: int64[N], written: STOP, FORWARD, LEFT or RIGHT.
    """
    grid = grid[0]
    for i in range(own.shape[0]):
        me = own[i]
        route = routes[i]
        action[i] = STOP
        if not me.thinks or route.wanted == NOWHERE:
            continue
        blocked = contact[i] != NO_CONTACT
        # Where something was in the way, it goes from cell to cell.
        sight = SIGHT_STRIDES * grid.stride if route.stuck == 0 and not blocked else 1
        dx, dy = _next_waypoint(me, route, cells[i], status[ear[i]], sight, grid)
        longest = min(route.length, cells.shape[1])
        if (
            route.goal == STATION
            and (blocked or route.at >= longest)
            and _is_docked(me, stations, grid.dock_m)
        ):
            # It stays: what blocked it is most likely another robot that charges.
            route.at = route.length
            continue
        if blocked:
            route.stuck += 1
            route.clear = 0
            route.ahead = 0
            if route.stuck >= 2:
                action[i] = RIGHT
                route.ahead = min(5, route.stuck // 2)
                continue
        if route.ahead > 0:
            route.ahead -= 1
            action[i] = FORWARD
            continue
        if route.at >= longest:
            continue
        action[i] = _toward(status[ear[i]], me, dx, dy, headings, grid)
        if action[i] == FORWARD:
            route.clear += 1
            if route.clear >= 4:
                route.stuck = 0
