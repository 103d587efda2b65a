"""Charging stations derived from a world and a number of robots."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from swarmscout.core.errors import WorldError
from swarmscout.worlds.morphology import fits
from swarmscout.worlds.reachability import distance_along_ground, standing_places, start_cell
from swarmscout.worlds.world import World

__all__ = ["derive_stations"]

_ROOM_M = (2.2, 1.8, 1.4, 1.0, 0.6, 0.0)
"""Distance to the walls that a station should have; tight worlds get what they have.

Robots charge within 1.5 m of a station: 2.2 m leaves a passage of 0.7 m beside them.
"""
_APART_M = (4.0, 3.0, 2.0, 1.0)
_FIRST_WITHIN_M = 5.0


def derive_stations(world: World, count: int) -> NDArray[np.float64]:
    """Find places for charging stations: roomy, apart, and near the start along the ground.

    Twenty robots of 0.3 m find place within 1.5 m of a station and do not close the passage, where
    the world is wide enough for that.

    Args:
        world: a world.
        count: how many stations.

    Returns:
        float64[count, 2], ``(x, y)`` in metres, the one nearest to the start first.

    Raises:
        WorldError: the world has no room for that many.
    """
    place = standing_places(world)
    found: list[tuple[int, int]] = []
    for apart_m in _APART_M:
        farthest = math.ceil((10.0 + 2.0 * apart_m * count) / world.resolution_m)
        steps = distance_along_ground(place, [start_cell(world)], farthest)
        cells = np.argwhere(steps >= 0)
        cells = cells[np.argsort(steps[cells[:, 0], cells[:, 1]], kind="stable")]
        for room_m in _ROOM_M:
            roomy = _with_room(world, cells, room_m)
            if not len(roomy) or (
                room_m > 0.0
                and steps[roomy[0, 0], roomy[0, 1]] > _FIRST_WITHIN_M / world.resolution_m
            ):
                continue
            found = _nearest_apart(roomy, apart_m / world.resolution_m, count)
            if len(found) == count:
                stations = world.frame.centres_of(np.array(found))
                stations.setflags(write=False)
                return stations
    raise WorldError(
        f"world '{world.name}' has room for {len(found)} charging stations, {count} are needed; "
        "take fewer robots or a larger world, or set the stations by hand"
    )


def _nearest_apart(cells: NDArray[np.int64], apart: float, count: int) -> list[tuple[int, int]]:
    """The first cells of a sorted list that are at least ``apart`` cells from each other."""
    found: list[tuple[int, int]] = []
    left = cells
    while len(left) and len(found) < count:
        row, col = int(left[0, 0]), int(left[0, 1])
        found.append((row, col))
        far = (left[:, 0] - row) ** 2 + (left[:, 1] - col) ** 2 >= apart**2 - 1e-9
        left = left[far]
    return found


def _with_room(world: World, cells: NDArray[np.int64], room_m: float) -> NDArray[np.int64]:
    """Those cells at whose centre a disc of this radius meets no wall."""
    margin = math.ceil(room_m / world.resolution_m) + 1
    top, left = np.maximum(cells.min(axis=0) - margin, 0)
    bottom, right = cells.max(axis=0) + margin + 1
    room = fits(world.free[top:bottom, left:right], world.resolution_m, room_m)
    roomy: NDArray[np.int64] = cells[room[cells[:, 0] - top, cells[:, 1] - left]]
    return roomy
