"""A world that no mission can start in says what is wrong."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from swarmscout.core.errors import WorldError
from swarmscout.worlds import World, check_world, world_from_array, world_from_ascii

HALL = "############\n#..........#\n#.S......C.#\n#..........#\n############"


@pytest.fixture
def hall() -> World:
    return world_from_ascii(HALL, 0.5, name="hall")


def test_a_sound_world_passes(hall):
    check_world(hall, 10)
    check_world(hall, 10, "spread")
    check_world(dataclasses.replace(hall, start_m=None, stations_m=None), 10)


SHAPE = (5, 12)


@pytest.mark.parametrize(
    ("changes", "says"),
    [
        ({"free": np.ones(SHAPE)}, "free is float64[5, 12], expected uint8[rows, cols]"),
        ({"free": np.ones(7, dtype=np.uint8)}, "free is uint8[7]"),
        ({"free": [[1]]}, "free is <class 'list'>"),
        ({"free": np.zeros(SHAPE, dtype=np.uint8)}, "nothing is free"),
        ({"free": np.zeros((0, 4), dtype=np.uint8)}, "nothing is free"),
        ({"free": np.full(SHAPE, 255, dtype=np.uint8)}, "free holds 255"),
        ({"resolution_m": 0.0}, "resolution_m = 0.0"),
        ({"resolution_m": float("nan")}, "resolution_m = nan"),
        ({"origin_m": (float("inf"), 0.0)}, "origin_m = (inf, 0.0)"),
        ({"start_m": (0.1, 0.1)}, "the start (0.1, 0.1) m is not free"),
        ({"start_m": (99.0, 0.1)}, "start (99, 0.1) m lies outside the world"),
        ({"start_m": (float("nan"), 0.1)}, "lies outside the world"),
        ({"stations_m": np.array([[0.1, 0.1]])}, "station 0 at (0.1, 0.1) m is in a wall"),
        ({"stations_m": np.array([[1.0, -3.0]])}, "station 0 (1, -3) m lies outside"),
        ({"stations_m": np.empty((0, 2))}, "stations_m has shape [0, 2]"),
        ({"ground_m": np.zeros((2, 2), dtype=np.float32)}, "ground_m is float32[2, 2]"),
        ({"ceiling_m": np.zeros(SHAPE)}, "ceiling_m is float64[5, 12]"),
        ({"ground_m": np.full(SHAPE, np.nan, dtype=np.float32)}, "ground_m[0, 0] = nan"),
    ],
)
def test_what_is_wrong(hall, changes, says):
    with pytest.raises(WorldError) as caught:
        check_world(dataclasses.replace(hall, **changes), 3)
    assert says in str(caught.value), str(caught.value)
    assert "\n" not in str(caught.value)
    assert "world 'hall'" in str(caught.value)


def test_a_ceiling_on_the_ground(hall):
    flat = np.zeros(SHAPE, dtype=np.float32)
    with pytest.raises(WorldError, match=r"cell \(1, 1\) the ceiling is on the ground"):
        check_world(dataclasses.replace(hall, ground_m=flat, ceiling_m=flat), 3)


def test_a_station_that_cannot_be_reached():
    world = world_from_ascii("########\n#S.##.C#\n########")
    with pytest.raises(WorldError, match=r"station 0 at .* cannot be reached from the start"):
        check_world(world, 1)


def test_a_start_that_is_too_small():
    world = world_from_ascii("####\n#S.#\n####", name="closet")
    with pytest.raises(WorldError, match="world 'closet' has room for"):
        check_world(world, 50)
    slit = world_from_array(np.eye(40, dtype=np.uint8), 0.1)
    with pytest.raises(WorldError, match=r"no robot of 0.3 m fits anywhere"):
        check_world(slit, 1)


def test_a_world_is_frozen_however_it_was_made():
    mine = np.ones(SHAPE, dtype=np.bool_, order="F")
    world = World("mine", mine, 1, (0, 0), (1, 2))
    assert world.free.dtype == np.uint8
    assert world.free.flags.c_contiguous
    assert not world.free.flags.writeable
    mine[0, 0] = False
    assert world.free[0, 0] == 1
    assert all(isinstance(part, float) for part in (*world.origin_m, *world.start_m))
