"""Exact sensing: rays against triangles, checked by brute force and against the raster."""

from __future__ import annotations

import dataclasses
import gc
import math
import weakref

import numpy as np
import pytest
from cave_meshes import extruded
from hypothesis import given, settings
from hypothesis import strategies as st

from swarmscout.core.errors import SensorError
from swarmscout.robots.bodies import TICKS, heading_table, place_bodies, to_ticks
from swarmscout.robots.sensors.fan import Fan
from swarmscout.robots.sensors.mesh_rays import bucket_triangles, cast_rays_at_mesh, mesh_ranges
from swarmscout.worlds import Mesh, load_world, world_from_array, world_from_ascii
from swarmscout.worlds.reachability import standing_places

TABLE = heading_table()


def scan(mesh, position, footing, heading, offsets, *, range_m=1.0, height_m=0.0, alive=True):
    position = np.atleast_2d(np.asarray(position, dtype=np.float64))
    robots = len(position)
    plane = np.atleast_2d(np.asarray(footing, dtype=float)) + np.array([height_m, 0.0, 0.0])
    ways = TABLE[np.tile((heading + np.asarray(offsets)) % TICKS, (robots, 1))]
    ranges = np.full((robots, len(offsets)), np.nan)
    buckets = bucket_triangles(mesh)
    cast_rays_at_mesh(
        buckets.corners, buckets.frame, buckets.first, buckets.entries,
        position, plane, np.full(robots, alive), ways, range_m, ranges,
    )  # fmt: skip
    return ranges


def brute_force(mesh, start, direction, longest):
    """The first triangle's plane met inside the triangle, all triangles at once, by areas."""
    a, b, c = (mesh.vertices_m[mesh.triangles[:, k]].astype(np.float64) for k in range(3))
    normal = np.cross(b - a, c - a)
    with np.errstate(divide="ignore", invalid="ignore"):
        t = ((a - start) * normal).sum(axis=1) / (normal @ direction)
        at = start + t[:, None] * direction
        whole = (normal * normal).sum(axis=1)
        inside = np.ones(len(a), dtype=bool)
        depth = np.full(len(a), np.inf)
        for p, q in ((a, b), (b, c), (c, a)):
            share = (np.cross(q - p, at - p) * normal).sum(axis=1) / whole
            inside &= share >= 0.0
            depth = np.minimum(depth, np.abs(share))
    hit = inside & (t >= 0.0) & (t <= longest)
    # Rays through an edge, or along a triangle, may be called either way.
    doubtful = (depth < 1e-6) | (np.abs(t) < 1e-6) | (np.abs(t - longest) < 1e-6) | ~np.isfinite(t)
    return (t[hit].min() if hit.any() else math.inf), bool(doubtful.any())


coordinates = st.floats(-3.0, 3.0, width=32)


@settings(max_examples=150, deadline=None)
@given(
    st.lists(st.tuples(*[coordinates] * 9), min_size=1, max_size=12),
    st.tuples(coordinates, coordinates, st.floats(-1.0, 1.0)),
    st.tuples(st.floats(-0.6, 0.6), st.floats(-0.6, 0.6)),
    st.integers(0, 3599),
    st.sampled_from([0.3, 1.0, 4.0]),
)
def test_rays_meet_what_brute_force_finds(soup, start, slopes, heading, range_m):
    mesh = Mesh(
        np.array(soup, dtype=np.float32).reshape(-1, 3), np.arange(3 * len(soup)).reshape(-1, 3)
    )
    x, y, z = start
    offsets = [0, 700, 1800, 2900]
    measured = scan(mesh, (x, y), (z, *slopes), heading, offsets, range_m=range_m)[0]
    for offset, got in zip(offsets, measured, strict=True):
        dx, dy = TABLE[(heading + offset) % 3600]
        direction = np.array([dx, dy, slopes[0] * dx + slopes[1] * dy])
        expected, doubtful = brute_force(mesh, np.array([x, y, z]), direction, range_m)
        if not doubtful:
            assert got == pytest.approx(expected, abs=1e-6)


