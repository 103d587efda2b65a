"""Exact sensing: the range sensor's rays against the triangles of a cave, in 3D.

A robot stands on the ground, and its fan of rays lies in the plane of the ground under it. A range
is measured along the horizontal, as a robot does that knows its tilt: so a scan against the mesh
and one against the raster say the same where walls are upright.

The rays of a fan lie in one plane, and a triangle that crosses this plane is a segment in it. So
the mesh is cut with the plane near the robot, and rays meet segments. Triangles are many and rays
short: a grid of square buckets over the map says which triangles reach over each bucket, and at
which heights. All is computed in double precision and in one order: bits agree on every machine.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import NDArray

from swarmscout.core.jit import inlined, kernel
from swarmscout.robots.range_sensor import RangeSensor
from swarmscout.worlds.meshes.mesh import Mesh

__all__ = ["TriangleBuckets", "bucket_triangles", "cast_rays_at_mesh", "scan_mesh"]

_EDGE_M = 0.5
_MOST_BUCKETS = 4_000_000


@dataclass(frozen=True)
class TriangleBuckets:
    """The triangles of a mesh, by where they are on the map.

    Attributes:
        corners: float32[T, 9], x, y, z of each triangle's three corners, in metres; neighbours lie
            near each other in memory.
        origin_m: ``(x, y)`` of the lower left bucket's lower left corner.
        edge_m: edge of a bucket.
        shape: ``(rows, columns)`` of buckets.
        first: int64[buckets + 1], where each bucket's triangles begin in ``inside``.
        inside: int32[entries], rows of ``corners``, bucket after bucket, from low to high.
        low_z, high_z: float32[entries], each triangle's least and greatest height, in metres.
    """

    corners: NDArray[np.float32]
    origin_m: tuple[float, float]
    edge_m: float
    shape: tuple[int, int]
    first: NDArray[np.int64]
    inside: NDArray[np.int32]
    low_z: NDArray[np.float32]
    high_z: NDArray[np.float32]


_sorted: WeakKeyDictionary[Mesh, TriangleBuckets] = WeakKeyDictionary()


def bucket_triangles(mesh: Mesh) -> TriangleBuckets:
    """Sort the triangles of a mesh into buckets: once, and kept for as long as the mesh is.

    Many missions of a study fly in one world.
    """
    if mesh not in _sorted:
        _sorted[mesh] = _bucketed(mesh)
    return _sorted[mesh]


def _bucketed(mesh: Mesh) -> TriangleBuckets:
    (left, bottom, _), (right, top, _) = mesh.bounds_m.tolist()
    edge_m = max(_EDGE_M, math.sqrt((right - left) * (top - bottom) / _MOST_BUCKETS))
    shape = (int((top - bottom) / edge_m) + 1, int((right - left) / edge_m) + 1)
    place = (left, bottom, edge_m, *shape)
    corners = mesh.vertices_m[mesh.triangles].reshape(-1, 9)
    first, inside = _put(corners, place)
    # In the order of buckets, so that what is near in the cave is near in memory.
    named, place_of = np.unique(inside, return_index=True)
    corners = np.ascontiguousarray(corners[named[np.argsort(place_of)]])
    first, inside = _put(corners, place)
    low_z, high_z = corners[:, 2::3].min(axis=1), corners[:, 2::3].max(axis=1)
    # Within a bucket from low to high: a robot stops asking where the ceiling begins.
    bucket = np.repeat(np.arange(len(first) - 1), np.diff(first))
    inside = inside[np.lexsort((low_z[inside], bucket))]
    return TriangleBuckets(
        corners, (left, bottom), edge_m, shape, first, inside, low_z[inside], high_z[inside]
    )


def _put(
    corners: NDArray[np.float32], place: tuple[float, float, float, int, int]
) -> tuple[NDArray[np.int64], NDArray[np.int32]]:
    """``first`` and ``inside`` of :class:`TriangleBuckets`."""
    first = np.zeros(place[3] * place[4] + 1, dtype=np.int64)
    put_into_buckets(corners, *place, first, np.zeros(0, dtype=np.int32), False)
    np.cumsum(first, out=first)
    inside = np.zeros(int(first[-1]), dtype=np.int32)
    put_into_buckets(corners, *place, first, inside, True)
    return first, inside


def scan_mesh(
    triangles: TriangleBuckets,
    position: NDArray[np.float64],
    footing: NDArray[np.float64],
    height_m: float,
    heading: NDArray[np.int64],
    alive: NDArray[np.bool_],
    sensor: RangeSensor,
    table: NDArray[np.float64],
    noise: NDArray[np.float64],
    ranges: NDArray[np.float64],
) -> None:
    """Sense once with all robots; see :func:`cast_rays_at_mesh`."""
    t = triangles
    cast_rays_at_mesh(
        t.corners, *t.origin_m, t.edge_m, *t.shape, t.first, t.inside, t.low_z, t.high_z,
        position, footing, height_m, heading, alive,
        sensor.offsets, table, sensor.range_m, noise, ranges,
    )  # fmt: skip


@inlined
def _span_in_band(corners, t, low, high):  # type: ignore[no-untyped-def]
    """Least and greatest x of a triangle between two values of y; an empty span if it has none."""
    left = np.inf
    right = -np.inf
    for k in range(3):
        p, q = 3 * k, 3 * ((k + 1) % 3)
        px, py = float(corners[t, p]), float(corners[t, p + 1])
        qx, qy = float(corners[t, q]), float(corners[t, q + 1])
        if low <= py <= high:
            left = min(left, px)
            right = max(right, px)
        for border in (low, high):
            if (py - border) * (qy - border) < 0.0:
                x = px + (border - py) / (qy - py) * (qx - px)
                left = min(left, x)
                right = max(right, x)
    return left, right


@kernel
def put_into_buckets(corners, left, bottom, edge, rows, columns, first, inside, fill):  # type: ignore[no-untyped-def]
    """Count the triangles of each bucket (into the place after it), or fill them in.

    Args:
        corners: float32[T, 9], the triangles.
        left, bottom, edge, rows, columns: the buckets.
        first: int64[buckets + 1]; when filling, sums of the counts, the same again afterwards.
        inside: int32[entries], written when filling.
        fill: whether to fill.
    """
    slack = 1e-6 * edge  # A triangle that touches a border belongs to both sides.
    for t in range(corners.shape[0]):
        low_y = float(min(corners[t, 1], corners[t, 4], corners[t, 7]))
        high_y = float(max(corners[t, 1], corners[t, 4], corners[t, 7]))
        low_row = max(0, int(math.floor((low_y - bottom - slack) / edge)))
        high_row = min(rows - 1, int(math.floor((high_y - bottom + slack) / edge)))
        for row in range(low_row, high_row + 1):
            band = bottom + row * edge
            x0, x1 = _span_in_band(corners, t, band - slack, band + edge + slack)
            low_col = max(0, int(math.floor((x0 - left - slack) / edge)))
            high_col = min(columns - 1, int(math.floor((x1 - left + slack) / edge)))
            for col in range(low_col, high_col + 1):
                bucket = row * columns + col
                if fill:
                    inside[first[bucket]] = t
                    first[bucket] += 1
                else:
                    first[bucket + 1] += 1
    if fill:
        for bucket in range(rows * columns, 0, -1):
            first[bucket] = first[bucket - 1]
        first[0] = 0


@inlined
def _above(corners, t, k, x, y, z, rise_x, rise_y):  # type: ignore[no-untyped-def]
    """Height of a triangle's corner above the fan's plane, in metres."""
    level = z + rise_x * (float(corners[t, k]) - x) + rise_y * (float(corners[t, k + 1]) - y)
    return float(corners[t, k + 2]) - level


@inlined
def _cut(corners, t, p, q, at_p, at_q, x, y, ends, end):  # type: ignore[no-untyped-def]
    """Where the edge between two corners crosses the fan's plane, seen from (x, y).

    Triangles that share the edge get the same bits, whichever way round they name it: no ray slips
    through between them.
    """
    px, py = float(corners[t, p]), float(corners[t, p + 1])
    qx, qy = float(corners[t, q]), float(corners[t, q + 1])
    if at_p > at_q:
        px, py, at_p, qx, qy, at_q = qx, qy, at_q, px, py, at_p
    share = at_p / (at_p - at_q)
    ends[end, 0] = px - x + share * (qx - px)
    ends[end, 1] = py - y + share * (qy - py)


@inlined
def _meet(  # type: ignore[no-untyped-def]
    corners, t, x, y, z, rise_x, rise_y, ends, directions, range_m, ranges, i
):
    """Shorten the rays that a triangle stops: where it cuts the fan's plane it is a segment."""
    at_a = _above(corners, t, 0, x, y, z, rise_x, rise_y)
    at_b = _above(corners, t, 3, x, y, z, rise_x, rise_y)
    at_c = _above(corners, t, 6, x, y, z, rise_x, rise_y)
    found = 0
    if (at_a >= 0.0) != (at_b >= 0.0):
        _cut(corners, t, 0, 3, at_a, at_b, x, y, ends, found)
        found += 1
    if (at_b >= 0.0) != (at_c >= 0.0):
        _cut(corners, t, 3, 6, at_b, at_c, x, y, ends, found)
        found += 1
    if (at_c >= 0.0) != (at_a >= 0.0):
        _cut(corners, t, 6, 0, at_c, at_a, x, y, ends, found)
        found += 1
    if found < 2:
        return
    for r in range(directions.shape[0]):
        dx, dy = directions[r, 0], directions[r, 1]
        left_0 = dx * ends[0, 1] - dy * ends[0, 0]
        left_1 = dx * ends[1, 1] - dy * ends[1, 0]
        if (left_0 >= 0.0) == (left_1 >= 0.0):
            continue
        ahead_0 = dx * ends[0, 0] + dy * ends[0, 1]
        ahead_1 = dx * ends[1, 0] + dy * ends[1, 1]
        distance = ahead_0 + left_0 / (left_0 - left_1) * (ahead_1 - ahead_0)
        if 0.0 <= distance <= range_m and distance < ranges[i, r]:
            ranges[i, r] = distance


