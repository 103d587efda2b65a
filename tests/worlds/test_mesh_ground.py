"""The ground under a floor: the same, and about as quick, whatever the size of a cell."""

from __future__ import annotations

import numpy as np
import pytest

from swarmscout.worlds.meshes import ground as module
from swarmscout.worlds.meshes.ground import ground_under


def floor_of(cell_m):
    """6 m × 4 m that rise by 10 %, with a block of 0.5 m and fine roughness of 2 cm."""
    x, y = np.meshgrid(np.arange(cell_m / 2, 6, cell_m), np.arange(cell_m / 2, 4, cell_m))
    rough = np.random.default_rng(0).normal(0.0, 0.02, x.shape)
    block = (np.abs(x - 3.0) < 0.25) & (np.abs(y - 2.0) < 0.25)
    return np.float32(0.1 * x + rough + 0.6 * block), x, block


@pytest.mark.parametrize("cell_m", [0.1, 0.07, 0.05, 0.02])
def test_the_ground_does_not_depend_on_the_cell(cell_m):
    floor, x, block = floor_of(cell_m)
    found = ground_under(floor, cell_m)
    inner = (slice(round(1.0 / cell_m), -round(1.0 / cell_m)),) * 2
    np.testing.assert_array_equal(found.obstacle, block)
    assert not found.steep.any()
    # An opening lies under the roughness, but nowhere does the ground jump from cell to cell.
    assert np.abs(found.height_m - 0.1 * x)[inner].max() < 0.08
    slope = np.diff(found.height_m, axis=1)[inner] / cell_m
    assert slope.mean() == pytest.approx(0.1, abs=0.02)
    assert slope.std() < 0.03


@pytest.mark.parametrize("cell_m", [0.1, 0.05, 0.02, 0.01])
def test_a_cell_costs_the_same_at_any_size(cell_m):
    for radius_m in (0.3, 0.6, 0.9):
        many = len(module._disc(radius_m, cell_m))
        assert many <= 1.05 * len(module._disc(radius_m, 0.1))
