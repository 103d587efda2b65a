"""Where charging stations stand and where robots start.

Both are found by distance along the ground from the start, never through a wall. Each place is a
cell's centre, so that "clear of walls" is exact.
"""

from __future__ import annotations

import math
from contextlib import suppress

import numpy as np
from numpy.typing import NDArray

from swarmscout.core.errors import WorldError, did_you_mean
from swarmscout.worlds.morphology import fits
from swarmscout.worlds.reachability import distance_along_ground, standing_places, start_cell
from swarmscout.worlds.spacing import take_apart
from swarmscout.worlds.stations import derive_starts, derive_stations
from swarmscout.worlds.world import World

__all__ = ["place_robots", "place_stations"]

FEW_ROBOTS = 20
"""Largest swarm with a single station."""

ROBOTS_PER_STATION = 10
"""Robots per station in larger swarms, in which robots get in each other's way."""

_ROBOTS_PER_START = 20
_SPACING_M = 0.6
_CLEARANCE_M = 0.05
_CHOICE = 1.25
"""One place in five stays empty when all start from one place: that is the random part of it."""


def place_stations(world: World, robots: int) -> NDArray[np.float64]:
    """The charging stations of a mission.

    Args:
        world: a world.
        robots: how many robots will use them.

    Returns:
        float64[k, 2], ``(x, y)`` in metres: the world's own where they were set by hand, else one
        for up to 20 robots, or one for each 10; the first near the start, the others near by along
        the ground.

    Raises:
        WorldError: no station finds room near the start.
    """
    if world.stations_m is not None:
        return world.stations_m
    count = 1 if robots <= FEW_ROBOTS else math.ceil(robots / ROBOTS_PER_STATION)
    return world.once(("stations", count), lambda: derive_stations(world, count))


def place_robots(
    world: World, robots: int, start: str, rng: np.random.Generator, radius_m: float = 0.15
) -> NDArray[np.float64]:
    """Starting places of robots: apart from each other by 0.6 m and clear of walls by 0.05 m.

    Args:
        world: a world.
        robots: how many.
        start: ``"one-place"`` (near the start along the ground, around centres chosen like
            stations but 4 m apart; around the start where stations were set by hand) or
            ``"spread"`` (anywhere that can be reached).
        rng: chooses among the places and assigns them to robots.
        radius_m: a robot's radius, in metres.

    Returns:
        float64[robots, 2], ``(x, y)`` in metres.

    Raises:
        WorldError: there is no room for that many, or ``start`` is unknown.
    """
    rules = {"one-place": _places_near_start, "spread": _places_anywhere}
    if start not in rules:
        raise WorldError(f"unknown start '{start}': {did_you_mean(start, rules)}")
    if robots < 1:
        raise WorldError(f"robots = {robots}: expected at least 1")
    place = standing_places(world, radius_m)
    clear = world.once(
        ("clear", radius_m),
        lambda: fits(world.free, world.resolution_m, radius_m + _CLEARANCE_M) & place,
    )
    spacing_m = max(_SPACING_M, 2.0 * radius_m + _CLEARANCE_M)
    cells = rules[start](world, robots, clear, spacing_m, radius_m, rng)
    if len(cells) < robots:
        where = "round its start" if start == "one-place" else "in all"
        raise WorldError(
            f"world '{world.name}' has room for {len(cells)} robots of {2 * radius_m:g} m {where}, "
            f"not for {robots}; take fewer robots or a larger world"
        )
    return world.frame.centres_of(cells)


def _places_near_start(
    world: World,
    robots: int,
    clear: NDArray[np.bool_],
    spacing_m: float,
    radius_m: float,
    rng: np.random.Generator,
) -> NDArray[np.int64]:
    place = standing_places(world, radius_m)
    sources = [start_cell(world, radius_m)]
    if world.stations_m is None:
        # Where there is no room for these there is none for the robots: count those.
        count = math.ceil(robots / _ROBOTS_PER_START)
        with suppress(WorldError):
            at = world.frame.cells_of(
                world.once(("starts", count), lambda: derive_starts(world, count))
            ).tolist()
            sources = [(row, col) for row, col in at if place[row, col]] or sources
    wanted = math.ceil(robots * _CHOICE)
    # Look no farther than needed: twice the radius of a half-filled disc, and then farther.
    share = math.ceil(wanted / len(sources))
    farthest = math.ceil(2.0 * spacing_m * math.sqrt(share) / world.resolution_m) + 2
    while True:
        steps = distance_along_ground(place, sources, farthest)
        near = np.flatnonzero((steps >= 0) & clear)
        near = near[np.argsort(steps.ravel()[near], kind="stable")]
        chosen = take_apart(near, world.frame, spacing_m, wanted)
        if len(chosen) >= wanted or farthest > steps.max():
            break
        farthest *= 2
    keep = rng.permutation(len(chosen))[:robots]
    return chosen[keep]


def _places_anywhere(
    world: World,
    robots: int,
    clear: NDArray[np.bool_],
    spacing_m: float,
    radius_m: float,
    rng: np.random.Generator,
) -> NDArray[np.int64]:
    everywhere = np.flatnonzero(clear)
    few = rng.integers(0, max(everywhere.size, 1), size=8 * robots if everywhere.size else 0)
    chosen = take_apart(everywhere[few], world.frame, spacing_m, robots)
    if len(chosen) < robots:
        # A crowded world: try every place once.
        chosen = take_apart(rng.permutation(everywhere), world.frame, spacing_m, robots)
    return chosen
