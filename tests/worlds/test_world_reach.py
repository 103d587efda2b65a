"""Reach, against a slow reference and independent libraries."""

from __future__ import annotations

import networkx as nx
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from scipy import ndimage
from skimage.measure import euler_number, label

from swarmscout.core.errors import WorldError
from swarmscout.worlds import World, reachable, world_from_array, world_from_ascii
from swarmscout.worlds.morphology import covered_by, fits
from swarmscout.worlds.reachability import distance_along_ground, standing_places, start_cell
from swarmscout.worlds.starts import start_of

rasters = arrays(
    np.uint8,
    st.tuples(st.integers(1, 14), st.integers(1, 14)),
    elements=st.sampled_from([0, 1, 1, 1, 1, 1]),
)
radii = st.sampled_from([0.05, 0.1, 0.15, 0.2, 0.33])


def brute_fits(free: np.ndarray, cell: float, radius: float) -> np.ndarray:
    """Distance from each cell's centre to each wall's square, one by one."""
    rows, cols = free.shape
    padded = np.zeros((rows + 12, cols + 12), dtype=int)
    padded[6:-6, 6:-6] = free
    walls = np.argwhere(padded == 0) - 6
    place = np.zeros(free.shape, dtype=bool)
    for row in range(rows):
        for col in range(cols):
            away = np.maximum(np.abs(walls - (row, col)) - 0.5, 0.0) * cell
            inside_wall = free[row, col] == 0
            nearest = np.hypot(away[:, 0], away[:, 1]).min()
            place[row, col] = not inside_wall and nearest >= radius - 1e-9
    return place


@given(rasters, radii)
def test_a_disc_fits_where_no_wall_square_is_nearer_than_its_radius(free, radius):
    np.testing.assert_array_equal(fits(free, 0.1, radius), brute_fits(free, 0.1, radius))


@given(rasters, radii)
def test_covered_is_what_lies_within_the_radius(centres, radius):
    marked = np.argwhere(centres)
    expected = np.zeros(centres.shape, dtype=bool)
    for cell in np.ndindex(centres.shape):
        if len(marked):
            away = np.hypot(*((marked - cell) * 0.1).T)
            expected[cell] = away.min() <= radius + 1e-9
    np.testing.assert_array_equal(covered_by(centres != 0, 0.1, radius), expected)


@given(rasters, st.data())
def test_reachable_against_a_graph_of_places(free, data):
    place = brute_fits(free, 0.1, 0.15)
    if not place.any():
        return
    row, col = data.draw(st.sampled_from([tuple(cell) for cell in np.argwhere(place)]))
    world = world_from_array(free, 0.1, start_m=((col + 0.5) * 0.1, (row + 0.5) * 0.1))
    graph = nx.grid_2d_graph(*free.shape)
    graph.remove_nodes_from([cell for cell in np.ndindex(free.shape) if not place[cell]])
    component = np.array(sorted(nx.node_connected_component(graph, (row, col))))
    expected = np.zeros(free.shape, dtype=np.uint8)
    for cell in np.argwhere(free):
        away = np.hypot(*((component - cell) * 0.1).T)
        expected[tuple(cell)] = away.min() <= 0.15 + 1e-9
    np.testing.assert_array_equal(reachable(world), expected)
    assert standing_places(world).sum() == len(component)
    assert start_cell(world) == (row, col)


@given(rasters, st.data())
def test_distance_reaches_exactly_the_connected_part_and_is_near_the_true_length(free, data):
    open_cells = free != 0
    if not open_cells.any():
        return
    source = data.draw(st.sampled_from([tuple(cell) for cell in np.argwhere(open_cells)]))
    steps = distance_along_ground(open_cells, [source])
    labels = label(open_cells, connectivity=1)
    reached = labels == labels[source]
    assert (steps[reached] >= 0).all()
    assert steps[source] == 0
    straight = np.hypot(*(np.argwhere(steps > 0) - source).T)
    # One step may be a diagonal one; from two on the octagon holds.
    assert (steps[steps > 0] >= straight / 1.12 - 0.5).all()


def test_distance_in_the_open_is_within_a_tenth_of_the_straight_line():
    steps = distance_along_ground(np.ones((201, 201), dtype=bool), [(100, 100)])
    straight = np.hypot(*np.mgrid[-100:101, -100:101])
    far = straight > 20
    ratio = steps[far] / straight[far]
    assert 0.89 < ratio.min() <= ratio.max() < 1.07


def test_a_gap_narrower_than_the_body_is_not_passed():
    free = np.ones((20, 41), dtype=np.uint8)
    free[:, 20] = 0
    free[8:10, 20] = 1  # 0.2 m, and the body has 0.3 m.
    narrow = world_from_array(free, 0.1, start_m=(0.55, 0.95))
    assert reachable(narrow)[:, 21:].sum() == 0
    free[8:11, 20] = 1
    wide = world_from_array(free, 0.1, start_m=(0.55, 0.95))
    assert reachable(wide)[:, 21:].sum() > 300


def test_reach_is_worked_out_once_per_world_and_read_only():
    world = world_from_ascii("####\n#S.#\n####")
    assert reachable(world) is reachable(world)
    with pytest.raises(ValueError, match="read-only"):
        reachable(world)[0, 0] = 1


@given(rasters)
def test_the_default_start_lies_in_the_largest_region(free):
    world = World("w", free, 0.1)
    place = fits(free, 0.1, 0.15)
    if not place.any():
        with pytest.raises(WorldError, match=r"no robot of 0\.3 m fits anywhere"):
            start_of(world)
        return
    labels, count = ndimage.label(place)
    own = labels[world.frame.cell_of(*start_of(world))]
    assert own > 0
    assert (labels == own).sum() == max((labels == k).sum() for k in range(1, count + 1))


def test_the_default_start_is_roomy():
    free = np.zeros((100, 200), dtype=np.uint8)
    free[45:55, 5:150] = 1
    free[20:80, 140:195] = 1
    x, y = start_of(World("w", free, 0.1))
    assert 16.0 < x < 18.0
    assert 4.5 < y < 5.5


def test_euler_number_sees_the_same_holes_before_and_after():
    world = world_from_ascii("#######\n#.....#\n#.#.#.#\n#S....#\n#######", pieces=5)
    assert euler_number(world.free, connectivity=1) == -1
    assert euler_number(reachable(world), connectivity=1) == -1


def test_no_robot_fits_at_the_start():
    world = world_from_array(np.ones((30, 30)) > 0, 0.1, start_m=(9.0, 9.0))
    with pytest.raises(WorldError, match=r"fits within 1 m of the start \(9.00, 9.00\)"):
        reachable(world)
