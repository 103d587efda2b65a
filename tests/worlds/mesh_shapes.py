"""Meshes out of plain shapes: float64[V, 3] vertices and int64[T, 3] triangles, in metres."""

from __future__ import annotations

from pathlib import Path

import numpy as np

Shape = tuple[np.ndarray, np.ndarray]


def joined(*shapes: Shape) -> Shape:
    """Several shapes as one."""
    firsts = np.cumsum([0, *(len(vertices) for vertices, _ in shapes)])
    triangles = [t + first for (_, t), first in zip(shapes, firsts, strict=False)]
    return np.concatenate([v for v, _ in shapes]), np.concatenate(triangles)


def sheet(left: float, right: float, bottom: float, top: float, height=0.0, pieces=8) -> Shape:
    """A rectangle seen from above, wound upward; height is a number or a function of x, y."""
    x, y = np.meshgrid(np.linspace(left, right, pieces + 1), np.linspace(bottom, top, pieces + 1))
    x, y = x.ravel(), y.ravel()
    z = height(x, y) if callable(height) else np.full(len(x), float(height))
    row, col = np.divmod(np.arange(pieces * pieces), pieces)
    first = row * (pieces + 1) + col
    a = np.stack((first, first + 1, first + pieces + 2), axis=1)
    b = np.stack((first, first + pieces + 2, first + pieces + 1), axis=1)
    return np.stack((x, y, z), axis=1), np.concatenate((a, b))


def box(left: float, right: float, bottom: float, top: float, low: float, high: float) -> Shape:
    """A closed box, wound outward."""
    corners = [(x, y, z) for z in (low, high) for y in (bottom, top) for x in (left, right)]
    sides = [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (1, 3, 7, 5), (3, 2, 6, 7), (2, 0, 4, 6)]
    triangles = [t for a, b, c, d in sides for t in ((a, b, c), (a, c, d))]
    return np.array(corners, dtype=np.float64), np.array(triangles)


def walls(points, low: float, high: float) -> Shape:
    """Upright sheets along a line of points."""
    points = np.asarray(points, dtype=np.float64)
    n = len(points)
    vertices = np.concatenate([np.column_stack((points, np.full(n, z))) for z in (low, high)])
    a = np.arange(n - 1)
    return vertices, np.concatenate(
        (np.stack((a, a + 1, a + n + 1), axis=1), np.stack((a, a + n + 1, a + n), axis=1))
    )


def flipped(shape: Shape) -> Shape:
    return shape[0], shape[1][:, ::-1]


def room(width=12.0, depth=8.0, height=3.0) -> Shape:
    """A closed cave, wound like a room in rock."""
    return flipped(box(0.0, width, 0.0, depth, 0.0, height))


def pillar_hall() -> Shape:
    """16 m × 16 m under a roof; on its floor stand four bodies of 1 m × 1 m, the pillars."""
    pillars = [box(x, x + 1.0, y, y + 1.0, 0.0, 3.0) for x in (4.0, 11.0) for y in (4.0, 11.0)]
    return joined(room(16.0, 16.0), *pillars)


def two_levels() -> Shape:
    """A square spiral without a roof: from a floor up four ramps to another floor 4 m above it.

    Ramps are 3 m wide and run round the lower floor, which is under the upper one.
    """
    lower = sheet(0.0, 16.0, 0.0, 16.0, 0.0)
    ramps = [
        sheet(16.0, 19.0, 0.0, 13.0, lambda x, y: y / 13.0),
        sheet(16.0, 19.0, 13.0, 16.0, 1.0, 2),
        sheet(16.0, 19.0, 16.0, 19.0, 1.0, 2),
        sheet(3.0, 16.0, 16.0, 19.0, lambda x, y: 1.0 + 2.0 * (16.0 - x) / 13.0),
        sheet(0.0, 3.0, 16.0, 19.0, 3.0, 2),
    ]
    upper = sheet(0.0, 10.0, 4.0, 16.0, 3.0)
    return joined(lower, *ramps, upper)


def save(shape: Shape, path: Path) -> Path:
    """Write a shape into a file of the kind that its suffix says."""
    import trimesh

    trimesh.Trimesh(*shape, process=False).export(path)
    return path
