"""Removal of unusable triangles."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

__all__ = ["Cleaned", "cleaned"]


@dataclass(frozen=True, eq=False)
class Cleaned:
    """Triangles that have an area, each once.

    Attributes:
        vertices: float64[V, 3], finite, no two alike, each used.
        triangles: int32[T, 3], rows of vertices, wound as they were.
        not_finite: triangles left out because a corner is not a finite number.
        degenerate: triangles left out because they have no area.
        doubled: triangles left out because another has the same corners.
    """

    vertices: NDArray[np.float64]
    triangles: NDArray[np.int32]
    not_finite: int
    degenerate: int
    doubled: int


def cleaned(vertices: NDArray[np.float64], triangles: NDArray[np.int64]) -> Cleaned:
    """Remove triangles with corners that are not finite, without an area, and second copies.

    Args:
        vertices: float64[V, 3].
        triangles: int64[T, 3], rows of vertices.
    """
    finite: NDArray[np.bool_] = np.asarray(np.isfinite(vertices).all(axis=1))
    whole = finite[triangles].all(axis=1)
    kept = triangles[whole]
    not_finite = len(triangles) - len(kept)

    # Corners at the same place become one vertex: formats as STL give each triangle its own.
    used, kept = _only_used(kept, len(vertices))
    places = vertices[used] + 0.0  # −0.0 is 0.0.
    number, first = _numbered(places)
    places, kept = places[first], number[kept]

    a, b, c = (places[kept[:, corner]] for corner in range(3))
    with np.errstate(over="ignore", invalid="ignore"):
        across = np.cross(b - a, c - a)
        edges = np.maximum(np.abs(b - a), np.abs(c - a)).max(axis=1)
        # Relative to its size: a triangle in kilometres is no better than one in millimetres.
        flat = np.abs(across).max(axis=1) <= 1e-12 * edges * edges
    with_area = kept[~flat]
    degenerate = len(kept) - len(with_area)

    _, once = _numbered(np.sort(with_area, axis=1))
    single = with_area[np.sort(once)]
    used, single = _only_used(single, len(places))
    return Cleaned(
        places[used],
        single.astype(np.int32),
        not_finite,
        degenerate,
        len(with_area) - len(once),
    )


def _only_used(
    triangles: NDArray[np.int64], count: int
) -> tuple[NDArray[np.bool_], NDArray[np.int64]]:
    """Which of ``count`` vertices triangles use, and the triangles renumbered to those."""
    used = np.zeros(count, dtype=np.bool_)
    used[triangles.ravel()] = True
    return used, (np.cumsum(used) - 1)[triangles]


def _numbered(rows: NDArray[Any]) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Number equal rows alike: int64[n] numbers, and int64[k] the first row of each number."""
    order = np.lexsort(rows.T)
    ordered = rows[order]
    new = np.ones(len(rows), dtype=np.bool_)
    new[1:] = (ordered[1:] != ordered[:-1]).any(axis=1)
    number = np.empty(len(rows), dtype=np.int64)
    number[order] = np.cumsum(new) - 1
    return number, order[new]
