"""The tube in 3D: closed, the same every time, and the same cave as its 2.5-D world.

The oracle is brute force: every triangle near a ray is tried.
"""

from __future__ import annotations

import dataclasses
import hashlib
import math
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import ndimage
from scipy.spatial import Delaunay

from swarmscout.core import extras
from swarmscout.core.errors import WorldError
from swarmscout.worlds import TubeParameters, World, generate_tube, load_world, tube_mesh
from swarmscout.worlds.meshes import files, surfacing
from swarmscout.worlds.meshes import tube_mesh as tube_mesh_module
from swarmscout.worlds.meshes.mesh import Mesh

SMALL = TubeParameters(
    size_m=45.0, length_m=50.0, width_m=5.0, braids=1, branches=2, branch_length_m=10.0,
    pillars=3, piles=6,
)  # fmt: skip
TINY = dataclasses.replace(SMALL, size_m=32.0, length_m=25.0, branches=0, piles=3)
MAZE = dataclasses.replace(TINY, layout="maze", width_m=3.5, narrowest_m=2.5)
CAVES = {"tube": SMALL, "maze": MAZE, "low": dataclasses.replace(SMALL, seed=2, height_m=1.5)}
SENSOR_M, RANGE_M = 0.15, 1.0
HEIGHTS_LAVA_TUBE_SMALL = "891aac54c9bc7a8b86808327715a456f2cc81547736ccba74fff313a77016c61"


@pytest.fixture(scope="module", params=CAVES)
def cave(request) -> tuple[World, Mesh, TubeParameters]:
    parameters = CAVES[request.param]
    return generate_tube(parameters), tube_mesh(parameters), parameters


class Rays:
    """Distances to the first triangle, by trying all that are near."""

    def __init__(self, mesh: Mesh) -> None:
        self.corners = mesh.vertices_m[mesh.triangles].astype(float)
        self.low, self.high = self.corners.min(axis=1), self.corners.max(axis=1)

    def near(self, low, high):
        """Triangles whose box meets a box."""
        meets = np.ones(len(self.low), dtype=bool)
        for axis in range(len(low)):
            meets &= (self.low[:, axis] <= high[axis]) & (self.high[:, axis] >= low[axis])
        return self.corners[meets]

    @staticmethod
    def first_hits(corners, origin, directions):
        """Möller and Trumbore: float[rays], in lengths of the directions; inf for none."""
        one, side, other = corners[:, 0], *(corners[:, k] - corners[:, 0] for k in (1, 2))
        normal = np.cross(directions[:, None], other[None])
        area = (normal * side).sum(axis=2)
        with np.errstate(all="ignore"):
            away = origin - one
            u = (away * normal).sum(axis=2) / area
            turned = np.cross(away, side)
            v = (directions[:, None] * turned[None]).sum(axis=2) / area
            at = (other * turned).sum(axis=1)[None] / area
            hit = (u >= -1e-9) & (v >= -1e-9) & (u + v <= 1 + 1e-9) & (at > 1e-9)
        return np.where(hit, at, np.inf).min(axis=1, initial=np.inf)


def some_free_places(world: World, count: int, clear_m: float):
    room = ndimage.distance_transform_edt(world.free) * world.resolution_m
    rows, columns = np.nonzero(room > clear_m)
    chosen = np.random.default_rng(1).choice(len(rows), count)
    return rows[chosen], columns[chosen]


def check_closed(mesh: Mesh) -> None:
    """Each edge has two triangles that run along it in opposite ways."""
    ends = np.concatenate([mesh.triangles[:, [k, (k + 1) % 3]] for k in range(3)]).astype(np.int64)
    there = ends[:, 0] * len(mesh.vertices_m) + ends[:, 1]
    back = ends[:, 1] * len(mesh.vertices_m) + ends[:, 0]
    assert len(np.unique(there)) == len(there)
    np.testing.assert_array_equal(np.sort(there), np.sort(back))


def shells(mesh: Mesh) -> list[trimesh.Trimesh]:
    """The parts of a mesh, the largest first."""
    solid = trimesh.Trimesh(mesh.vertices_m, mesh.triangles, process=False)
    parts = solid.split(only_watertight=False)
    return sorted(parts, key=lambda part: -len(part.faces))


def test_a_tube_is_one_closed_surface_that_faces_its_inside(cave):
    _, mesh, _ = cave
    check_closed(mesh)
    tube, *blocks = shells(mesh)
    assert tube.is_watertight
    assert tube.is_winding_consistent
    assert tube.volume < -300.0
    assert tube.euler_number % 2 == 0, "two fans touch in a vertex"
    assert len(blocks) >= 5
    assert tube.area_faces.min() > 0.0


