"""Fewer triangles for the same surface, within a bound, and still closed.

Source: M. Garland and P. Heckbert, "Surface simplification using quadric error metrics", 1997, as
fast-simplification has it.
"""

from __future__ import annotations

import threading

import numpy as np
from numpy.typing import NDArray

from swarmscout.worlds.meshes.surfacing import Triangles

__all__ = ["TOLERANCE_M", "decimated"]

_SHRINK = 2.0**-21
"""A power of two: it changes no digit of a number."""
_LEAST_ERROR = np.finfo(np.float64).eps
TOLERANCE_M = float(np.sqrt(_LEAST_ERROR)) / _SHRINK
"""0.031 m: no vertex moves farther from the planes of the triangles that it replaces.

The library's lossless mode collapses an edge if the squares of these distances add up to less than
rounding; in a mesh so much smaller that is this bound.
"""
_SPARED_M = 0.5
_TRIES = 6
_ONE_AT_A_TIME = threading.Lock()
"""The library keeps the mesh that it works on in one place for all threads."""


def decimated(surface: Triangles) -> Triangles:
    """Collapse edges as long as the surface stays where it is, within :data:`TOLERANCE_M`.

    Collapsing may pinch a surface so that an edge has four triangles. Where that happens the
    original stays as it is. Open borders stay as they are, too.

    Args:
        surface: vertices and triangles, each edge with two triangles, or one on an open border.

    Returns:
        The same with fewer vertices and triangles; the surface itself where nothing helped. Round
        each vertex triangles form one fan.
    """
    vertices, triangles = surface
    spared = np.zeros(len(triangles), dtype=np.bool_)
    borders = len(_border(triangles))
    middles = vertices[triangles].mean(axis=1)
    for _ in range(_TRIES):
        fewer = _collapsed(vertices, triangles[~spared])
        whole = _welded(fewer, (vertices, triangles[spared]))
        pinched = _pinched(whole)
        if not len(pinched) and len(_border(whole[1])) == borders:
            return _one_fan_a_vertex(whole)
        for place in pinched:
            spared |= ((middles - place) ** 2).sum(axis=1) < _SPARED_M**2
    return _one_fan_a_vertex(surface)


def _collapsed(vertices: NDArray[np.float64], triangles: NDArray[np.int64]) -> Triangles:
    import fast_simplification

    used, numbers = np.unique(triangles, return_inverse=True)
    with _ONE_AT_A_TIME:
        places, faces = fast_simplification.simplify(
            vertices[used] * _SHRINK,
            numbers.reshape(-1, 3).astype(np.int32),
            lossless=True,
            preserve_border=True,
        )
    return np.asarray(places, dtype=np.float64) / _SHRINK, np.asarray(faces, dtype=np.int64)


def _welded(one: Triangles, other: Triangles) -> Triangles:
    """Both as one: vertices at exactly the same place become one."""
    if not len(other[1]):
        return one
    used, numbers = np.unique(other[1], return_inverse=True)
    places = np.concatenate((one[0], other[0][used]))
    faces = np.concatenate((one[1], numbers.reshape(-1, 3) + len(one[0])))
    unique, which = np.unique(places, axis=0, return_inverse=True)
    return unique, which.reshape(-1)[faces]


def _edges(triangles: NDArray[np.int64]) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Each edge once, as [E, 2] vertices, and how many triangles it has [E]."""
    ends = np.concatenate((triangles[:, :2], triangles[:, 1:], triangles[:, ::2]))
    low, high = ends.min(axis=1), ends.max(axis=1)
    size = int(triangles.max()) + 1 if len(triangles) else 1
    names, counts = np.unique(low * size + high, return_counts=True)
    return np.column_stack((names // size, names % size)), counts


def _border(triangles: NDArray[np.int64]) -> NDArray[np.int64]:
    edges, counts = _edges(triangles)
    return np.asarray(edges[counts == 1], dtype=np.int64)


def _pinched(surface: Triangles) -> NDArray[np.float64]:
    """Places [n, 3] of edges with more than two triangles."""
    edges, counts = _edges(surface[1])
    return np.asarray(surface[0][edges[counts > 2, 0]], dtype=np.float64)


def _one_fan_a_vertex(surface: Triangles) -> Triangles:
    """Take vertices apart where two fans of triangles touch in nothing but a point."""
    from scipy import sparse  # It takes a while to load.

    vertices, triangles = surface
    if not len(triangles):
        return surface
    # A corner is a triangle's share of a vertex; triangles with a common edge share its two ends.
    starts, ends = triangles.ravel(), np.roll(triangles, -1, axis=1).ravel()
    corners = np.arange(len(starts)).reshape(-1, 3)
    after = np.roll(corners, -1, axis=1).ravel()
    names = np.minimum(starts, ends) * len(vertices) + np.maximum(starts, ends)
    order = np.argsort(names, kind="stable")
    twins = np.flatnonzero(names[order[1:]] == names[order[:-1]])
    one, other = order[twins], order[twins + 1]
    links = np.concatenate((one, after[one])), np.concatenate((after[other], other))
    graph = sparse.coo_matrix(
        (np.ones(len(links[0]), dtype=np.int8), links), shape=(len(starts), len(starts))
    )
    count, fans = sparse.csgraph.connected_components(graph, directed=False)
    owners = np.empty(count, dtype=np.int64)
    owners[fans] = starts
    return vertices[owners], fans.reshape(-1, 3).astype(np.int64)
