"""Polygons of any number of corners, and their division into triangles."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from swarmscout.core.errors import WorldError

__all__ = ["Polygons", "from_strip", "joined", "placed", "triangulated"]

_MOST_CORNERS = 200_000_000
_CROSSING = 1e-3
"""Relative excess of area from which a divided polygon is known to cross itself."""


@dataclass(frozen=True, eq=False)
class Polygons:
    """Polygons in 3D.

    Attributes:
        vertices: float64[V, 3], in the unit and axes of the file.
        corners: int64[C], rows of ``vertices``, polygon after polygon.
        counts: int64[P], the number of corners of each polygon; they sum to C.
    """

    vertices: NDArray[np.float64]
    corners: NDArray[np.int64]
    counts: NDArray[np.int64]

    @classmethod
    def of_triangles(cls, vertices: NDArray[np.float64], triangles: NDArray[np.int64]) -> Polygons:
        """Polygons that are all triangles: float64[V, 3] and int64[T, 3]."""
        return cls(vertices, triangles.ravel(), np.full(len(triangles), 3, dtype=np.int64))

    def check(self) -> Polygons:
        """These polygons, after a check of their indices.

        Raises:
            WorldError: a polygon has fewer than three corners or names a missing vertex.
        """
        few = np.flatnonzero(self.counts < 3)
        if len(few):
            raise WorldError(
                f"face {few[0]:,} has {self.counts[few[0]]} corners, expected 3 or more"
            )
        outside = (self.corners < 0) | (self.corners >= len(self.vertices))
        if outside.any():
            corner = int(np.argmax(outside))
            face = int(np.searchsorted(np.cumsum(self.counts), corner, side="right"))
            raise WorldError(
                f"face {face:,} names vertex {self.corners[corner]:,}, which is missing: there are "
                f"{len(self.vertices):,} vertices, counted from 0"
            )
        return self


def from_strip(strip: NDArray[np.int64]) -> NDArray[np.int64]:
    """int64[n - 2, 3], the triangles of a strip of n vertices, all wound alike."""
    triangles = np.stack((strip[:-2], strip[1:-1], strip[2:]), axis=1)
    triangles[1::2] = triangles[1::2, [1, 0, 2]]
    return triangles


def placed(parts: Sequence[tuple[Polygons, NDArray[np.float64]]]) -> Polygons:
    """Parts of a scene, each moved by a matrix.

    Args:
        parts: polygons, and float64[4, 4], which maps their coordinates to those of the scene.

    Raises:
        WorldError: all instances together would fill the memory.
    """
    corners = sum(len(part.corners) + len(part.vertices) for part, _ in parts)
    if corners > _MOST_CORNERS:
        raise WorldError(f"its {len(parts):,} parts have {corners:,} corners together: too many")
    moved = []
    for part, matrix in parts:
        at = part.vertices
        if not np.array_equal(matrix, np.eye(4)):
            with np.errstate(invalid="ignore", over="ignore"):
                at = at @ matrix[:3, :3].T + matrix[:3, 3]
        moved.append(Polygons(at, part.corners, part.counts))
    return joined(moved)


def joined(parts: Sequence[Polygons]) -> Polygons:
    """The polygons of several parts."""
    if not parts:
        return Polygons.of_triangles(np.empty((0, 3)), np.empty((0, 3), dtype=np.int64))
    firsts = np.cumsum([0, *(len(part.vertices) for part in parts[:-1])])
    corners = [part.corners + first for part, first in zip(parts, firsts, strict=True)]
    return Polygons(
        np.concatenate([part.vertices for part in parts]),
        np.concatenate(corners),
        np.concatenate([part.counts for part in parts]),
    )


def triangulated(polygons: Polygons) -> tuple[NDArray[np.int64], int]:
    """Divide polygons into triangles, concave ones by ear clipping.

    Args:
        polygons: checked polygons.

    Returns:
        int64[T, 3] triangles, wound as their polygons, in the order of the polygons; and the number
        of polygons that cross themselves, whose surface is ambiguous.
    """
    corners, counts = polygons.corners, polygons.counts
    first = np.cumsum(counts) - counts
    places: list[NDArray[np.int64]] = []
    triangles: list[NDArray[np.int64]] = []
    crossing = 0
    for count in np.unique(counts).tolist():
        of = np.flatnonzero(counts == count)
        rows = corners[first[of, None] + np.arange(count)]
        fans = np.stack(
            (np.broadcast_to(rows[:, :1], (len(of), count - 2)), rows[:, 1:-1], rows[:, 2:]), axis=2
        )
        if count > 3:
            for bad in np.flatnonzero(_is_folded(polygons.vertices, rows, fans)).tolist():
                fans[bad], crosses = _clipped(polygons.vertices, rows[bad], fans[bad])
                crossing += crosses
        places.append(np.repeat(of, count - 2))
        triangles.append(fans.reshape(-1, 3))
    if not places:
        return np.empty((0, 3), dtype=np.int64), 0
    order = np.argsort(np.concatenate(places), kind="stable")
    return np.concatenate(triangles)[order], crossing


def _is_folded(
    vertices: NDArray[np.float64], rows: NDArray[np.int64], fans: NDArray[np.int64]
) -> NDArray[np.bool_]:
    """bool[n], polygons whose fan from the first corner has a triangle that faces backward."""
    with np.errstate(invalid="ignore", over="ignore"):
        a, b, c = (vertices[fans[:, :, corner]] for corner in range(3))
        across = np.cross(b - a, c - a)
        normal = across.sum(axis=1, keepdims=True)
        along = (across * normal).sum(axis=2)
        folded: NDArray[np.bool_] = (along < -1e-9 * (normal * normal).sum(axis=2)).any(axis=1)
        area = np.linalg.norm(across, axis=2).sum(axis=1)
        # A polygon without a net area, as a bow tie, has no normal to compare with.
        folded |= np.linalg.norm(normal[:, 0], axis=1) < 1e-9 * area
    return folded & np.isfinite(vertices[rows]).all(axis=(1, 2))


def _clipped(
    vertices: NDArray[np.float64], row: NDArray[np.int64], fan: NDArray[np.int64]
) -> tuple[NDArray[np.int64], bool]:
    """A polygon divided by ear clipping in its own plane, and whether it crosses itself.

    What cannot be divided so keeps its fan.
    """
    import mapbox_earcut

    points = vertices[row] - vertices[row[0]]
    normal = np.cross(points[1:-1], points[2:]).sum(axis=0)
    size = float(np.linalg.norm(normal))
    if size <= 1e-12 * float(np.abs(points).max()) ** 2:
        return fan, True
    axis = int(np.argmax(np.abs(normal)))
    # Seen along the axis that the polygon faces most; a swap of the other two turns it round.
    u, v = (
        ((axis + 1) % 3, (axis + 2) % 3) if normal[axis] > 0 else ((axis + 2) % 3, (axis + 1) % 3)
    )
    flat = np.ascontiguousarray(points[:, [u, v]])
    ears = mapbox_earcut.triangulate_float64(flat, np.array([len(row)], dtype=np.uint32))
    ears = ears.reshape(-1, 3).astype(np.int64)
    b, c = flat[ears[:, 1]] - flat[ears[:, 0]], flat[ears[:, 2]] - flat[ears[:, 0]]
    signed = b[:, 0] * c[:, 1] - b[:, 1] * c[:, 0]
    net = float(np.abs(normal[axis]))
    crosses = abs(float(np.abs(signed).sum()) - net) > _CROSSING * net
    # Ears come wound one way, whichever way the polygon is.
    ears[signed < 0] = ears[signed < 0][:, ::-1]
    kept = row[ears]
    if len(kept) == len(fan):
        return kept, crosses
    # Corners on a straight edge or doubled ones may be left out: fill up with empty triangles.
    padding = np.broadcast_to(row[:1], (len(fan) - len(kept), 3)) if len(kept) < len(fan) else None
    return (fan, True) if padding is None else (np.concatenate((kept, padding)), crosses)
