"""Features of candidates that a prompt shows, as columns of a table."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from swarmscout.destinations.view import LeaderView

__all__ = ["FEATURES", "columns_of"]

FEATURES = ("paper", "full")
"""``paper``: those of the paper's prompt. ``full``: also ways, turns, unknown area, others."""


def columns_of(view: LeaderView, features: str) -> dict[str, NDArray[np.float64]]:
    """Columns that describe each frontier of a view.

    Args:
        view: a leader's view with F frontiers.
        features: one of :data:`FEATURES`.

    Returns:
        Name to float64[F].
    """
    columns: dict[str, NDArray[np.float64]] = {
        "distance_m": np.round(view.distances_m, 1),
        "frontier_neighbours": view.frontier_neighbours.astype(np.float64),
        "obstacle_neighbours": view.obstacle_neighbours.astype(np.float64),
    }
    if features == "full":
        columns["way_m"] = np.round(view.path_length_m, 1)
        columns["turn_deg"] = np.round(view.turns_rad * (180.0 / np.pi))
        columns["unknown_m2"] = np.round(view.unknown_m2(2.0), 1)
        columns["nearest_other_destination_m"] = np.round(_to_others(view), 1)
    return columns


def _to_others(view: LeaderView) -> NDArray[np.float64]:
    """float64[F], straight distance to the nearest destination of another team; inf: none."""
    goals = view.others.destinations_m
    goals = goals[~np.isnan(goals[:, 0])]
    if len(goals) == 0:
        return np.full(len(view.frontiers), np.inf)
    apart = view.frontiers_m[:, None, :] - goals[None, :, :]
    return np.asarray(np.sqrt(apart[..., 0] ** 2 + apart[..., 1] ** 2).min(axis=1))
