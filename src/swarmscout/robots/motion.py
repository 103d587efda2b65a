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
from swarmscout.robots.bodies import Bodies
from swarmscout.worlds.world import World

__all__ = ["Neighbourhood", "carry_out", "move"]


class Neighbourhood:
    """Buckets over the world, so that a robot looks for others only where they can be.

    Attributes:
        edge_m: edge of a bucket: at least what two robots can cover towards each other in a step.
        shape: ``(rows, columns)`` of buckets.
        first: int64[buckets], the first robot in each bucket, or -1 (kept so between steps).
        following: int64[N], the next robot in the same bucket, or -1.
        before: float64[N, 2], positions at the start of the step.
    """

    def __init__(
        self,
        extent: tuple[float, float, float, float],
        robots: int,
        radius_m: float,
        forward_m: float,
    ) -> None:
        left, right, bottom, top = extent
        self.edge_m = max(1.0, 2.0 * radius_m + 2.0 * forward_m + 1e-6)
        self.shape = (
            math.ceil((top - bottom) / self.edge_m) + 1,
            math.ceil((right - left) / self.edge_m) + 1,
        )
        self.origin_m = (left, bottom)
        self.first = np.full(self.shape[0] * self.shape[1], -1, dtype=np.int64)
        self.following = np.full(robots, -1, dtype=np.int64)
        self.before = np.zeros((robots, 2))


@inlined
def _box_distance2(px, py, left, bottom, res):  # type: ignore[no-untyped-def]
    """Squared distance from a point to a square with its lower left corner at (left, bottom)."""
    dx = max(left - px, 0.0, px - left - res)
    dy = max(bottom - py, 0.0, py - bottom - res)
    return dx * dx + dy * dy


@inlined
def _way_distance2(x, y, dx, dy, px, py):  # type: ignore[no-untyped-def]
    """Squared distance from a point p to the way from (x, y) to (x + dx, y + dy)."""
    length2 = dx * dx + dy * dy
    t = 0.0
    if length2 > 0.0:
        t = min(1.0, max(0.0, ((px - x) * dx + (py - y) * dy) / length2))
    ex = x + t * dx - px
    ey = y + t * dy - py
    return ex * ex + ey * ey


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
                    distance2 = min(distance2, _way_distance2(x, y, dx, dy, px, py))
                if distance2 >= reach2 and _crosses(x, y, dx, dy, left, bottom, res):
                    distance2 = 0.0
            if distance2 < reach2 and end2 < nearest:
                nearest = end2
                # A little inside the wall, so that the place lies in the wall's cell.
                inset = 0.25 * res
                at[0] = min(max(x + dx, left + inset), left + res - inset)
                at[1] = min(max(y + dy, bottom + inset), bottom + res - inset)
    return nearest < np.inf


@kernel
def move(  # type: ignore[no-untyped-def]
    free, ox, oy, res,
    position, heading, alive, action, contact, contact_offset, touched,
    first, following, before, bucket_rows, bucket_columns, left, bottom, edge,
    radius, forward, turn, table, step,
):  # fmt: skip
    """Carry out one action per robot; see :class:`Bodies` and :class:`Neighbourhood`.

    Who goes first rotates with the step, so that no robot always gives way. A robot takes those
    before it in the order as they really moved and the others as standing; they in turn check
    against its real move, so every pair is checked in full.

    Args:
        action: int64[N], codes STOP, FORWARD, LEFT, RIGHT; ignored where not alive.
        radius, forward: metres. turn: ticks. table: float64[3600, 2] of (cos, sin).
    """
    robots = position.shape[0]
    ticks = table.shape[0]
    for i in range(robots):
        before[i, 0] = position[i, 0]
        before[i, 1] = position[i, 1]
        contact[i] = NO_CONTACT
        touched[i] = -1
        bucket = int((before[i, 1] - bottom) / edge) * bucket_columns
        bucket += int((before[i, 0] - left) / edge)
        following[i] = first[bucket]
        first[bucket] = i
    apart2 = (2.0 * radius - 1e-9) ** 2
    for k in range(robots):
        i = (k + step) % robots
        if not alive[i]:
            continue
        if action[i] == LEFT:
            heading[i] = (heading[i] + turn) % ticks
        elif action[i] == RIGHT:
            heading[i] = (heading[i] - turn) % ticks
        if action[i] != FORWARD:
            continue
        x = before[i, 0]
        y = before[i, 1]
        dx = forward * table[heading[i], 0]
        dy = forward * table[heading[i], 1]
        if _wall_on_way(free, ox, oy, res, x, y, dx, dy, radius, contact_offset[i]):
            contact[i] = WALL_CONTACT
            contact_offset[i, 0] -= x
            contact_offset[i, 1] -= y
            continue
        row = int((y - bottom) / edge)
        col = int((x - left) / edge)
        for near_row in range(max(0, row - 1), min(bucket_rows, row + 2)):
            for near_col in range(max(0, col - 1), min(bucket_columns, col + 2)):
                j = first[near_row * bucket_columns + near_col]
                while j >= 0:
                    if j != i:
                        # Seen from j, robot i moves from (x - xj, y - yj) by the relative motion.
                        rx = dx - (position[j, 0] - before[j, 0])
                        ry = dy - (position[j, 1] - before[j, 1])
                        gap2 = _way_distance2(x, y, rx, ry, before[j, 0], before[j, 1])
                        if gap2 < apart2:
                            contact[i] = ROBOT_CONTACT
                            # Of several the first, so that buckets do not matter.
                            if touched[i] < 0 or j < touched[i]:
                                touched[i] = j
                    j = following[j]
        if contact[i] == NO_CONTACT:
            position[i, 0] = x + dx
            position[i, 1] = y + dy
    for i in range(robots):
        bucket = int((before[i, 1] - bottom) / edge) * bucket_columns
        bucket += int((before[i, 0] - left) / edge)
        first[bucket] = -1


def carry_out(
    action: NDArray[np.int64],
    bodies: Bodies,
    world: World,
    near: Neighbourhood,
    radius_m: float,
    forward_m: float,
    turn_ticks: int,
    headings: NDArray[np.float64],
    step: int,
) -> None:
    """Phase 8 of a step: every living robot stops, drives, or turns; see :func:`move`.

    Args:
        action: int64[N].
        bodies: moved.
        world: what they may touch.
        near: buckets over the world.
        radius_m, forward_m, turn_ticks: of every robot.
        headings: float64[3600, 2], (cos, sin).
        step: the current step.
    """
    (ox, oy), (rows, columns), (left, bottom) = world.origin_m, near.shape, near.origin_m
    move(
        world.free, ox, oy, world.resolution_m,
        bodies.position, bodies.heading, bodies.alive, action,
        bodies.contact, bodies.contact_offset, bodies.touched,
        near.first, near.following, near.before, rows, columns, left, bottom, near.edge_m,
        radius_m, forward_m, turn_ticks, headings, step,
    )  # fmt: skip