def test_breakdown_is_convex_boulders_no_pebbles(cave):
    _, mesh, _ = cave
    for block in shells(mesh)[1:]:
        assert block.is_watertight
        assert block.volume > 0.03
        assert block.is_convex
        assert np.ptp(block.vertices, axis=0)[:2].max() >= 0.4


def test_floor_and_ceiling_are_the_worlds(cave):
    world, mesh, _ = cave
    rays = Rays(mesh)
    rows, columns = some_free_places(world, 700, 0.0)
    floor_off, ceiling_off = [], []
    for row, col in zip(rows, columns, strict=True):
        x, y = (col + 0.5) * world.resolution_m, (row + 0.5) * world.resolution_m
        ground, ceiling = float(world.ground_m[row, col]), float(world.ceiling_m[row, col])
        middle = ground + 0.3 * (ceiling - ground)
        up_down = np.array([[0.0, 0.0, 1.0], [0.0, 0.0, -1.0]])
        near = rays.near((x, y), (x, y))
        above, below = rays.first_hits(near, np.array([x, y, middle]), up_down)
        floor_off.append(middle - below - ground)
        ceiling_off.append(middle + above - ceiling)
    assert np.isfinite(floor_off).all()
    assert np.isfinite(ceiling_off).all()
    assert np.mean(np.abs(floor_off) < 0.05) >= 0.97
    assert np.mean(np.abs(ceiling_off) < 0.1) >= 0.9
    assert abs(np.median(ceiling_off)) < 0.05


def test_a_sensor_sees_in_the_mesh_what_it_sees_in_the_raster(cave):
    world, mesh, _ = cave
    rays = Rays(mesh)
    rng = np.random.default_rng(2)
    edge = world.resolution_m
    smooth = ndimage.gaussian_filter(world.ground_m.astype(float), 1.0)
    slopes = np.gradient(smooth, edge)
    walked = np.arange(0.0, RANGE_M, 0.005)
    same, hits = [], 0
    for row, col in zip(*some_free_places(world, 400, 0.2), strict=True):
        x, y = (col + 0.5) * edge, (row + 0.5) * edge
        angles = rng.uniform(0.0, 2.0 * math.pi) + np.radians(np.linspace(-70.0, 70.0, 9))
        ways = np.column_stack((np.cos(angles), np.sin(angles)))
        # The fan lies in the plane that the robot stands on.
        rise = slopes[1][row, col] * ways[:, 0] + slopes[0][row, col] * ways[:, 1]
        origin = np.array([x, y, float(world.ground_m[row, col]) + SENSOR_M])
        near = rays.near((x - RANGE_M, y - RANGE_M), (x + RANGE_M, y + RANGE_M))
        mesh_m = rays.first_hits(near, origin, np.column_stack((ways, rise)))
        at = np.array([x, y]) + walked[None, :, None] * ways[:, None, :]
        cells = np.floor(at / edge).astype(int)
        wall = world.free[cells[..., 1], cells[..., 0]] == 0
        raster_m = np.where(wall.any(axis=1), walked[wall.argmax(axis=1)], np.inf)
        hit = raster_m < RANGE_M
        seen = mesh_m < RANGE_M
        off = np.abs(np.minimum(mesh_m, RANGE_M) - np.minimum(raster_m, RANGE_M))
        same += list((hit == seen) & (~hit | (off <= 0.1)))
        hits += int(hit.sum())
    assert hits >= 200
    assert np.mean(same) >= 0.97


def test_boulders_lie_where_the_raster_has_breakdown_and_nowhere_else(cave):
    world, mesh, parameters = cave
    fields = tube_mesh_module.tube_fields(parameters)
    edge = world.resolution_m
    piles = (fields.depth_m > 0.0) & (fields.rubble_m > 0.2) & (world.free == 0)
    covered = np.zeros(world.free.shape, dtype=bool)
    for block in shells(mesh)[1:]:
        low, high = (block.bounds[:, 1::-1] / edge).astype(int)
        rows, columns = np.mgrid[low[0] : high[0] + 1, low[1] : high[1] + 1].reshape(2, -1)
        # A sensor looks from the ground; below blocks the mesh's ground is lower than the pile's.
        base = fields.floor_m[rows, columns] + np.minimum(fields.rubble_m[rows, columns], 0.2)
        at = np.column_stack(((columns + 0.5) * edge, (rows + 0.5) * edge, base + SENSOR_M))
        within = Delaunay(block.vertices).find_simplex(at) >= 0
        covered[rows[within], columns[within]] = True
    assert covered[piles].mean() >= 0.85
    assert not covered[world.free != 0].any()


