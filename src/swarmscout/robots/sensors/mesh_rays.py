"""Rays against the triangles of a cave's mesh, in 3D: exact sensing.

A robot stands on the ground, and its rays lie in the plane of the ground under it. A range is
measured along the horizontal, as by a robot that knows its tilt: where walls are upright, a scan
against the mesh equals one against the raster.

The rays of a robot lie in one plane, and a triangle that crosses this plane is a segment in it. So
the mesh is cut with the plane near the robot, and rays meet segments. There are many triangles and
rays are short: a grid of square buckets over the map lists the triangles that reach over each
bucket, and at which heights. Everything is computed in double precision and in one order, so bits
agree on every machine.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import NDArray

from swarmscout.core.errors import SensorError
from swarmscout.core.jit import inlined, kernel
from swarmscout.robots.bodies import TICKS, Bodies, heading_table
from swarmscout.worlds.ground_plane import stand
from swarmscout.worlds.meshes.mesh import Mesh
from swarmscout.worlds.world import World

__all__ = ["TriangleBuckets", "bucket_triangles", "cast_rays_at_mesh", "mesh_ranges"]

_HEADINGS = heading_table()
_FRAME = np.dtype(
    [("left_m", "f8"), ("bottom_m", "f8"), ("edge_m", "f8"), ("rows", "i8"), ("columns", "i8")]
)
_ENTRY = np.dtype([("triangle", "i4"), ("low_m", "f4"), ("high_m", "f4")])
_EDGE_M = 0.5
_MOST_BUCKETS = 4_000_000


@dataclass(frozen=True)
class TriangleBuckets:
    """The triangles of a mesh, by where they are on the map.

    Attributes:
        corners: float32[T, 9], x, y, z of each triangle's three corners, in metres; triangles that
            are near each other in the cave are near each other in memory.
        frame: one record: the lower left corner of the lower left bucket, the edge of a bucket, and
            numbers of rows and columns.
        first: int64[buckets + 1], where each bucket's triangles begin in `entries`.
        entries: records, bucket after bucket, from low to high: a row of `corners`, and that
            triangle's lowest and highest z in metres.
    """

    corners: NDArray[np.float32]
    frame: NDArray[Any]
    first: NDArray[np.int64]
    entries: NDArray[Any]


_sorted: WeakKeyDictionary[Mesh, TriangleBuckets] = WeakKeyDictionary()


def bucket_triangles(mesh: Mesh) -> TriangleBuckets:
    """Sort the triangles of a mesh into buckets: once, and kept as long as the mesh.

    Many missions of a study run in one world.
    """
    if mesh not in _sorted:
        _sorted[mesh] = _bucketed(mesh)
    return _sorted[mesh]


def _bucketed(mesh: Mesh) -> TriangleBuckets:
    (left, bottom, _), (right, top, _) = mesh.bounds_m.tolist()
    edge_m = max(_EDGE_M, math.sqrt((right - left) * (top - bottom) / _MOST_BUCKETS))
    rows, columns = int((top - bottom) / edge_m) + 1, int((right - left) / edge_m) + 1
    frame = np.array([(left, bottom, edge_m, rows, columns)], dtype=_FRAME)
    corners = mesh.vertices_m[mesh.triangles].reshape(-1, 9)
    _, inside = _put(corners, frame)
    # In the order of buckets, so that what is near in the cave is near in memory.
    named, place_of = np.unique(inside, return_index=True)
    corners = np.ascontiguousarray(corners[named[np.argsort(place_of)]])
    first, inside = _put(corners, frame)
    low_z, high_z = corners[:, 2::3].min(axis=1), corners[:, 2::3].max(axis=1)
    # Within a bucket from low to high: the search stops where the ceiling begins.
    bucket = np.repeat(np.arange(len(first) - 1), np.diff(first))
    inside = inside[np.lexsort((low_z[inside], bucket))]
    entries = np.empty(len(inside), dtype=_ENTRY)
    entries["triangle"], entries["low_m"], entries["high_m"] = inside, low_z[inside], high_z[inside]
    return TriangleBuckets(corners, frame, first, entries)


def _put(
    corners: NDArray[np.float32], frame: NDArray[Any]
) -> tuple[NDArray[np.int64], NDArray[np.int32]]:
    """Where each bucket's triangles begin, and the triangles, bucket after bucket."""
    first = np.zeros(int(frame["rows"][0] * frame["columns"][0]) + 1, dtype=np.int64)
    put_into_buckets(corners, frame, first, np.zeros(0, dtype=np.int32), False)
    np.cumsum(first, out=first)
    inside = np.zeros(int(first[-1]), dtype=np.int32)
    put_into_buckets(corners, frame, first, inside, True)
    return first, inside


