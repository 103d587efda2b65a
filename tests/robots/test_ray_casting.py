"""Rays against a brute-force oracle: every ray against the square of every wall cell."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from swarmscout.robots.bodies import TICKS, place_bodies
from swarmscout.robots.sensors.fan import Fan
from swarmscout.robots.sensors.raster_rays import add_noise, raster_ranges
from swarmscout.worlds.world import World

SLACK = 1e-7

Array = NDArray[np.float64]


def wall_corners(world: World, reach_m: float) -> Array:
    """Lower left corners of all wall cells, and of those round the raster as far as rays go."""
    ring = int(np.ceil(reach_m / world.resolution_m)) + 2
    wall = np.pad(world.free == 0, ring, constant_values=True)
    rows, cols = np.nonzero(wall)
    corners = np.column_stack([cols, rows]) - ring
    return corners * world.resolution_m + np.array(world.origin_m)


def nearest_wall(corners: Array, edge: float, start: Array, angle: float, grow: float) -> float:
    """Distance from a point along a ray to the nearest square (slab test); inf without one."""
    enter = np.full(len(corners), 0.0)
    leave = np.full(len(corners), np.inf)
    for axis, part in enumerate((np.cos(angle), np.sin(angle))):
        low = corners[:, axis] - grow - start[axis]
        high = low + edge + 2.0 * grow
        if abs(part) < 1e-12:
            beside = (low > 0.0) | (high < 0.0)
            leave[beside] = -np.inf
            continue
        enter = np.maximum(enter, np.minimum(low / part, high / part))
        leave = np.minimum(leave, np.maximum(low / part, high / part))
    hit = enter <= leave
    return float(enter[hit].min()) if hit.any() else np.inf


class Rays:
    """Directions over a fan, and the longest range."""

    def __init__(self, rays: int, fan_deg: float, range_m: float) -> None:
        angles = np.linspace(-fan_deg, fan_deg, rays) if rays > 1 else np.zeros(1)
        self.offsets = np.rint(angles * TICKS / 360).astype(np.int64)
        self.range_m = range_m


def sense(
    world: World, position: Array, heading: NDArray[np.int64], sensor: Rays,
    alive: NDArray[np.bool_] | None = None,
) -> Array:  # fmt: skip
    bodies = place_bodies(position, heading, np.ones(len(position)))
    if alive is not None:
        bodies.alive[:] = alive
    return raster_ranges(bodies, world, sensor.offsets, sensor.range_m)


def agree(
    world: World, position: Array, heading: NDArray[np.int64], sensor: Rays
) -> tuple[int, int]:
    """Assert that all ranges agree with the oracle; returns how many rays met a wall, and none."""
    ranges = sense(world, position, heading, sensor)
    corners = wall_corners(world, sensor.range_m)
    met = nothing = 0
    for i, r in np.ndindex(ranges.shape):
        angle = 2.0 * np.pi * (int(heading[i]) + int(sensor.offsets[r])) / TICKS
        # A ray that grazes a corner may or may not meet it: walls a little larger and smaller.
        soonest, latest = (
            nearest_wall(corners, world.resolution_m, position[i], angle, grow)
            for grow in (SLACK, -SLACK)
        )
        if np.isinf(ranges[i, r]):
            assert latest > sensor.range_m - 1e-4 * world.resolution_m
            nothing += 1
        else:
            assert 0.0 <= ranges[i, r] <= sensor.range_m + 1e-12
            # A ray at a flat angle to a face meets the grown face much earlier.
            assert soonest - 1e-9 <= ranges[i, r] <= latest + 1e-9
            met += 1
    return met, nothing


def random_world(
    rng: np.random.Generator, rows: int, columns: int, resolution_m: float, walls: float
) -> World:
    free = (rng.random((rows, columns)) >= walls).astype(np.uint8)
    free[rng.integers(rows), rng.integers(columns)] = 1
    return World("test", free, resolution_m, tuple(rng.uniform(-5.0, 5.0, 2).tolist()))


def free_places(rng: np.random.Generator, world: World, robots: int) -> NDArray[np.float64]:
    """Random points in free cells."""
    cells = np.argwhere(world.free)[rng.integers(0, world.free.sum(), robots)]
    inside = cells[:, ::-1] + rng.random((robots, 2))
    return inside * world.resolution_m + np.array(world.origin_m)


@settings(max_examples=150)
@given(
    seed=st.integers(0, 2**32 - 1),
    rows=st.integers(1, 20),
    columns=st.integers(1, 20),
    resolution_m=st.floats(0.03, 0.5),
    walls=st.sampled_from([0.0, 0.02, 0.1, 0.3, 0.7]),
    range_m=st.floats(0.05, 1.5),
    rays=st.integers(1, 12),
)
def test_ranges_equal_the_oracle_at_random_places(
    seed: int, rows: int, columns: int, resolution_m: float, walls: float, range_m: float, rays: int
) -> None:
    rng = np.random.default_rng(seed)
    world = random_world(rng, rows, columns, resolution_m, walls)
    position = free_places(rng, world, 3)
    agree(world, position, rng.integers(0, TICKS, 3), Rays(rays, 170.0, range_m))


@settings(max_examples=150)
@given(seed=st.integers(0, 2**32 - 1), walls=st.sampled_from([0.05, 0.2, 0.5]))
def test_ranges_equal_the_oracle_on_borders_corners_and_along_the_axes(
    seed: int, walls: float
) -> None:
    rng = np.random.default_rng(seed)
    free = (rng.random((9, 11)) >= walls).astype(np.uint8)
    free[4, 5] = 1
    world = World("test", free, 0.25)  # Exact in binary, so places can lie on borders.
    cells = np.argwhere(free)[rng.integers(0, free.sum(), 4)]
    # Lower left corner of a cell, middle of a border, or the centre.
    position = (cells[:, ::-1] + rng.choice([0.0, 0.5], (4, 2))) * 0.25
    heading = rng.integers(0, 8, 4) * (TICKS // 8)
    agree(world, position, heading, Rays(9, 180.0, 1.0))


def test_the_oracle_is_put_to_work() -> None:
    """Both kinds of ray occur often, so that the properties above say something."""
    rng = np.random.default_rng(0)
    world = random_world(rng, 20, 20, 0.2, 0.1)
    met, nothing = agree(
        world, free_places(rng, world, 20), rng.integers(0, TICKS, 20), Rays(9, 70.0, 1.0)
    )
    assert met > 40
    assert nothing > 40


def test_outside_the_raster_is_wall() -> None:
    world = World("room", np.ones((4, 6), dtype=np.uint8), 0.5, (-1.0, 2.0))
    position = np.tile(np.array([[0.3, 2.9]]), (4, 1))
    heading = np.array([0, 900, 1800, 2700])
    ranges = sense(world, position, heading, Rays(1, 0.0, 10.0))
    assert ranges[:, 0] == pytest.approx([1.7, 1.1, 1.3, 0.9])


@given(seed=st.integers(0, 2**32 - 1), scale=st.sampled_from([0.01, 0.3, 3.0]))
def test_noise_is_added_to_what_is_met_and_stays_within_the_range(seed: int, scale: float) -> None:
    rng = np.random.default_rng(seed)
    exact = rng.uniform(0.0, 1.0, (5, 9))
    exact[rng.random(exact.shape) < 0.4] = np.inf
    noise = rng.normal(0.0, 1.0, exact.shape)
    noisy = exact.copy()
    add_noise(noisy, noise, scale, 1.0)
    measured = np.maximum(0.0, exact + scale * noise)
    expected = np.where(measured <= 1.0, measured, np.inf)
    assert np.allclose(noisy, expected, rtol=0.0, atol=1e-12)


def test_dead_robots_see_nothing_and_take_nothing_from_the_others() -> None:
    rng = np.random.default_rng(3)
    world = random_world(rng, 15, 15, 0.1, 0.2)
    position, heading = free_places(rng, world, 6), rng.integers(0, TICKS, 6)
    sensor = Rays(9, 70.0, 1.0)
    alive = np.array([True, False, True, False, False, True])
    some = sense(world, position, heading, sensor, alive)
    everybody = sense(world, position, heading, sensor)
    assert np.isinf(some[~alive]).all()
    assert np.array_equal(some[alive], everybody[alive])


@given(st.integers(2, 40), st.floats(0.0, 179.9))
def test_rays_are_spread_evenly_from_right_to_left(rays: int, fan_deg: float) -> None:
    even = [-fan_deg + 2.0 * fan_deg * k / (rays - 1) for k in range(rays)]
    assert np.abs(np.array(Fan(rays=rays, fan_deg=fan_deg).angles_deg()) - even).max() <= 1e-9
    assert Fan(rays=1, fan_deg=fan_deg).angles_deg() == [0.0]


@settings(max_examples=25)
@given(seed=st.integers(0, 2**32 - 1), range_m=st.floats(1.0, 30.0))
def test_long_rays_in_open_caves_equal_the_oracle(seed: int, range_m: float) -> None:
    """Rays leap over what is free: in the open, far from walls, and along them."""
    rng = np.random.default_rng(seed)
    free = np.zeros((60, 90), dtype=np.uint8)
    for _ in range(12):
        row, col = rng.integers(0, 50), rng.integers(0, 75)
        free[row : row + rng.integers(1, 30), col : col + rng.integers(1, 40)] = 1
    free[rng.integers(0, 60, 20), rng.integers(0, 90, 20)] = 0
    free[30, 45] = 1
    world = World("caves", free, 0.1, tuple(rng.uniform(-5.0, 5.0, 2).tolist()))
    position = free_places(rng, world, 3)
    agree(world, position, rng.integers(0, TICKS, 3), Rays(24, 172.5, range_m))
