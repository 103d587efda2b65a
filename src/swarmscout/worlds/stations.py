"""Charging stations derived from a world and a number of robots."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from swarmscout.core.errors import WorldError
from swarmscout.worlds.morphology import fits
from swarmscout.worlds.reachability import distance_along_ground, standing_places, start_cell
from swarmscout.worlds.spacing import take_apart
from swarmscout.worlds.world import World

__all__ = ["derive_starts", "derive_stations"]

_ROOM_M = (2.2, 1.8, 1.4, 1.0, 0.6, 0.0)
"""Distance to the walls that a station should have; tight worlds get what they have.

Robots charge within 1.5 m of a station: 2.2 m leaves a passage of 0.7 m beside them.
"""
_APART_M = ((8.0, 6.0, 4.0), (3.0,), (2.0,), (1.0,))
"""Distances between stations, the best first; room counts more than those in one bracket."""
_NEAR_BY_M = ((4.0,), (3.0,), (2.0,), (1.0,))
"""Distances between the places round which robots start."""
_FIRST_WITHIN_M = 5.0


def derive_stations(world: World, count: int) -> NDArray[np.float64]:
    """Find places for charging stations: roomy, apart, and near the start along the ground.

    Twenty robots of 0.3 m find place within 1.5 m of a station and do not close the passage, where
    the world is wide enough for that. Stations far from each other share the traffic, and reach
    farther: rather than in a narrow place they stand a little closer together.

    Args:
        world: a world.
        count: how many stations.

    Returns:
        float64[count, 2], ``(x, y)`` in metres, the one nearest to the start first.

    Raises:
        WorldError: the world has no room for that many.
    """
    return _roomy_places(world, count, _APART_M)


def derive_starts(world: World, count: int) -> NDArray[np.float64]:
    """Find places round which robots start: like those of stations, but closer together.

    Args:
        world: a world.
        count: how many.

    Returns:
        float64[count, 2], ``(x, y)`` in metres, the one nearest to the start first.

    Raises:
        WorldError: the world has no room for that many.
    """
    return _roomy_places(world, count, _NEAR_BY_M)


def _roomy_places(
    world: World, count: int, distances: tuple[tuple[float, ...], ...]
) -> NDArray[np.float64]:
    """Places with room, apart by the first of the distances for which there are enough."""
    cells, steps = _cells_near(world, max(distances[0]), count)
    found = 0
    for alike in distances:
        for room_m in _ROOM_M:
            roomy = _with_room(world, cells, room_m)
            if not len(roomy) or (
                room_m > 0.0
                and steps[roomy[0, 0], roomy[0, 1]] > _FIRST_WITHIN_M / world.resolution_m
            ):
                continue
            far = steps[roomy[:, 0], roomy[:, 1]]
            flat = roomy[:, 0] * world.frame.columns + roomy[:, 1]
            for apart_m in alike:
                near = flat[far <= _farthest(world, apart_m, count)]
                taken = take_apart(near, world.frame, apart_m, count)
                found = len(taken)
                if found == count:
                    places = world.frame.centres_of(taken)
                    places.setflags(write=False)
                    return places
    raise WorldError(
        f"world '{world.name}' has room for {found} charging stations, {count} are needed; "
        "take fewer robots or a larger world, or set the stations by hand"
    )


def _farthest(world: World, apart_m: float, count: int) -> int:
    """Steps from the start to the farthest of stations with this distance, about."""
    return math.ceil((10.0 + 2.0 * apart_m * count) / world.resolution_m)


def _cells_near(
    world: World, apart_m: float, count: int
) -> tuple[NDArray[np.int64], NDArray[np.int32]]:
    """Cells about as far from the start as stations may stand, the nearest first, and how far."""
    place = standing_places(world)
    farthest = _farthest(world, apart_m, count)
    steps = distance_along_ground(place, [start_cell(world)], farthest)
    cells = np.argwhere(steps >= 0)
    return cells[np.argsort(steps[cells[:, 0], cells[:, 1]], kind="stable")], steps


def _with_room(world: World, cells: NDArray[np.int64], room_m: float) -> NDArray[np.int64]:
    """Those cells at whose centre a disc of this radius meets no wall."""
    margin = math.ceil(room_m / world.resolution_m) + 1
    top, left = np.maximum(cells.min(axis=0) - margin, 0)
    bottom, right = cells.max(axis=0) + margin + 1
    room = fits(world.free[top:bottom, left:right], world.resolution_m, room_m)
    roomy: NDArray[np.int64] = cells[room[cells[:, 0] - top, cells[:, 1] - left]]
    return roomy
