"""Each sensor of the package against rooms measured by hand and against brute force."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest
from cave_meshes import extruded
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from test_ray_casting import free_places, nearest_wall, random_world, wall_corners

from swarmscout.core.errors import SensorError
from swarmscout.core.streams import stream
from swarmscout.robots.bodies import TICKS, Bodies, place_bodies
from swarmscout.robots.noise import Noise
from swarmscout.robots.sensors.cone import Cone
from swarmscout.robots.sensors.fan import Fan
from swarmscout.robots.sensors.lidar import Lidar
from swarmscout.robots.sensors.registry import SENSORS
from swarmscout.worlds import world_from_ascii
from swarmscout.worlds.world import World

ROOM = World("room", np.ones((40, 60), dtype=np.uint8), 0.1, (-1.0, 2.0))  # x to 5, y to 6


def bodies_at(*poses: tuple[float, float, float], seed: int = 0) -> Bodies:
    at = np.array(poses)
    heading = np.rint(at[:, 2] * 10).astype(np.int64)
    return place_bodies(at[:, :2].copy(), heading, np.ones(len(at)), seed=seed)


def to_the_walls_of_the_room(x: float, y: float, angle: float) -> float:
    """Distance to the room's walls along a direction, from its four equations."""
    dx, dy = math.cos(angle), math.sin(angle)
    ways = [
        (side - at) / part
        for at, part, sides in ((x, dx, (-1.0, 5.0)), (y, dy, (2.0, 6.0)))
        for side in sides
        if abs(part) > 1e-12 and (side - at) / part >= 0.0
    ]
    return min(ways)


@pytest.mark.parametrize("sensing", ["raster", "mesh"])
def test_a_lidar_measures_a_room_all_around(sensing: str) -> None:
    walled = World("walled", np.pad(ROOM.free, 3), 0.1, (-1.3, 1.7))
    world = dataclasses.replace(walled, mesh=extruded(walled))
    lidar = Lidar(noise_m=0.0, sensing=sensing)
    bodies = bodies_at((0.23, 3.1, 0.0), (4.0, 5.5, 77.7))
    scan = lidar.scan(bodies, world, 1)
    assert scan.ranges.shape == (2, 360)
    for i, (x, y, heading) in enumerate(((0.23, 3.1, 0.0), (4.0, 5.5, 77.7))):
        expected = [
            to_the_walls_of_the_room(x, y, math.radians(heading + ray)) for ray in range(360)
        ]
        assert scan.ranges[i] == pytest.approx(expected, abs=1e-5)


@given(st.integers(1, 3600))
def test_no_two_rays_of_a_lidar_point_the_same_way(rays: int) -> None:
    directions = Lidar(rays=rays, noise_m=0.0).scan(bodies_at((1, 3, 0)), ROOM, 1).directions
    assert len(np.unique(directions % TICKS)) == rays
    assert directions[0] == 0
    gaps = np.diff(np.append(directions, TICKS))
    assert gaps.min() >= math.floor(TICKS / rays)
    assert gaps.max() <= math.ceil(TICKS / rays)


@given(st.integers(2, 360))
def test_a_fan_of_180_degrees_is_a_circle_without_a_doubled_ray(rays: int) -> None:
    directions = Fan(rays=rays, fan_deg=180).scan(bodies_at((1, 3, 0)), ROOM, 1).directions
    assert len(np.unique(directions % TICKS)) == rays


@settings(max_examples=100)
@given(
    seed=st.integers(0, 2**32 - 1),
    walls=st.sampled_from([0.02, 0.1, 0.3]),
    opening_deg=st.floats(1.0, 180.0),
    range_m=st.floats(0.3, 3.0),
)
def test_a_cone_measures_the_nearest_wall_in_it(
    seed: int, walls: float, opening_deg: float, range_m: float
) -> None:
    rng = np.random.default_rng(seed)
    world = random_world(rng, 20, 20, 0.1, walls)
    position = free_places(rng, world, 3)
    bodies = place_bodies(position, rng.integers(0, TICKS, 3), np.ones(3))
    cone = Cone(noise_m=0.0, opening_deg=opening_deg, range_m=range_m)
    scan = cone.scan(bodies, world, 1)
    assert scan.ranges.shape == (3, 1)
    assert scan.opening == round(10 * opening_deg)
    corners = wall_corners(world, range_m)
    for i in range(3):
        # Rays point in whole ticks: the cone may be a little wider or narrower than asked.
        facing = 2.0 * math.pi * bodies.heading[i] / TICKS
        half = math.radians(opening_deg) / 2.0
        soonest, latest = (
            nearest_in_cone(corners, position[i], facing, max(0.0, half + more))
            for more in (0.002, -0.002)
        )
        measured = scan.ranges[i, 0]
        assert measured >= soonest - 1e-9
        # Neighbouring rays are so close that each wall cell in the cone stops at least one.
        assert measured <= latest + 0.15 or latest > range_m - 0.15


