"""Missions whose rays meet the triangles of a mesh, and robots that slopes stop."""

from __future__ import annotations

import dataclasses

import numpy as np
import polars as pl
import pytest
from cave_meshes import extruded

from swarmscout import Mission, Run, ScenarioError, WorldError, explore, load_scenario
from swarmscout.robots.sensors.agreement import sensing_agreement
from swarmscout.worlds import Mesh, World, world_from_array, world_from_ascii

HALL = """
##################
#................#
#..S.....##......#
#........##......#
#................#
#....##..........#
#....##....C.....#
#................#
##################
"""


@pytest.fixture(scope="module")
def hall() -> World:
    world = world_from_ascii(HALL, name="hall")
    return dataclasses.replace(world, mesh=extruded(world))


def run(world: World, **changes: object) -> Mission:
    scenario = load_scenario("default", {"robots": 5, "steps": 60, "seed": 3, **changes})
    mission = Mission(scenario, world=world)
    mission.run()
    return mission


def test_upright_walls_give_the_same_mission_against_raster_and_mesh(hall):
    # Of the noise-free ranges none differs by more than float32's rounding, and noise is shared:
    # maps agree unless a ray meets the border of two map cells within that rounding.
    one, two = run(hall), run(hall, **{"sensor.sensing": "mesh"})
    assert two.explored_m2 == pytest.approx(one.explored_m2, rel=0.05)
    assert two.explored_m2 > 20.0
    again = run(hall, **{"sensor.sensing": "mesh"})
    np.testing.assert_array_equal(again.bodies.position, two.bodies.position)
    np.testing.assert_array_equal(again.map.log_odds, two.map.log_odds)


def test_what_only_the_mesh_has_is_mapped_by_exact_sensing_only(hall):
    # A slab that hangs 0.1 m above the floor, across the way.
    corners = [[4.0, 0.5, 0.1], [4.0, 4.0, 0.1], [4.0, 4.0, 0.6], [4.0, 0.5, 0.6]]
    slab = np.array(corners, dtype=np.float32)
    vertices = np.vstack([hall.mesh.vertices_m, slab])
    n = len(hall.mesh.vertices_m)
    triangles = np.vstack([hall.mesh.triangles, [[n, n + 1, n + 2], [n, n + 2, n + 3]]])
    world = dataclasses.replace(hall, mesh=Mesh(vertices, triangles))

    def sees_it(mission: Mission) -> bool:
        cells = mission.frame.cells_of(np.column_stack([np.full(7, 4.05), np.arange(0.75, 4, 0.5)]))
        return bool((mission.map.labels[cells[:, 0], cells[:, 1]] == 2).any())

    assert sees_it(run(world, **{"sensor.sensing": "mesh"}))
    assert not sees_it(run(world))
    # A sensor above the slab's upper edge looks over it.
    assert not sees_it(run(world, **{"sensor.sensing": "mesh", "sensor.height_m": 0.7}))


def test_a_world_without_a_mesh_says_what_to_do(hall):
    bare = dataclasses.replace(hall, mesh=None)
    with pytest.raises(
        ScenarioError, match=r"'sensor\.sensing' = 'mesh': world 'hall' has no mesh"
    ):
        run(bare, **{"sensor.sensing": "mesh"})
    with pytest.raises(WorldError, match="no mesh to compare"):
        sensing_agreement(bare)
    with pytest.raises(WorldError, match="scans = 0: expected 1 or more"):
        sensing_agreement(bare, scans=0)


def test_a_generated_tube_gets_its_mesh_made_and_runs_again(tmp_path):
    generated = {"world": "lava-tube-small", "world_seed": 5, "robots": 3, "steps": 15}
    run = explore(**generated, sensor={"sensing": "mesh"}, out=tmp_path / "run")
    assert not (tmp_path / "run" / "world").exists()  # The recipe is enough.
    mission = Mission(load_scenario(tmp_path / "run"))
    mission.run()
    last = run.steps.filter(pl.col("step") == 15).select("x_m", "y_m").to_numpy()
    np.testing.assert_array_equal(mission.bodies.position, last)


def test_agreement_is_whole_where_walls_are_upright_and_partial_where_they_are_not(hall):
    whole = sensing_agreement(hall, scans=500)
    assert whole.rays == 4500
    assert whole.hits > 0.999
    assert whole.alike > 0.999
    assert whole.walls_alike > 0.99
    assert 0.1 < whole.raster_hits < 0.9
    lower = dataclasses.replace(hall, mesh=extruded(hall, wall_m=0.1))
    none = sensing_agreement(lower, scans=500)
    assert none.mesh_hits == 0.0
    assert none.walls_alike == 0.0
    assert none.hits == pytest.approx(1.0 - none.raster_hits)


def test_robots_stay_off_what_is_too_steep_for_them():
    free = np.ones((60, 60), dtype=np.uint8)
    x = (np.arange(60) + 0.5) * 0.1
    ground = np.tile(np.interp(x, [3.0, 4.0], [0.0, 1.0]).astype(np.float32), (60, 1))
    world = world_from_array(free, start_m=(1.5, 3.0), ground_m=ground)
    easy = run(world, **{"body.slope_deg": 50.0, "steps": 150, "battery.enabled": False})
    hard = run(world, **{"body.slope_deg": 40.0, "steps": 150, "battery.enabled": False})
    assert easy.explored_m2 > 1.5 * hard.explored_m2
    assert hard.bodies.position[:, 0].max() < 3.2
    assert hard.world is world
    steep = dataclasses.replace(
        world, ground_m=world.ground_m + 2 * np.arange(60, dtype=np.float32)
    )
    with pytest.raises(WorldError, match=r"nothing is free.*'body\.slope_deg' = 45"):
        run(steep)


def test_a_run_keeps_the_mesh_that_its_rays_met_and_no_other(hall, tmp_path):
    for sensing in ("raster", "mesh"):
        folder = tmp_path / sensing
        changes = {"sensor": {"sensing": sensing}, "destinations": "nearest"}
        explore(world=hall, robots=3, steps=20, out=folder, **changes)
        kept = Run.open(folder).world().mesh
        assert (kept is not None) == (sensing == "mesh")
    mission = Mission(load_scenario(folder), base=folder)
    mission.run()
    last = Run.open(folder).steps.filter(pl.col("step") == mission.step_number)
    np.testing.assert_array_equal(mission.bodies.position, last.select("x_m", "y_m").to_numpy())


def test_a_run_knows_where_its_robots_stand_in_3d():
    free = np.ones((40, 40), dtype=np.uint8)
    ground = np.tile(np.linspace(0.0, 2.0, 40, dtype=np.float32), (40, 1))
    world = world_from_array(free, start_m=(2.0, 2.0), ground_m=ground)
    run = explore(world=world, robots=4, steps=30, destinations="random")
    poses = run.poses
    assert poses.columns[-4:] == ["z_m", "heading_rad", "pitch_rad", "roll_rad"]
    assert poses.height == run.steps.height
    rise = 2.0 / 39 / 0.1
    np.testing.assert_allclose(poses["z_m"], (poses["x_m"] - 0.05) * rise, atol=1e-4)
    np.testing.assert_allclose(
        np.tan(poses["pitch_rad"]), -rise * np.cos(poses["heading_rad"]), atol=1e-3
    )
