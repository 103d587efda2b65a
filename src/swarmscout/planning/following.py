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

from swarmscout.core.cells import cell_of, offset
from swarmscout.core.enums import CHARGE, NO_CONTACT, OCCUPIED, STOP, WALL_CONTACT
from swarmscout.core.grid import GRID
from swarmscout.core.jit import inlined, kernel
from swarmscout.mapping.footprint import LABEL_BITS, TIGHT
from swarmscout.mapping.occupancy import CLOSED
from swarmscout.planning.route_table import NOWHERE, station_goal

__all__ = ["DRIVING", "find_needs", "steer"]

DRIVING = np.dtype(
    [
        *GRID.descr,  # the frame of the map
        ("radius_m", "f8"),  # the robots' body
        ("forward_m", "f8"),
        ("still_m", "f8"),  # a robot that stays within this distance stands
        ("progress_cells", "i8"),  # coming nearer to the goal by this many cells is progress
        ("most_off", "i8"),  # a robot whose heading is off by more turns, in ticks
        ("turn_ticks", "i8"),  # of one rotation
        ("ahead_m", "f8"),  # what has to be free of walls for a move
        ("stride", "i8"),  # cells between two that may be waypoints
        ("waypoint_m", "f8"),  # this near to a cell of the route, the robot goes on to the next
        ("half_width_m", "f8"),  # of the lane that has to be free on the way to a waypoint
        ("dock_m", "f8"),  # near enough to a station to charge
    ],
    align=True,
)
"""How robots follow their routes."""

# A robot this far from where it should be along its route was pushed off it.
OFF_ROUTE_CELLS = 2.5
OFF_ROUTE_M = 2.5
# Near enough to charge, a robot gives up its way to its place after so many steps on the spot if
# something blocks it, and twice as many else.
PATIENT = 3
# Largest number of strides from a robot to its waypoint.
SIGHT_STRIDES = 8
# Steps for which a robot remembers a wall or a robot that it bumped into, and for which it follows
# its route from cell to cell after a wall.
WALL_STEPS = 40
ROBOT_STEPS = 4
CAREFUL_STEPS = 8
# Steps without progress after which it plans anew, and after which it gives up.
REPLAN_STEPS = 12
FAIL_STEPS = 24


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
def _way_is_closed(status, route, cells, columns):  # type: ignore[no-untyped-def]
    """Whether a cell of what is left of a route, or one beside a diagonal move, has no room."""
    before = route.here
    for a in range(route.at, route.kept):
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
        route.here = cell_of(me.x_m, me.y_m, grid)
        route.map = ear[i]
        wanted = station_goal(me) if me.mode == CHARGE else me.target
        route.wanted = wanted
        if wanted == NOWHERE:
            route.goal = NOWHERE
            route.length = 0
            route.kept = 0
            route.failed_until = 0
            continue
        if route.goal != wanted or route.again != 0:
            need = True
            route.again = 0
        elif route.failed_until > 0:
            need = step >= route.failed_until
        elif route.at >= route.length:
            need = False
        elif route.at >= route.kept:
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
    longest = route.kept
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
def _course(status, me, dx, dy, headings, grid):  # type: ignore[no-untyped-def]
    """The heading at which a robot drives to a waypoint at (dx, dy); -1: it has to turn first.

    Of the two headings on either side of the way it drives at the one that keeps clear of walls.
    """
    enough = headings[grid.most_off, 0] * (dx * dx + dy * dy) ** 0.5
    along = dx * headings[me.heading, 0] + dy * headings[me.heading, 1]
    if along < enough:
        return -1
    if not _may_move(status, me, me.heading, headings, grid):
        left = dy * headings[me.heading, 0] - dx * headings[me.heading, 1] > 0.0
        turn = grid.turn_ticks if left else -grid.turn_ticks
        other = (me.heading + turn) % headings.shape[0]
        turned = dx * headings[other, 0] + dy * headings[other, 1]
        if turned >= enough and (turned > along or _may_move(status, me, other, headings, grid)):
            return other
    return me.heading


@inlined
def _is_docked(me, stations, dock_m):  # type: ignore[no-untyped-def]
    """Whether a robot is near enough to a station to charge."""
    for s in range(stations.shape[0]):
        dx = stations[s, 0] - me.x_m
        dy = stations[s, 1] - me.y_m
        if dx * dx + dy * dy <= dock_m * dock_m:
            return True
    return False