@pytest.mark.parametrize("range_m", [1.0, 6.0])
def test_upright_walls_on_a_flat_floor_scan_as_the_raster_does(range_m):
    world = load_world("lava-tube-small", seed=2, resolution_m=0.25)
    mesh = extruded(world)
    places = world.frame.centres_of(np.argwhere(standing_places(world)))
    rng = np.random.default_rng(0)
    position = places[rng.integers(len(places), size=400)] + rng.uniform(-0.09, 0.09, (400, 2))
    on_raster, on_mesh = (
        Fan(range_m=range_m, sensing=sensing, height_m=0.15) for sensing in ("raster", "mesh")
    )
    world = dataclasses.replace(world, mesh=mesh, ground_m=None)
    for heading in (0, 777, 2000):
        bodies = place_bodies(position, np.full(400, heading), np.ones(400))
        on_raster_m, on_mesh_m = (s.scan(bodies, world, 3).ranges for s in (on_raster, on_mesh))
        # A wall at the very end of the range may count or not.
        both = np.isfinite(on_mesh_m) & np.isfinite(on_raster_m)
        one = np.isfinite(on_mesh_m) != np.isfinite(on_raster_m)
        np.testing.assert_allclose(on_mesh_m[both], on_raster_m[both], atol=1e-5)
        assert one.sum() <= 2
        assert both.mean() > 0.1


def test_a_ray_between_neighbouring_triangles_slips_through_nowhere():
    # A fan of triangles round a corner, and rays through it and along its edges.
    angles = np.linspace(0.0, 2.0 * math.pi, 37)[:-1]
    rim = np.column_stack([np.ones(36), 0.3 * np.cos(angles), 0.3 * np.sin(angles)])
    vertices = np.vstack([[1.0, 0.0, 0.0], rim]).astype(np.float32)
    fan = [[0, 1 + k, 1 + (k + 1) % 36] for k in range(36)]
    mesh = Mesh(vertices, fan)
    places = [(0.0, y, z) for y in np.linspace(-0.2, 0.2, 41) for z in np.linspace(-0.2, 0.2, 41)]
    for x, y, z in places:
        assert scan(mesh, (x, y), (z, 0.0, 0.0), 0, [0], range_m=2.0)[0, 0] == pytest.approx(1.0)


def test_the_fan_tilts_with_the_ground_and_ranges_are_horizontal():
    # An upright wall 0.8 m ahead; the floor rises by half a metre per metre.
    wall = Mesh([[0.8, -2, -3], [0.8, 2, -3], [0.8, 0, 5]], [[0, 1, 2]])
    straight, aside = scan(wall, (0, 0), (0.0, 0.5, 0.0), 0, [0, to_ticks(30)])[0]
    assert straight == pytest.approx(0.8)
    assert aside == pytest.approx(0.8 / math.cos(math.radians(30)))
    # A level ray would meet this ramp; a robot that stands on it sees along it.
    ramp = Mesh([[-5, -5, -2.5], [5, -5, 2.5], [5, 5, 2.5], [-5, 5, -2.5]], [[0, 1, 2], [0, 2, 3]])
    level = scan(ramp, (0, 0), (0.0, 0.0, 0.0), 0, [0], height_m=0.15)[0, 0]
    tilted = scan(ramp, (0, 0), (0.0, 0.5, 0.0), 0, [0], height_m=0.15)[0, 0]
    assert level == pytest.approx(0.3)
    assert tilted == math.inf


def test_the_dead_see_nothing_and_a_mesh_of_nothing_is_never_met():
    nothing = Mesh(np.zeros((0, 3)), np.zeros((0, 3)))
    assert scan(nothing, (0, 0), (0, 0, 0), 0, [0, 100]).tolist() == [[math.inf, math.inf]]
    world = world_from_ascii("###\n#S#\n###")
    mesh = extruded(world)
    assert np.isfinite(scan(mesh, (0.75, 0.75), (0, 0, 0), 0, [0], height_m=0.1)).all()
    dead = scan(mesh, (0.75, 0.75), (0, 0, 0), 0, [0], height_m=0.1, alive=False)
    assert dead[0, 0] == math.inf


def test_a_mesh_is_sorted_once_and_forgotten_with_it():
    mesh = extruded(world_from_ascii("###\n#S#\n###"))
    buckets = weakref.ref(bucket_triangles(mesh))
    assert bucket_triangles(mesh) is buckets()
    del mesh
    gc.collect()
    assert buckets() is None


def test_ranges_follow_the_ground_and_a_world_without_a_mesh_is_refused():
    ground = np.tile(np.linspace(0.0, 2.0, 40, dtype=np.float32), (40, 1))
    wall = Mesh([[3.0, -2, -3], [3.0, 6, -3], [3.0, 2, 9]], [[0, 1, 2]])
    bare = world_from_array(np.ones((40, 40), dtype=np.uint8), ground_m=ground)
    world = dataclasses.replace(bare, mesh=wall)
    bodies = place_bodies(np.array([[2.0, 2.0]]), np.array([0]), np.ones(1))
    ahead = np.array([0, 1800])
    assert mesh_ranges(bodies, world, ahead, 5.0, 0.2)[0] == pytest.approx([1.0, np.inf])
    with pytest.raises(SensorError, match="has no mesh"):
        mesh_ranges(bodies, bare, ahead, 5.0, 0.2)
