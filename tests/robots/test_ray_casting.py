"""Rays against a brute-force oracle: every ray against the square of every wall cell."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from swarmscout.robots.bodies import TICKS, heading_table
from swarmscout.robots.range_sensor import RangeSensor, cast_rays
from swarmscout.worlds.world import World

TABLE = heading_table()
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


def sense(
    world: World, position: Array, heading: NDArray[np.int64], sensor: RangeSensor,
    alive: NDArray[np.bool_] | None = None, noise: Array | None = None,
) -> Array:  # fmt: skip
    shape = len(position), len(sensor.offsets)
    ranges = np.full(shape, np.nan)
    cast_rays(
        world.free, *world.origin_m, world.resolution_m, position, heading,
        np.ones(shape[0], dtype=np.bool_) if alive is None else alive,
        sensor.offsets, TABLE, sensor.range_m, np.zeros(shape) if noise is None else noise, ranges,
    )  # fmt: skip
    return ranges


def agree(
    world: World, position: Array, heading: NDArray[np.int64], sensor: RangeSensor
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
    agree(world, position, rng.integers(0, TICKS, 3), RangeSensor(rays, 170.0, range_m))


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
    agree(world, position, heading, RangeSensor(9, 180.0, 1.0))


def test_the_oracle_is_put_to_work() -> None:
    """Both kinds of ray occur often, so that the properties above say something."""
    rng = np.random.default_rng(0)
    world = random_world(rng, 20, 20, 0.2, 0.1)
    met, nothing = agree(
        world, free_places(rng, world, 20), rng.integers(0, TICKS, 20), RangeSensor(9, 70.0, 1.0)
    )
    assert met > 40
    assert nothing > 40


def test_outside_the_raster_is_wall() -> None:
    world = World("room", np.ones((4, 6), dtype=np.uint8), 0.5, (-1.0, 2.0))
    position = np.tile(np.array([[0.3, 2.9]]), (4, 1))
    heading = np.array([0, 900, 1800, 2700])
    ranges = sense(world, position, heading, RangeSensor(1, 0.0, 10.0))
    assert ranges[:, 0] == pytest.approx([1.7, 1.1, 1.3, 0.9])


@given(seed=st.integers(0, 2**32 - 1), scale=st.sampled_from([0.01, 0.3, 3.0]))
def test_noise_is_added_to_what_is_met_and_ranges_stay_positive(seed: int, scale: float) -> None:
    rng = np.random.default_rng(seed)
    world = random_world(rng, 12, 12, 0.2, 0.2)
    position, heading = free_places(rng, world, 5), rng.integers(0, TICKS, 5)
    sensor = RangeSensor(9, 70.0, 1.0)
    noise = rng.normal(0.0, scale, (5, 9))
    exact = sense(world, position, heading, sensor)
    noisy = sense(world, position, heading, sensor, noise=noise)
    assert np.array_equal(np.isinf(exact), np.isinf(noisy))
    met = np.isfinite(exact)
    assert np.allclose(noisy[met], np.maximum(0.0, exact[met] + noise[met]), rtol=0.0, atol=1e-12)
    assert (noisy >= 0.0).all()


def test_dead_robots_see_nothing_and_take_nothing_from_the_others() -> None:
    rng = np.random.default_rng(3)
    world = random_world(rng, 15, 15, 0.1, 0.2)
    position, heading = free_places(rng, world, 6), rng.integers(0, TICKS, 6)
    sensor, noise = RangeSensor(9, 70.0, 1.0), rng.normal(0.0, 0.02, (6, 9))
    alive = np.array([True, False, True, False, False, True])
    some = sense(world, position, heading, sensor, alive, noise)
    everybody = sense(world, position, heading, sensor, None, noise)
    assert np.isinf(some[~alive]).all()
    assert np.array_equal(some[alive], everybody[alive])


@given(st.integers(2, 40), st.floats(0.0, 180.0))
def test_rays_are_spread_evenly_from_right_to_left(rays: int, fan_deg: float) -> None:
    sensor = RangeSensor(rays, fan_deg, 1.0)
    even = [-fan_deg + 2.0 * fan_deg * k / (rays - 1) for k in range(rays)]
    assert np.abs(sensor.offsets / 10.0 - even).max() <= 0.05 + 1e-9
    assert RangeSensor(1, fan_deg, 1.0).offsets.tolist() == [0]