@kernel
def cast_rays_at_mesh(  # type: ignore[no-untyped-def]
    corners, left, bottom, edge, rows, columns, first, inside, low_z, high_z,
    position, footing, height, heading, alive, offsets, table, range_m, noise, ranges,
):  # fmt: skip
    """Sense once with all robots; the first ten arguments are :class:`TriangleBuckets`.

    Args:
        position: float64[N, 2]; heading: int64[N] in ticks; alive: bool[N].
        footing: float64[N, 3], height of the ground and its rise along x and y, per metre.
        height: of the sensor above the ground, in metres.
        offsets: int64[rays] in ticks; table: float64[3600, 2] of (cos, sin).
        range_m: longest range, along the horizontal.
        noise: float64[N, rays], added to what is measured, in metres.
        ranges: float64[N, rays], written: the measured range ≥ 0, or inf if nothing was met.
    """
    ticks = table.shape[0]
    directions = np.empty((offsets.shape[0], 2))
    ends = np.empty((2, 2))
    for i in range(position.shape[0]):
        ranges[i, :] = np.inf
        if not alive[i]:
            continue
        x, y = position[i, 0], position[i, 1]
        z, rise_x, rise_y = footing[i, 0] + height, footing[i, 1], footing[i, 2]
        x0 = x1 = x
        y0 = y1 = y
        for r in range(offsets.shape[0]):
            tick = (heading[i] + offsets[r]) % ticks
            directions[r, 0], directions[r, 1] = table[tick, 0], table[tick, 1]
            x0, x1 = min(x0, x + range_m * table[tick, 0]), max(x1, x + range_m * table[tick, 0])
            y0, y1 = min(y0, y + range_m * table[tick, 1]), max(y1, y + range_m * table[tick, 1])
        steep = 0.5 * edge * (abs(rise_x) + abs(rise_y)) + 1e-6
        for row in range(
            max(0, int(math.floor((y0 - bottom) / edge))),
            min(rows - 1, int(math.floor((y1 - bottom) / edge))) + 1,
        ):
            for col in range(
                max(0, int(math.floor((x0 - left) / edge))),
                min(columns - 1, int(math.floor((x1 - left) / edge))) + 1,
            ):
                # The fan's plane over this bucket; most triangles lie above it or below.
                level = z + rise_x * (left + (col + 0.5) * edge - x)
                level += rise_y * (bottom + (row + 0.5) * edge - y)
                bucket = row * columns + col
                for entry in range(first[bucket], first[bucket + 1]):
                    if low_z[entry] > level + steep:
                        break
                    if high_z[entry] >= level - steep:
                        _meet(
                            corners, inside[entry], x, y, z, rise_x, rise_y, ends,
                            directions, range_m, ranges, i,
                        )  # fmt: skip
        for r in range(offsets.shape[0]):
            ranges[i, r] = max(0.0, ranges[i, r] + noise[i, r])
