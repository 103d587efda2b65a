"""Motion: stop, a fixed forward move, fixed rotations (paper, "Task description"), and contact.

A forward move that would touch a wall or another robot on its way is not made. All robots move at
the same time and in straight lines, so two robots keep clear of each other exactly if their
relative motion, which is straight too, stays farther than their diameters from zero.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from swarmscout.core.enums import FORWARD, LEFT, NO_CONTACT, RIGHT, ROBOT_CONTACT, WALL_CONTACT
from swarmscout.core.jit import inlined, kernel
from swarmscout.core.segments import way_distance2
from swarmscout.robots.bodies import Bodies
from swarmscout.worlds.world import World

__all__ = ["MOTION", "Motion", "move"]


MOTION = np.dtype(
    [
        ("origin_x_m", "f8"),  # of the world's raster
        ("origin_y_m", "f8"),
        ("resolution_m", "f8"),
        ("edge_m", "f8"),  # of a bucket: at least what two robots can cover towards each other
        ("bucket_rows", "i8"),
        ("bucket_columns", "i8"),
        ("radius_m", "f8"),
        ("forward_m", "f8"),
        ("turn_ticks", "i8"),
    ],
    align=True,
)
"""The raster, buckets over it, and the robots' body."""

NEIGHBOUR = np.dtype([("x_m", "f8"), ("y_m", "f8"), ("following", "i8")], align=True)
"""Where a robot was at the start of the step, and the next robot in its bucket, or -1."""


@inlined
def _box_distance2(px, py, left, bottom, res):  # type: ignore[no-untyped-def]
    """Squared distance from a point to a square with its lower left corner at (left, bottom)."""
    dx = max(left - px, 0.0, px - left - res)
    dy = max(bottom - py, 0.0, py - bottom - res)
    return dx * dx + dy * dy


@inlined
def _crosses(x, y, dx, dy, left, bottom, res):  # type: ignore[no-untyped-def]
    """Whether the way from (x, y) by (dx, dy) crosses a square (slab test)."""
    enter = 0.0
    leave = 1.0
    for axis in range(2):
        start = x if axis == 0 else y
        delta = dx if axis == 0 else dy
        low = left if axis == 0 else bottom
        if delta == 0.0:
            if start < low or start > low + res:
                return False
        else:
            a = (low - start) / delta
            b = (low + res - start) / delta
            enter = max(enter, min(a, b))
            leave = min(leave, max(a, b))
    return enter <= leave


