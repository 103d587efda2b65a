"""Triangles sorted into square tiles of the raster: one tile is worked on at a time."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from swarmscout.core.grid import GridFrame
from swarmscout.core.jit import kernel

__all__ = ["TILE", "in_tiles"]

TILE = 256
"""Cells along a tile's edge."""


def in_tiles(
    corners: NDArray[np.float64], triangles: NDArray[np.int32], frame: GridFrame
) -> Iterator[tuple[float, int, int, NDArray[np.int32]]]:
    """Tiles that triangles may touch, seen from above.

    Args:
        corners: float64[V, 3], vertices: column and row in cells, and height.
        triangles: int32[T, 3].
        frame: the raster; the whole mesh is inside.

    Yields:
        The share of triangles that is done, the tile's first row and column, and int32[k] the
        triangles.
    """
    across = -(-frame.columns // TILE)
    down = -(-frame.rows // TILE)
    counts = np.zeros(across * down, dtype=np.int64)
    none = np.empty(0, dtype=np.int32)
    _sort_in(corners, triangles, across, counts, none)
    ends = np.cumsum(counts)
    members = np.empty(int(ends[-1]), dtype=np.int32)
    _sort_in(corners, triangles, across, ends - counts, members)
    for tile in np.flatnonzero(counts).tolist():
        end, count = int(ends[tile]), int(counts[tile])
        done = (end - count) / len(members)
        yield done, tile // across * TILE, tile % across * TILE, members[end - count : end]


@kernel
def _sort_in(corners, triangles, across, places, members):  # type: ignore[no-untyped-def]
    """Count the triangles of each tile (no members), or write them down and move places."""
    down = len(places) // across
    for number in range(len(triangles)):
        a, b, c = triangles[number, 0], triangles[number, 1], triangles[number, 2]
        u = min(corners[a, 0], corners[b, 0], corners[c, 0])
        right = max(corners[a, 0], corners[b, 0], corners[c, 0])
        v = min(corners[a, 1], corners[b, 1], corners[c, 1])
        top = max(corners[a, 1], corners[b, 1], corners[c, 1])
        # One cell to spare: an edge between two cells belongs to the lower one.
        for row in range(max(int(v - 1.0) // TILE, 0), min(int(top + 1.0) // TILE, down - 1) + 1):
            for col in range(
                max(int(u - 1.0) // TILE, 0), min(int(right + 1.0) // TILE, across - 1) + 1
            ):
                tile = row * across + col
                if len(members) > 0:
                    members[places[tile]] = number
                places[tile] += 1
