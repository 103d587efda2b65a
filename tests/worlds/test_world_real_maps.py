"""Maps that others made; they are not shipped."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np
import pytest

from swarmscout.worlds import check_world, load_world, place_robots, reachable

FOLDER = os.environ.get("SWARMSCOUT_EXTRA_WORLDS") or None
pytestmark = pytest.mark.skipif(
    FOLDER is None, reason="SWARMSCOUT_EXTRA_WORLDS does not name a folder with real maps"
)


@pytest.mark.parametrize(
    ("file", "options", "shape", "least_m2", "most_m2"),
    [
        ("maps2d/nav2/depot.yaml", {}, (307, 604), 400, 450),
        ("maps2d/nav2/warehouse.yaml", {}, (1674, 1006), 1200, 1300),
        ("maps2d/nav2/warehouse.yaml", {"resolution_m": 0.1}, (502, 301), 1150, 1272),
        # Passable cells of the file, at 0.25 m² each, are the most there can be.
        ("maps2d/movingai/den520d.map", {}, (1285, 1280), 7000, 28178 / 4),
        ("maps2d/movingai/room-64-64-8.map", {}, (320, 320), 700, 3232 / 4),
        ("maps2d/movingai/w_woundedcoast.map", {}, (2890, 3210), 8000, 34020 / 4),
        ("maps2d/dungeon/img_1.png", {"cell_m": 0.1}, (480, 640), 850, 870),
        ("maps2d/dungeon/img_1.png", {"cell_m": 0.4}, (1920, 2560), 13500, 13900),
    ],
)
def test_real_maps(file, options, shape, least_m2, most_m2):
    world = load_world(file, base=Path(str(FOLDER)), **options)
    assert world.free.shape == shape
    area = reachable(world).sum() * world.resolution_m**2
    assert least_m2 <= area <= most_m2 + 1e-6
    check_world(world, 100)
    rng = np.random.default_rng(0)
    assert len(place_robots(world, 100, "one-place", rng)) == 100
    assert len(place_robots(world, 100, "spread", rng)) == 100


def test_depot_lies_where_its_yaml_says():
    world = load_world("maps2d/nav2/depot.yaml", base=Path(str(FOLDER)))
    assert world.origin_m == (-7.14, -7.83)
    assert world.extent == pytest.approx((-7.14, -7.14 + 30.2, -7.83, -7.83 + 15.35))