def nearest_in_cone(
    corners: NDArray[np.float64], at: NDArray[np.float64], facing: float, half: float
) -> float:
    """Distance to the nearest point of any wall cell of 0.1 m in a cone: inside, or on a side."""
    nearest = np.clip(at, corners, corners + 0.1) - at
    off = np.angle(np.exp(1j * (np.arctan2(nearest[:, 1], nearest[:, 0]) - facing)))
    inside = np.hypot(*nearest[np.abs(off) <= half].T)
    sides = (nearest_wall(corners, 0.1, at, facing + sign * half, 0.0) for sign in (-1, 1))
    return min(float(inside.min()) if len(inside) else np.inf, *sides)


def test_a_cone_sees_a_post_that_a_ray_misses() -> None:
    free = ROOM.free.copy()
    free[14, 30] = 0  # x 2.0 to 2.1, y 3.4 to 3.5
    world = World("post", free, 0.1, (-1.0, 2.0))
    bodies = bodies_at((1.0, 3.2, 0.0))
    keys = {"noise_m": 0.0, "range_m": 3.0}
    assert Fan(rays=1, **keys).scan(bodies, world, 1).ranges[0, 0] == np.inf
    wide = Cone(opening_deg=30.0, **keys).scan(bodies, world, 1).ranges[0, 0]
    assert wide == pytest.approx(math.hypot(1.0, 0.2), abs=0.02)
    assert Cone(opening_deg=10.0, **keys).scan(bodies, world, 1).ranges[0, 0] == np.inf


@pytest.mark.parametrize("name", ["fan", "lidar", "cone"])
def test_noise_has_its_deviation_and_belongs_to_seed_and_step(name: str) -> None:
    keys = {"range_m": 8.0, "noise_m": 0.05}
    sensor, exact = SENSORS.make(name, keys), SENSORS.make(name, {**keys, "noise_m": 0.0})
    places = [(2.0 + 0.01 * k, 4.0, 10.0 * k) for k in range(200)]
    bodies = bodies_at(*places, seed=5)
    true = exact.scan(bodies, ROOM, 3).ranges
    noise = [sensor.scan(bodies, ROOM, step).ranges - true for step in (3, 4, 3, 120, 51)]
    assert np.std(noise[0]) == pytest.approx(0.05, rel=0.15)
    assert abs(np.mean(noise[0])) < 0.02
    assert (noise[0] == noise[2]).all()
    assert (noise[0] != noise[1]).mean() > 0.99
    other = sensor.scan(dataclasses.replace(bodies, seed=6), ROOM, 3).ranges - true
    assert (noise[0] != other).mean() > 0.99


@pytest.mark.parametrize("shape", [(3, 9), (400, 360)])
def test_noise_is_the_same_in_any_order_of_steps(shape: tuple[int, int]) -> None:
    there = Noise("sensor")
    ahead = {step: there.at(1, shape, step).copy() for step in (0, 1, 2, 49, 50, 51)}
    back = Noise("sensor")
    for step in (51, 50, 2, 49, 1, 0):
        assert (back.at(1, shape, step) == ahead[step]).all()
    block = stream(1, "sensor", 0).standard_normal((3, *shape))
    assert (ahead[2] == block[2]).all()


@pytest.mark.parametrize(
    ("name", "keys", "says"),
    [
        ("lidar", {"rays": 0}, "sensor 'lidar': rays = 0: should be greater than or equal to 1"),
        ("lidar", {"fan_deg": 70}, "sensor 'lidar' has no parameter 'fan_deg'"),
        ("cone", {"opening_deg": 200.0}, "opening_deg = 200.0: should be less than or equal to"),
        ("fan", {"range_m": "far"}, "sensor 'fan': range_m = 'far': should be a valid number"),
        ("lidr", {}, "unknown sensor 'lidr': did you mean 'lidar'?"),
    ],
)
def test_parameters_are_checked(name: str, keys: dict[str, object], says: str) -> None:
    with pytest.raises(SensorError) as caught:
        SENSORS.make(name, keys)
    assert says in str(caught.value)
    assert "\n" not in str(caught.value)


def test_walls_all_around_are_met_at_once() -> None:
    world = world_from_ascii("###\n#S#\n###")
    edge = world.resolution_m
    scan = Lidar(rays=4, noise_m=0.0).scan(bodies_at((1.5 * edge, 1.5 * edge, 0.0)), world, 1)
    assert scan.ranges[0] == pytest.approx([0.5 * edge] * 4)
