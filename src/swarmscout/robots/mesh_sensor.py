"""Exact sensing: the range sensor's rays against the triangles of a cave, in 3D.

A robot stands on the ground, and its fan of rays lies in the plane of the ground under it. A range
is measured along the horizontal, as a robot does that knows its tilt: so a scan against the mesh
and one against the raster say the same where walls are upright.

Rays are short and triangles many. A grid of square buckets over the map says which triangles reach
over each bucket; a ray asks the buckets that it crosses. Möller and Trumbore (1997), "Fast, minimum
storage ray–triangle intersection", in double precision and plain order, so that bits agree on every
machine.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from swarmscout.core.jit import inlined, kernel
from swarmscout.worlds.meshes.mesh import Mesh

__all__ = ["TriangleBuckets", "bucket_triangles", "cast_rays_at_mesh"]

_EDGE_M = 0.5
_MOST_BUCKETS = 4_000_000


@dataclass(frozen=True)
class TriangleBuckets:
    """The triangles of a mesh, by where they are on the map.

    Attributes:
        mesh: the triangles.
        origin_m: ``(x, y)`` of the lower left bucket's lower left corner.
        edge_m: edge of a bucket.
        shape: ``(rows, columns)`` of buckets.
        first: int64[buckets + 1], where each bucket's triangles begin in ``inside``.
        inside: int32[entries], triangles, bucket after bucket.
    """

    mesh: Mesh
    origin_m: tuple[float, float]
    edge_m: float
    shape: tuple[int, int]
    first: NDArray[np.int64]
    inside: NDArray[np.int32]


def bucket_triangles(mesh: Mesh) -> TriangleBuckets:
    """Sort the triangles of a mesh into buckets."""
    (left, bottom, _), (right, top, _) = mesh.bounds_m.tolist()
    edge_m = max(_EDGE_M, math.sqrt((right - left) * (top - bottom) / _MOST_BUCKETS))
    shape = (int((top - bottom) / edge_m) + 1, int((right - left) / edge_m) + 1)
    first = np.zeros(shape[0] * shape[1] + 1, dtype=np.int64)
    place = (left, bottom, edge_m, *shape)
    inside = np.zeros(0, dtype=np.int32)
    put_into_buckets(mesh.vertices_m, mesh.triangles, *place, first, inside, False)
    np.cumsum(first, out=first)
    inside = np.zeros(int(first[-1]), dtype=np.int32)
    put_into_buckets(mesh.vertices_m, mesh.triangles, *place, first, inside, True)
    return TriangleBuckets(mesh, (left, bottom), edge_m, shape, first, inside)


@inlined
def _span_in_band(vertices, a, b, c, low, high):  # type: ignore[no-untyped-def]
    """Least and greatest x of a triangle between two values of y; an empty span if it has none."""
    left = np.inf
    right = -np.inf
    for k in range(3):
        p = a if k == 0 else (b if k == 1 else c)
        q = b if k == 0 else (c if k == 1 else a)
        px, py = float(vertices[p, 0]), float(vertices[p, 1])
        qx, qy = float(vertices[q, 0]), float(vertices[q, 1])
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
def put_into_buckets(vertices, triangles, left, bottom, edge, rows, columns, first, inside, fill):  # type: ignore[no-untyped-def]
    """Count the triangles of each bucket (into the place after it), or fill them in.

    Args:
        vertices: float32[V, 3]; triangles: int32[T, 3].
        left, bottom, edge, rows, columns: the buckets.
        first: int64[buckets + 1]; when filling, sums of the counts, the same again afterwards.
        inside: int32[entries], written when filling.
        fill: whether to fill.
    """
    slack = 1e-6 * edge  # A triangle that touches a border belongs to both sides.
    for t in range(triangles.shape[0]):
        a, b, c = triangles[t, 0], triangles[t, 1], triangles[t, 2]
        low_y = min(vertices[a, 1], vertices[b, 1], vertices[c, 1])
        high_y = max(vertices[a, 1], vertices[b, 1], vertices[c, 1])
        low_row = max(0, int(math.floor((low_y - bottom - slack) / edge)))
        high_row = min(rows - 1, int(math.floor((high_y - bottom + slack) / edge)))
        for row in range(low_row, high_row + 1):
            band = bottom + row * edge
            x0, x1 = _span_in_band(vertices, a, b, c, band - slack, band + edge + slack)
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
def _hit(vertices, a, b, c, x, y, z, dx, dy, dz):  # type: ignore[no-untyped-def]
    """How far along a ray a triangle is met, in lengths of (dx, dy, dz); inf if it is not."""
    e1x = float(vertices[b, 0]) - float(vertices[a, 0])
    e1y = float(vertices[b, 1]) - float(vertices[a, 1])
    e1z = float(vertices[b, 2]) - float(vertices[a, 2])
    e2x = float(vertices[c, 0]) - float(vertices[a, 0])
    e2y = float(vertices[c, 1]) - float(vertices[a, 1])
    e2z = float(vertices[c, 2]) - float(vertices[a, 2])
    px = dy * e2z - dz * e2y
    py = dz * e2x - dx * e2z
    pz = dx * e2y - dy * e2x
    determinant = e1x * px + e1y * py + e1z * pz
    if determinant == 0.0:
        return np.inf
    sx = x - float(vertices[a, 0])
    sy = y - float(vertices[a, 1])
    sz = z - float(vertices[a, 2])
    u = (sx * px + sy * py + sz * pz) / determinant
    # Neighbours share an edge: with a little slack no ray slips through between them.
    if u < -1e-9 or u > 1.0 + 1e-9:
        return np.inf
    qx = sy * e1z - sz * e1y
    qy = sz * e1x - sx * e1z
    qz = sx * e1y - sy * e1x
    v = (dx * qx + dy * qy + dz * qz) / determinant
    if v < -1e-9 or u + v > 1.0 + 1e-9:
        return np.inf
    t = (e2x * qx + e2y * qy + e2z * qz) / determinant
    return t if t >= 0.0 else np.inf


@inlined
def _first_triangle(  # type: ignore[no-untyped-def]
    vertices, triangles, left, bottom, edge, rows, columns, first, inside,
    x, y, z, dx, dy, dz, longest,
):  # fmt: skip
    """Distance along a ray's horizontal to the first triangle; inf if beyond `longest`."""
    nearest = np.inf
    end_y = y + longest * dy
    low_row = max(0, int(math.floor((min(y, end_y) - bottom) / edge)))
    high_row = min(rows - 1, int(math.floor((max(y, end_y) - bottom) / edge)))
    for row in range(low_row, high_row + 1):
        # The part of the ray in this row of buckets.
        enter, leave = 0.0, longest
        if dy != 0.0:
            one = (bottom + row * edge - y) / dy
            two = (bottom + (row + 1) * edge - y) / dy
            enter = max(enter, min(one, two))
            leave = min(leave, max(one, two))
        x0, x1 = x + enter * dx, x + leave * dx
        low_col = max(0, int(math.floor((min(x0, x1) - left) / edge - 1e-9)))
        high_col = min(columns - 1, int(math.floor((max(x0, x1) - left) / edge + 1e-9)))
        for col in range(low_col, high_col + 1):
            bucket = row * columns + col
            for entry in range(first[bucket], first[bucket + 1]):
                t = inside[entry]
                a, b, c = triangles[t, 0], triangles[t, 1], triangles[t, 2]
                distance = _hit(vertices, a, b, c, x, y, z, dx, dy, dz)
                nearest = min(nearest, distance)
    return nearest if nearest <= longest else np.inf


@kernel
def cast_rays_at_mesh(  # type: ignore[no-untyped-def]
    vertices, triangles, left, bottom, edge, rows, columns, first, inside,
    position, footing, height, heading, alive, offsets, table, range_m, noise, ranges,
):  # fmt: skip
    """Sense once with all robots; the first nine arguments are :class:`TriangleBuckets`.

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
    for i in range(position.shape[0]):
        for r in range(offsets.shape[0]):
            ranges[i, r] = np.inf
            if not alive[i]:
                continue
            tick = (heading[i] + offsets[r]) % ticks
            dx, dy = table[tick, 0], table[tick, 1]
            dz = footing[i, 1] * dx + footing[i, 2] * dy
            distance = _first_triangle(
                vertices, triangles, left, bottom, edge, rows, columns, first, inside,
                position[i, 0], position[i, 1], footing[i, 0] + height, dx, dy, dz, range_m,
            )  # fmt: skip
            if distance < np.inf:
                ranges[i, r] = max(0.0, distance + noise[i, r])
