"""From a field in space to triangles: marching cubes in tiles, joined without seams.

Source: W. E. Lorensen and H. E. Cline, "Marching cubes", 1987, in the topologically sound form of
T. Lewiner et al., 2003, as scikit-image has it.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from swarmscout.core.errors import WorldError

__all__ = ["Field", "Triangles", "largest_part", "surface_of"]

_TILE = 64
"""Points across a tile: a few megabytes of memory for any size of cave."""
_TOLERANCE = 1e-4
_MOST_VERTICES = 2_500_000
"""More would take gigabytes, and no viewer shows it."""

Triangles = tuple[NDArray[np.float64], NDArray[np.int64]]
"""Vertices float64[V, 3] and triangles int64[T, 3]."""


class Field(Protocol):
    """What is positive in the open and negative in rock, on a grid of points."""

    shape: tuple[int, int]
    levels_m: NDArray[np.float64]

    def is_solid(self, rows: slice, columns: slice) -> bool:
        """Whether there is nothing but rock."""

    def values(self, rows: slice, columns: slice) -> NDArray[np.float32]:
        """float32[rows, cols, levels], never 0."""

    def vertices_m(self, at: NDArray[np.float64]) -> NDArray[np.float64]:
        """Places [n, 3] of points at (row, column, level) [n, 3]."""


def surface_of(field: Field, on_progress: Callable[[int, int], None] | None = None) -> Triangles:
    """The surface between the open and the rock; triangles face the open.

    Args:
        field: the field; rock at its border closes the surface, the open leaves it open there.
        on_progress: called with the number of tiles that are done, and of all.

    Returns:
        Vertices in metres, none of them twice, and triangles.

    Raises:
        WorldError: there would be more triangles than anybody can use.
    """
    from skimage.measure import marching_cubes

    rows, columns = field.shape
    tiles = [
        (slice(row, min(row + _TILE + 1, rows)), slice(col, min(col + _TILE + 1, columns)))
        for row in range(0, rows - 1, _TILE)
        for col in range(0, columns - 1, _TILE)
    ]
    places, faces, count = [np.empty((0, 3))], [np.empty((0, 3), dtype=np.int64)], 0
    for number, tile in enumerate(tiles):
        if on_progress is not None:
            on_progress(number, len(tiles))
        if field.is_solid(*tile):
            continue
        values = field.values(*tile)
        if values.max() < 0.0 or values.min() > 0.0:
            continue
        vertices, triangles, _, _ = marching_cubes(
            values, 0.0, gradient_direction="ascent", allow_degenerate=True
        )
        places.append(vertices + np.array([tile[0].start, tile[1].start, 0], dtype=np.float64))
        faces.append(triangles.astype(np.int64) + count)
        count += len(vertices)
        if count > _MOST_VERTICES:
            raise WorldError(
                f"the mesh would have more than {_MOST_VERTICES:,} vertices: take a larger "
                "resolution for it, or a smaller tube"
            )
    at, triangles = _joined(np.concatenate(places), np.concatenate(faces), field)
    return field.vertices_m(at), triangles


def largest_part(surface: Triangles) -> Triangles:
    """The largest connected part: closed bubbles in the rock are left out."""
    from scipy import sparse  # It takes a while to load.

    vertices, triangles = surface
    if not len(triangles):
        return surface
    ends = np.concatenate((triangles[:, :2], triangles[:, 1:]))
    size = len(vertices)
    graph = sparse.coo_matrix((np.ones(len(ends), dtype=np.int8), ends.T), shape=(size, size))
    _, labels = sparse.csgraph.connected_components(graph, directed=False)
    sizes = np.bincount(labels[triangles[:, 0]])
    kept = labels == int(np.argmax(sizes))
    renumbered = np.cumsum(kept) - 1
    return vertices[kept], renumbered[triangles[kept[triangles[:, 0]]]]


def _joined(
    at: NDArray[np.float64], triangles: NDArray[np.int64], field: Field
) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """Make one of vertices that two tiles have made of the same edge of the grid.

    A vertex lies on an edge between two points, which its whole and its broken numbers name, or,
    in rare cubes, in the middle of a cube.
    """
    whole = np.abs(at - np.rint(at)) < _TOLERANCE
    twice = np.where(whole, 2 * np.rint(at), 2 * np.floor(at) + 1).astype(np.int64)
    wide, high = 2 * field.shape[1] + 1, 2 * len(field.levels_m) + 1
    names = (twice[:, 0] * wide + twice[:, 1]) * high + twice[:, 2]
    _, first, number = np.unique(names, return_index=True, return_inverse=True)
    return at[first], number[triangles]
