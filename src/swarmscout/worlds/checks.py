"""Conditions that a world must meet before a mission starts in it."""

from __future__ import annotations

import math

import numpy as np

from swarmscout.core.errors import WorldError
from swarmscout.worlds.placement import place_robots, place_stations
from swarmscout.worlds.reachability import standing_places
from swarmscout.worlds.resampling import check_length
from swarmscout.worlds.world import World

__all__ = ["check_world"]

_BESIDE_M = 0.5
"""A station may stand in a niche: some place within this distance must be reachable."""


def check_world(
    world: World, robots: int, start: str = "one-place", radius_m: float = 0.15
) -> None:
    """Check that a mission can start in a world, and say what is wrong if not.

    Args:
        world: a world.
        robots: how many robots will start.
        start: ``"one-place"`` or ``"spread"``.
        radius_m: a robot's radius, in metres.

    Raises:
        WorldError: a raster has a wrong type or shape or impossible numbers, the start is not free
            or too small, or a charging station is in a wall or out of reach.
    """
    _check_rasters(world)
    _check_start(world)
    standing_places(world, radius_m)
    # Of the numbers, that of robots says more than that of stations: it comes first.
    place_robots(world, robots, start, np.random.default_rng(0), radius_m)
    _check_stations(world, robots, radius_m)


def _check_rasters(world: World) -> None:
    where = f"world '{world.name}'"
    free = world.free
    if not isinstance(free, np.ndarray) or free.dtype != np.uint8 or free.ndim != 2:
        kind = f"{free.dtype}{list(free.shape)}" if isinstance(free, np.ndarray) else type(free)
        raise WorldError(f"{where}: free is {kind}, expected uint8[rows, cols] of 0 and 1")
    if not free.size or not free.any():
        raise WorldError(f"{where}: nothing is free in {free.shape[0]} × {free.shape[1]} cells")
    if int(free.max()) > 1:
        raise WorldError(f"{where}: free holds {int(free.max())}, expected only 0 and 1")
    check_length(f"{where}: resolution_m", world.resolution_m)
    if not all(math.isfinite(part) for part in world.origin_m):
        raise WorldError(f"{where}: origin_m = {world.origin_m}, expected finite metres")
    for name, heights in (("ground_m", world.ground_m), ("ceiling_m", world.ceiling_m)):
        if heights is None:
            continue
        if heights.shape != free.shape or heights.dtype != np.float32:
            raise WorldError(
                f"{where}: {name} is {heights.dtype}{list(heights.shape)}, "
                f"expected float32{list(free.shape)} as free has"
            )
        if not np.isfinite(heights).all():
            row, col = np.argwhere(~np.isfinite(heights))[0]
            raise WorldError(f"{where}: {name}[{row}, {col}] = {heights[row, col]}, not finite")
    if world.ground_m is not None and world.ceiling_m is not None:
        low = (world.ceiling_m <= world.ground_m) & (free != 0)
        if low.any():
            row, col = np.argwhere(low)[0]
            raise WorldError(f"{where}: at free cell ({row}, {col}) the ceiling is on the ground")


def _check_start(world: World) -> None:
    if world.start_m is None:
        return
    row, col = _cell_inside(world, "start", world.start_m)
    if not world.free[row, col]:
        raise WorldError(
            f"world '{world.name}': the start ({world.start_m[0]:g}, {world.start_m[1]:g}) m is "
            "not free: move it into open space, or leave it out and one is found"
        )


def _check_stations(world: World, robots: int, radius_m: float) -> None:
    if world.stations_m is not None and (
        world.stations_m.ndim != 2 or world.stations_m.shape[1] != 2 or not len(world.stations_m)
    ):
        shape = list(world.stations_m.shape)
        raise WorldError(f"world '{world.name}': stations_m has shape {shape}, expected [k, 2]")
    place = standing_places(world, radius_m)
    about = math.ceil(_BESIDE_M / world.resolution_m)
    for number, (x, y) in enumerate(place_stations(world, robots).tolist()):
        what = f"station {number} at ({x:g}, {y:g}) m"
        row, col = _cell_inside(world, f"station {number}", (x, y))
        if not world.free[row, col]:
            raise WorldError(f"world '{world.name}': {what} is in a wall")
        window = (
            slice(max(row - about, 0), row + about + 1),
            slice(max(col - about, 0), col + about + 1),
        )
        if not place[window].any():
            raise WorldError(f"world '{world.name}': {what} cannot be reached from the start")


def _cell_inside(world: World, what: str, point: tuple[float, float]) -> tuple[int, int]:
    """The cell of a point, which must lie in the world."""
    x, y = point
    inside = (
        math.isfinite(x) and math.isfinite(y) and world.frame.contains(*world.frame.cell_of(x, y))
    )
    if not inside:
        left, right, bottom, top = world.extent
        raise WorldError(
            f"world '{world.name}': {what} ({x:g}, {y:g}) m lies outside the world: x from "
            f"{left:g} to {right:g} m, y from {bottom:g} to {top:g} m"
        )
    return world.frame.cell_of(x, y)
