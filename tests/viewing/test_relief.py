"""The relief shows the world as it is."""

from __future__ import annotations

import numpy as np

from swarmscout.viewing.relief import RIM_M, relief_of
from swarmscout.worlds import World, load_world


def test_floor_and_rock_of_a_cave():
    world = load_world("lava-tube-small", seed=2)
    relief = relief_of(world)
    height = relief.height_m()
    rng = np.random.default_rng(0)
    rows, cols = np.nonzero(world.free)
    some = rng.integers(0, len(rows), 400)
    points = world.frame.centres_of(np.column_stack([rows[some], cols[some]]))
    cells = relief.frame.cells_of(points)
    inside = relief.open_share[cells[:, 0], cells[:, 1]]
    assert (inside > 0).all()
    well_inside = inside > 0.95
    true = world.ground_m[rows[some], cols[some]]
    assert np.abs(relief.ground_at(points) - true)[well_inside].max() < 0.35
    assert np.allclose(
        height[cells[:, 0], cells[:, 1]][well_inside], relief.ground_at(points)[well_inside]
    )
    rock = relief.shown & (relief.open_share == 0)
    assert np.allclose(height[rock], relief.ground_m[rock] + relief.wall_m)
    # The rim is narrow, and nothing open is left out.
    assert relief.shown[relief.open_share > 0.5].all()
    assert rock.sum() * relief.frame.cell_m**2 < 2.5 * RIM_M * 2 * 400


def test_a_flat_map_has_a_flat_floor():
    free = np.zeros((40, 60), dtype=np.uint8)
    free[10:30, 10:50] = 1
    relief = relief_of(World("room", free, 0.1, origin_m=(5.0, -3.0)))
    assert (relief.ground_m == 0).all()
    assert relief.open_share.max() == 1.0
    area = relief.open_share.sum() * relief.frame.cell_m**2
    assert abs(area - 2.0 * 4.0) < 1e-6
    left, right, bottom, top = relief.frame.extent
    assert left <= 5.0 - RIM_M < right
    assert bottom <= -3.0 - RIM_M < top


def test_a_large_world_is_shown_coarser():
    free = np.ones((1500, 2000), dtype=np.uint8)
    relief = relief_of(World("plain", free, 0.1))
    assert relief.frame.size < 200_000
