"""Nearness of other teams to frontiers: kernels that several selectors share."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from swarmscout.core.jit import kernel
from swarmscout.destinations.view import LeaderView

__all__ = ["crowding", "crowding_kernel", "nearest_to_clusters", "push_kernel", "ranks_kernel"]


@kernel
def crowding_kernel(points, frontiers, reach, crowd):  # type: ignore[no-untyped-def]
    """Sum of max(0, 1 - distance / reach) over points, for each frontier.

    Args:
        points: float64[T, 2] in metres, NaN for none; frontiers: float64[F, 2] in metres.
        reach: in metres.
        crowd: float64[F], written.
    """
    for f in range(frontiers.shape[0]):
        total = 0.0
        for t in range(points.shape[0]):
            dx = frontiers[f, 0] - points[t, 0]
            dy = frontiers[f, 1] - points[t, 1]
            apart = np.sqrt(dx * dx + dy * dy)
            if apart < reach:
                total += 1.0 - apart / reach
        crowd[f] = total


def crowding(
    points_m: NDArray[np.float64], view: LeaderView, reach_m: float
) -> NDArray[np.float64]:
    """Crowding of each frontier: for each point 1 in the same place, falling to 0 at `reach_m`.

    Args:
        points_m: float64[T, 2]; NaN (a team without a destination) counts 0.
        view: the frontiers are taken from it.
        reach_m: distance within which points count.

    Returns:
        float64[F].
    """
    crowd = np.empty(len(view.frontiers_m))
    crowding_kernel(points_m, view.frontiers_m, reach_m, crowd)
    return crowd


@kernel
def push_kernel(points, frontiers, least, reach, push):  # type: ignore[no-untyped-def]
    """Sum of (1 / distance - 1 / reach)² / 2 over points, for each frontier.

    Args:
        points: float64[T, 2] in metres, NaN for none; frontiers: float64[F, 2] in metres.
        least, reach: in metres; smaller distances count as `least`.
        push: float64[F], added to.
    """
    for f in range(frontiers.shape[0]):
        for t in range(points.shape[0]):
            dx = frontiers[f, 0] - points[t, 0]
            dy = frontiers[f, 1] - points[t, 1]
            apart = np.sqrt(dx * dx + dy * dy)
            if apart < reach:
                push[f] += 0.5 * (1.0 / max(apart, least) - 1.0 / reach) ** 2


@kernel
def ranks_kernel(places, frontiers, clusters, nearest, ranks):  # type: ignore[no-untyped-def]
    """Distances of teams to clusters, and the number of teams that are nearer than the first.

    Args:
        places: float64[T, 2] in metres, the own team's first; frontiers: float64[F, 2] in metres.
        clusters: int64[F], of each frontier: 0 … C - 1.
        nearest: float64[T, C], written: distance to the nearest cell of each cluster.
        ranks: int64[C], written: teams strictly nearer than the first.
    """
    nearest[:] = np.inf
    for t in range(places.shape[0]):
        for f in range(frontiers.shape[0]):
            dx = frontiers[f, 0] - places[t, 0]
            dy = frontiers[f, 1] - places[t, 1]
            nearest[t, clusters[f]] = min(nearest[t, clusters[f]], np.sqrt(dx * dx + dy * dy))
    for c in range(nearest.shape[1]):
        ranks[c] = 0
        for t in range(1, places.shape[0]):
            ranks[c] += nearest[t, c] < nearest[0, c]


def nearest_to_clusters(
    places_m: NDArray[np.float64], view: LeaderView
) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """Straight-line distances of teams to the nearest cell of each cluster, and the first's ranks.

    Args:
        places_m: float64[T, 2], T ≥ 1.
        view: the frontiers and their C clusters are taken from it.

    Returns:
        float64[T, C] in metres; and int64[C], the number of teams that are strictly nearer than the
        first.
    """
    clusters = int(view.clusters.max()) + 1
    nearest, ranks = np.empty((len(places_m), clusters)), np.empty(clusters, dtype=np.int64)
    ranks_kernel(places_m, view.frontiers_m, view.clusters, nearest, ranks)
    return nearest, ranks