def test_the_same_parameters_give_the_same_mesh_on_any_number_of_threads():
    one = tube_mesh(TINY)
    with ThreadPoolExecutor(2) as pool:
        others = list(pool.map(tube_mesh, [TINY, dataclasses.replace(TINY, seed=1), TINY]))
    for other in (others[0], others[2]):
        assert one.vertices_m.tobytes() == other.vertices_m.tobytes()
        assert one.triangles.tobytes() == other.triangles.tobytes()
    assert others[1].vertices_m.tobytes() != one.vertices_m.tobytes()


def test_the_world_is_what_it_was_before_there_were_meshes():
    world = load_world("lava-tube-small")
    heights = hashlib.sha256(world.ground_m.tobytes() + world.ceiling_m.tobytes())
    assert heights.hexdigest() == HEIGHTS_LAVA_TUBE_SMALL


@pytest.mark.parametrize("count", [1, 3])
def test_skylights_are_open_at_their_upper_rims_and_nowhere_else(count):
    world, mesh = generate_tube(SMALL), tube_mesh(SMALL, skylights=count)
    tube = shells(mesh)[0]
    outline = tube.outline()
    rims = [tube.vertices[entity.points] for entity in outline.entities]
    assert len(rims) == count
    rays = Rays(mesh)
    closed_rays = Rays(tube_mesh(SMALL))
    for rim in rims:
        x, y = rim[:, :2].mean(axis=0)
        assert 1.2 <= np.ptp(rim[:, 0]) <= 9.0
        cell = int(y / world.resolution_m), int(x / world.resolution_m)
        assert world.free[cell]
        assert rim[:, 2].min() > float(world.ceiling_m[cell]) + 1.0
        eye = np.array([x, y, float(world.ground_m[cell]) + 0.3])
        up = np.array([[0.0, 0.0, 1.0]])
        assert np.isinf(rays.first_hits(rays.near((x, y), (x, y)), eye, up))[0]
        assert np.isfinite(closed_rays.first_hits(closed_rays.near((x, y), (x, y)), eye, up))[0]


@given(
    st.integers(0, 10**6), st.sampled_from(["tube", "maze"]), st.floats(2.5, 9.0),
    st.floats(1.0, 8.0), st.floats(0.0, 1.5), st.sampled_from([0.1, 0.25]),
    st.sampled_from([0.2, 0.27, 0.4]),
)  # fmt: skip
@settings(max_examples=12)
def test_any_tube_is_closed(seed, layout, width, height, roughness, cell, step):
    parameters = TubeParameters(
        seed=seed, layout=layout, size_m=32.0, length_m=25.0, width_m=width, narrowest_m=2.5,
        braids=1, branches=1, branch_length_m=10.0, pillars=3, piles=4, roughness_m=roughness,
        height_m=height, resolution_m=cell,
    )  # fmt: skip
    mesh = tube_mesh(parameters, mesh_resolution_m=step)
    check_closed(mesh)
    world = generate_tube(parameters)
    low, high = mesh.bounds_m
    left, right, bottom, top = world.extent
    assert left < low[0] < high[0] < right
    assert bottom < low[1] < high[1] < top


@pytest.mark.parametrize(
    ("options", "says"),
    [
        ({"mesh_resolution_m": 0.0}, "mesh_resolution_m = 0.0: expected 0.05 to 0.5"),
        ({"mesh_resolution_m": float("nan")}, "mesh_resolution_m = nan"),
        ({"skylights": -1}, "skylights = -1: expected 0 to 100"),
        ({"skylights": 1.5}, "expected a whole number"),
    ],
)
def test_impossible_meshes(options, says):
    with pytest.raises(WorldError) as caught:
        tube_mesh(SMALL, **options)
    assert says in str(caught.value)


def test_a_mesh_that_nobody_can_use_is_refused(monkeypatch):
    monkeypatch.setattr(surfacing, "_MOST_VERTICES", 5000)
    with pytest.raises(WorldError, match="more than 5,000 vertices: take a larger resolution"):
        tube_mesh(SMALL)


def test_without_the_extra_it_says_how_to_get_it(monkeypatch):
    monkeypatch.setattr(files, "find_spec", lambda package: None)
    with pytest.raises(WorldError, match=r"pip install -e '.*\[mesh\]'"):  # In a clone.
        tube_mesh(SMALL)
    monkeypatch.setattr(extras, "__file__", "/packages/swarmscout/core/extras.py")
    with pytest.raises(WorldError, match=r"pip install 'swarmscout\[mesh\]'"):
        tube_mesh(SMALL)