@inlined
def _wall_on_way(free, ox, oy, res, x, y, dx, dy, radius, at):  # type: ignore[no-untyped-def]
    """Whether a disc that moves from (x, y) by (dx, dy) touches a wall; `at` gets the place.

    Exact for discs and square cells: the distance between a segment and a square is 0 where they
    cross, and otherwise lies at an end of the segment or at a corner of the square.
    """
    rows, columns = free.shape
    reach2 = (radius - 1e-9) ** 2
    col_low = int(math.floor((min(x, x + dx) - radius - ox) / res))
    col_high = int(math.floor((max(x, x + dx) + radius - ox) / res))
    row_low = int(math.floor((min(y, y + dy) - radius - oy) / res))
    row_high = int(math.floor((max(y, y + dy) + radius - oy) / res))
    nearest = np.inf
    for row in range(row_low, row_high + 1):
        for col in range(col_low, col_high + 1):
            inside = 0 <= row < rows and 0 <= col < columns
            if inside and free[row, col] != 0:
                continue
            left = ox + col * res
            bottom = oy + row * res
            # The two ends first: they are cheap, and decide most cases.
            start2 = _box_distance2(x, y, left, bottom, res)
            end2 = _box_distance2(x + dx, y + dy, left, bottom, res)
            distance2 = min(start2, end2)
            if distance2 >= reach2:
                for corner in range(4):
                    px = left + (corner % 2) * res
                    py = bottom + (corner // 2) * res
                    distance2 = min(distance2, way_distance2(x, y, dx, dy, px, py))
                if distance2 >= reach2 and _crosses(x, y, dx, dy, left, bottom, res):
                    distance2 = 0.0
            if distance2 < reach2 and end2 < nearest:
                nearest = end2
                # A little inside the wall, so that the place lies in the wall's cell.
                inset = 0.25 * res
                at[0] = min(max(x + dx, left + inset), left + res - inset)
                at[1] = min(max(y + dy, bottom + inset), bottom + res - inset)
    return nearest < np.inf


@inlined
def _bucket(x, y, rules):  # type: ignore[no-untyped-def]
    """Row and column of the bucket that a point lies in."""
    return (
        int((y - rules.origin_y_m) / rules.edge_m),
        int((x - rules.origin_x_m) / rules.edge_m),
    )


@inlined
def _robot_on_way(i, dx, dy, position, first, neighbours, rules):  # type: ignore[no-untyped-def]
    """The lowest robot that i touches on its way by (dx, dy), or -1."""
    x = neighbours[i].x_m
    y = neighbours[i].y_m
    apart2 = (2.0 * rules.radius_m - 1e-9) ** 2
    row, col = _bucket(x, y, rules)
    touched = -1
    for near_row in range(max(0, row - 1), min(rules.bucket_rows, row + 2)):
        for near_col in range(max(0, col - 1), min(rules.bucket_columns, col + 2)):
            j = first[near_row * rules.bucket_columns + near_col]
            while j >= 0:
                # Seen from j, robot i moves from (x - xj, y - yj) by the relative motion.
                rx = dx - (position[j, 0] - neighbours[j].x_m)
                ry = dy - (position[j, 1] - neighbours[j].y_m)
                if (
                    j != i
                    and way_distance2(x, y, rx, ry, neighbours[j].x_m, neighbours[j].y_m) < apart2
                    and (touched < 0 or j < touched)
                ):
                    touched = j
                j = neighbours[j].following
    return touched


@kernel
def move(free, position, heading, can, touch, action, first, neighbours, headings, rules, step):  # type: ignore[no-untyped-def]
    """Carry out one action per robot.

    Which robot goes first rotates with the step, so that none always gives way. A robot takes those
    before it in the order as they really moved and the others as standing; they in turn check
    against its real move, so every pair is checked in full.

    Args:
        free: uint8[rows, columns], the world's raster.
        position, heading, can, touch: see ``Bodies``; written.
        action: int64[N], codes STOP, FORWARD, LEFT, RIGHT; ignored where a robot cannot drive.
        first: int64[buckets], scratch, the first robot in each bucket; all -1 between steps.
        neighbours: NEIGHBOUR[N], scratch.
        headings: float64[3600, 2] of (cos, sin); rules: MOTION[1]; step: the current step.
    """
    rules = rules[0]
    robots = position.shape[0]
    ticks = headings.shape[0]
    for i in range(robots):
        neighbours[i].x_m = position[i, 0]
        neighbours[i].y_m = position[i, 1]
        touch[i].kind = NO_CONTACT
        touch[i].robot = -1
        row, col = _bucket(position[i, 0], position[i, 1], rules)
        neighbours[i].following = first[row * rules.bucket_columns + col]
        first[row * rules.bucket_columns + col] = i
    at = np.empty(2)
    for k in range(robots):
        i = (k + step) % robots
        if not can[i].drive:
            continue
        if action[i] == LEFT:
            heading[i] = (heading[i] + rules.turn_ticks) % ticks
        elif action[i] == RIGHT:
            heading[i] = (heading[i] - rules.turn_ticks) % ticks
        if action[i] != FORWARD:
            continue
        x = neighbours[i].x_m
        y = neighbours[i].y_m
        dx = rules.forward_m * headings[heading[i], 0]
        dy = rules.forward_m * headings[heading[i], 1]
        if _wall_on_way(
            free, rules.origin_x_m, rules.origin_y_m, rules.resolution_m, x, y, dx, dy,
            rules.radius_m, at,
        ):  # fmt: skip
            touch[i].kind = WALL_CONTACT
            touch[i].dx_m = at[0] - x
            touch[i].dy_m = at[1] - y
            continue
        touch[i].robot = _robot_on_way(i, dx, dy, position, first, neighbours, rules)
        if touch[i].robot >= 0:
            touch[i].kind = ROBOT_CONTACT
        else:
            position[i, 0] = x + dx
            position[i, 1] = y + dy
    for i in range(robots):
        row, col = _bucket(neighbours[i].x_m, neighbours[i].y_m, rules)
        first[row * rules.bucket_columns + col] = -1


class Motion:
    """Phase 8 of a step: every robot that can drive stops, drives, or turns; see :func:`move`.

    Args:
        world: what robots may touch.
        robots: N.
        radius_m, forward_m: metres. turn_ticks: of one rotation.
        headings: float64[3600, 2], (cos, sin).
        edge_m: edge of the buckets in which robots look for each other; by default what two robots
            can cover towards each other in a step.
    """

    def __init__(
        self,
        world: World,
        robots: int,
        radius_m: float,
        forward_m: float,
        turn_ticks: int,
        headings: NDArray[np.float64],
        *,
        edge_m: float | None = None,
    ) -> None:
        left, right, bottom, top = world.extent
        edge_m = edge_m or max(1.0, 2.0 * radius_m + 2.0 * forward_m + 1e-6)
        rows = math.ceil((top - bottom) / edge_m) + 1
        columns = math.ceil((right - left) / edge_m) + 1
        values = (left, bottom, world.resolution_m, edge_m, rows, columns)
        self._rules = np.array([(*values, radius_m, forward_m, turn_ticks)], dtype=MOTION)
        self._free = world.free
        self._first = np.full(rows * columns, -1, dtype=np.int64)
        self._neighbours = np.zeros(robots, dtype=NEIGHBOUR)
        self._headings = headings

    def carry_out(self, action: NDArray[np.int64], bodies: Bodies, step: int) -> None:
        """Move the bodies.

        Args:
            action: int64[N]. bodies: moved. step: the current step.
        """
        move(
            self._free, bodies.position, bodies.heading, bodies.can, bodies.touch, action,
            self._first, self._neighbours, self._headings, self._rules, step,
        )  # fmt: skip
