"""How bodies stand: planes, pitch and roll, and places that are too steep."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from swarmscout.worlds import load_world, reachable, world_from_array
from swarmscout.worlds.ground_plane import pitch_and_roll, stand, without_steep


def slope(along_x: float, along_y: float, *, size: int = 30, res: float = 0.1, base: float = 3.0):
    at = (np.arange(size) + 0.5) * res
    ground = base + along_x * at[None, :] + along_y * at[:, None]
    return world_from_array(
        np.ones((size, size), dtype=np.uint8), res, ground_m=ground.astype(np.float32)
    )


slopes = st.floats(-1.5, 1.5)


@given(slopes, slopes, st.floats(0.3, 2.7), st.floats(0.3, 2.7), st.sampled_from([0.05, 0.15, 0.4]))
def test_on_a_plane_the_plane_is_found(a, b, x, y, radius_m):
    (found,) = stand(slope(a, b), np.array([[x, y]]), radius_m)
    assert found == pytest.approx([3.0 + a * x + b * y, a, b], abs=1e-4)


def test_at_a_corner_and_on_a_line_of_free_cells():
    free = np.zeros((5, 5), dtype=np.uint8)
    free[2, :] = 1
    ground = np.tile(np.linspace(0, 1, 5, dtype=np.float32), (5, 1))
    ground[free == 0] = 99.0  # What is under rock does not matter.
    world = world_from_array(free, 0.1, ground_m=ground)
    (found,) = stand(world, np.array([[0.25, 0.25]]), 0.15)
    assert found == pytest.approx([0.5, 0.0, 0.0], abs=1e-6)
    assert stand(world, np.array([[0.02, 0.48]]), 0.05)[0].tolist() == [99.0, 0.0, 0.0]
    assert stand(world_from_array(free), np.array([[0.25, 0.25]]), 0.15).tolist() == [[0, 0, 0]]


@given(slopes, slopes, st.floats(-math.pi, math.pi))
def test_pitch_and_roll_turn_the_body_onto_the_ground(a, b, heading):
    pitch, roll = pitch_and_roll(np.array([[0.0, a, b]]), np.array([heading]))
    turned = Rotation.from_euler("ZYX", [heading, pitch[0], roll[0]])
    up = np.array([-a, -b, 1.0])
    assert turned.apply([0.0, 0.0, 1.0]) == pytest.approx(up / np.linalg.norm(up), abs=1e-9)
    ahead = turned.apply([1.0, 0.0, 0.0])
    assert math.atan2(ahead[1], ahead[0]) == pytest.approx(heading, abs=1e-9)


def test_nose_down_is_positive_pitch_and_left_up_is_positive_roll():
    uphill = pitch_and_roll(np.array([[0.0, 0.5, 0.0]]), np.array([0.0]))
    assert uphill[0][0] == pytest.approx(-math.atan(0.5))
    assert uphill[1][0] == pytest.approx(0.0)
    left_up = pitch_and_roll(np.array([[0.0, 0.0, 0.5]]), np.array([0.0]))
    assert left_up[1][0] == pytest.approx(math.atan(0.5))


def test_what_is_too_steep_is_no_longer_free():
    ramp = slope(math.tan(math.radians(35)), 0.0)
    assert without_steep(ramp, 36.0, 0.15) is ramp
    assert without_steep(ramp, 90.0, 0.15) is ramp
    assert not without_steep(ramp, 34.0, 0.15).free.any()
    flat = world_from_array(np.ones((4, 4), dtype=np.uint8))
    assert without_steep(flat, 5.0, 0.15) is flat


def test_a_steep_bank_cuts_a_world_in_two():
    free = np.ones((20, 60), dtype=np.uint8)
    x = (np.arange(60) + 0.5) * 0.1
    bank = np.interp(x, [2.5, 3.5], [0.0, 1.0])  # 45 degrees, a metre long.
    ground = np.tile(bank.astype(np.float32), (20, 1))
    world = world_from_array(free, start_m=(1.0, 1.0), ground_m=ground)
    assert reachable(without_steep(world, 50.0, 0.15)).mean() > 0.95
    cut = without_steep(world, 40.0, 0.15)
    assert without_steep(world, 40.0, 0.15) is cut
    assert reachable(cut).nonzero()[1].max() < 27
    assert world.free.all()


def test_the_package_s_own_tubes_are_driven_almost_everywhere_by_default():
    for seed in (0, 1):
        world = load_world("lava-tube-small", seed)
        lost = world.free.sum() - without_steep(world, 45.0, 0.15).free.sum()
        assert lost <= 5