@inlined
def _remember_bump(me, route, touch, headings, grid, step):  # type: ignore[no-untyped-def]
    """Keep in mind where the last move was stopped: walls for long, robots for a moment."""
    b = route.bumps % route.bump_until.shape[0]
    route.bumps += 1
    dx = headings[me.heading, 0]
    dy = headings[me.heading, 1]
    px = (grid.radius_m + grid.forward_m) * dx
    py = (grid.radius_m + grid.forward_m) * dy
    route.bump_until[b] = step + ROBOT_STEPS
    if touch.kind == WALL_CONTACT:
        px = touch.dx_m
        py = touch.dy_m
        route.bump_until[b] = step + WALL_STEPS
    # The same move shall count as blocked, wherever on its side the wall was touched.
    along = min(grid.forward_m, max(0.0, px * dx + py * dy))
    gap2 = (px - along * dx) ** 2 + (py - along * dy) ** 2
    route.bump_x_m[b] = me.x_m + px
    route.bump_y_m[b] = me.y_m + py
    route.bump_reach_m[b] = max(grid.radius_m, gap2**0.5) + 0.01


@inlined
def _note_displacement(me, route, grid):  # type: ignore[no-untyped-def]
    """Count for how long the robot has stayed about where it is; turning to and fro is staying."""
    dx = me.x_m - route.anchor_x_m
    dy = me.y_m - route.anchor_y_m
    if dx * dx + dy * dy >= grid.still_m * grid.still_m:
        route.anchor_x_m = me.x_m
        route.anchor_y_m = me.y_m
        me.still = 0
    else:
        me.still += 1


@inlined
def _note_progress(route, grid, step):  # type: ignore[no-untyped-def]
    """Count for how long the robot has come no nearer to its goal along its route.

    After a while it plans anew, round those who stand about; in the end the route has failed, so
    the leader gives the goal up instead of driving at a wall for ever.
    """
    left = route.length - route.at
    if route.tracked != route.goal:
        route.tracked = route.goal
        route.least = left
        route.idle = 0
    elif left <= route.least - grid.progress_cells:
        route.least = left
        route.idle = 0
    else:
        # A new route may be longer.
        route.least = max(route.least, left)
        route.idle += 1
    route.again = route.idle > 0 and route.idle % REPLAN_STEPS == 0
    if route.idle >= FAIL_STEPS:
        route.failed_until = step + 10
        route.length = 0
        route.kept = 0
        route.cost = -1
        route.idle = 0
        route.again = 0


@kernel
def steer(own, ear, status, touch, stations, routes, cells, headings, grid, step, action):  # type: ignore[no-untyped-def]
    """Find each robot's waypoint on its own route, and note what stopped it.

    Args:
        own: MIND[N], `still` is written; ear: int64[N], see ``Knowledge``.
        status: uint8[R, C'], ``OccupancyGrids``.
        touch: TOUCH[N], what each robot felt at its last move.
        stations: float64[k, 2].
        routes: ROUTE[N], cells: int32[N, longest]: ``RouteTable``; the wish is written.
        headings: float64[3600, 2] of (cos, sin); grid: DRIVING[1]; step: the current step.
        action: int64[N], written: STOP; see ``keep_clear`` for those who want to drive.
    """
    grid = grid[0]
    for i in range(own.shape[0]):
        me = own[i]
        route = routes[i]
        action[i] = STOP
        route.wish_x_m = 0.0
        route.wish_y_m = 0.0
        if not me.thinks:
            continue
        _note_displacement(me, route, grid)
        blocked = touch[i].kind != NO_CONTACT
        if blocked:
            _remember_bump(me, route, touch[i], headings, grid, step)
        if route.wanted == NOWHERE:
            continue
        # Where a wall was in the way, it goes from cell to cell.
        sight = SIGHT_STRIDES * grid.stride
        for b in range(route.bump_until.shape[0]):
            if route.bump_until[b] > step + WALL_STEPS - CAREFUL_STEPS:
                sight = 1
        dx, dy = _next_waypoint(me, route, cells[i], status[ear[i]], sight, grid)
        longest = route.kept
        if (
            me.mode == CHARGE
            and (route.at >= longest or me.still >= (PATIENT if blocked else 2 * PATIENT))
            and _is_docked(me, stations, grid.dock_m)
        ):
            # It stays: what blocks it is most likely another robot that charges.
            route.at = route.length
            continue
        if route.at >= longest:
            continue
        _note_progress(route, grid, step)
        if route.length > 0:
            route.wish_x_m = dx
            route.wish_y_m = dy
            route.course = _course(status[ear[i]], me, dx, dy, headings, grid)