def mesh_ranges(
    bodies: Bodies,
    world: World,
    directions: NDArray[np.int64],
    range_m: float,
    height_m: float,
) -> NDArray[np.float64]:
    """Cast rays from each robot's sensor against the triangles of a world's mesh.

    Args:
        bodies: where robots are.
        world: its ground carries the robots, and its mesh is what rays meet.
        directions: int64[rays], counter-clockwise from the heading, in ticks of 0.1°.
        range_m: longest range along the horizontal, in metres.
        height_m: height of the sensor above the ground, in metres.

    Returns:
        float64[N, rays], distances along the horizontal in metres; inf where a ray met nothing, and
        for robots that are not alive.

    Raises:
        SensorError: the world has no mesh.
    """
    if world.mesh is None:
        raise SensorError(f"world '{world.name}' has no mesh for rays to meet")
    buckets = bucket_triangles(world.mesh)
    sensor_plane = stand(world, bodies.position, bodies.radius_m)
    sensor_plane[:, 0] += height_m
    ways = _HEADINGS[(bodies.heading[:, None] + directions) % TICKS]
    ranges = np.empty((len(bodies.heading), len(directions)))
    cast_rays_at_mesh(
        buckets.corners, buckets.frame, buckets.first, buckets.entries,
        bodies.position, sensor_plane, bodies.alive, ways, range_m, ranges,
    )  # fmt: skip
    return ranges


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
def put_into_buckets(corners, frame, first, inside, fill):  # type: ignore[no-untyped-def]
    """Count the triangles of each bucket (into the place after it), or fill them in.

    Args:
        corners: float32[T, 9], the triangles.
        frame: of the buckets.
        first: int64[buckets + 1]; when filling, sums of the counts, the same again afterwards.
        inside: int32[entries], written when filling.
        fill: whether to fill.
    """
    left, bottom, edge = frame[0].left_m, frame[0].bottom_m, frame[0].edge_m
    rows, columns = frame[0].rows, frame[0].columns
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
    """Height of a triangle's corner above the rays' plane, in metres."""
    level = z + rise_x * (float(corners[t, k]) - x) + rise_y * (float(corners[t, k + 1]) - y)
    return float(corners[t, k + 2]) - level


@inlined
def _cut(corners, t, p, q, at_p, at_q, x, y, ends, end):  # type: ignore[no-untyped-def]
    """Where the edge between two corners crosses the rays' plane, seen from (x, y).

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
    """Shorten the rays that a triangle stops: where it cuts the rays' plane it is a segment."""
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
    corners, frame, first, entries, position, plane, alive, ways, range_m, ranges
):
    """Cast rays from each robot's sensor; see :func:`mesh_ranges`.

    Args:
        corners, frame, first, entries: of :class:`TriangleBuckets`.
        position: float64[N, 2] in metres; alive: bool[N].
        plane: float64[N, 3], the plane of the rays: z at the robot, and its rise along x and y.
        ways: float64[N, rays, 2], unit vectors along the rays.
        range_m: longest range, along the horizontal.
        ranges: float64[N, rays], written.
    """
    left, bottom, edge = frame[0].left_m, frame[0].bottom_m, frame[0].edge_m
    rows, columns = frame[0].rows, frame[0].columns
    ends = np.empty((2, 2))
    for i in range(position.shape[0]):
        ranges[i, :] = np.inf
        if not alive[i]:
            continue
        x, y = position[i, 0], position[i, 1]
        z, rise_x, rise_y = plane[i, 0], plane[i, 1], plane[i, 2]
        x0 = x1 = x
        y0 = y1 = y
        for r in range(ways.shape[1]):
            x0 = min(x0, x + range_m * ways[i, r, 0])
            x1 = max(x1, x + range_m * ways[i, r, 0])
            y0 = min(y0, y + range_m * ways[i, r, 1])
            y1 = max(y1, y + range_m * ways[i, r, 1])
        steep = 0.5 * edge * (abs(rise_x) + abs(rise_y)) + 1e-6
        for row in range(
            max(0, int(math.floor((y0 - bottom) / edge))),
            min(rows - 1, int(math.floor((y1 - bottom) / edge))) + 1,
        ):
            for col in range(
                max(0, int(math.floor((x0 - left) / edge))),
                min(columns - 1, int(math.floor((x1 - left) / edge))) + 1,
            ):
                # The rays' plane over this bucket; most triangles lie above it or below.
                level = z + rise_x * (left + (col + 0.5) * edge - x)
                level += rise_y * (bottom + (row + 0.5) * edge - y)
                bucket = row * columns + col
                for entry in range(first[bucket], first[bucket + 1]):
                    if entries[entry].low_m > level + steep:
                        break
                    if entries[entry].high_m >= level - steep:
                        _meet(
                            corners, entries[entry].triangle, x, y, z, rise_x, rise_y, ends,
                            ways[i], range_m, ranges, i,
                        )  # fmt: skip
