"""Stations and starting places keep their distances, whatever the world."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import ndimage
from scipy.spatial.distance import pdist

from swarmscout.core.errors import WorldError
from swarmscout.core.grid import GridFrame
from swarmscout.worlds import (
    World,
    load_world,
    place_robots,
    place_stations,
    world_from_array,
    world_from_ascii,
)
from swarmscout.worlds.reachability import distance_along_ground, standing_places, start_cell
from swarmscout.worlds.spacing import take_apart

RULES = ("one-place", "spread")


def clearance(world: World, points: np.ndarray) -> float:
    """Least distance from discs' centres to wall squares; outside is wall."""
    pad = 5
    walls = np.argwhere(np.pad(world.free, pad) == 0) - pad
    low = np.array([world.origin_m[1], world.origin_m[0]]) + walls * world.resolution_m
    least = np.inf
    for x, y in points:
        away = np.maximum(np.maximum(low - (y, x), (y, x) - (low + world.resolution_m)), 0.0)
        least = min(least, float(np.hypot(away[:, 0], away[:, 1]).min()))
    return least


@pytest.fixture(scope="module")
def tube() -> World:
    return load_world("lava-tube-small")


@pytest.mark.parametrize("rule", RULES)
@pytest.mark.parametrize("robots", [1, 15, 100])
def test_no_overlap_and_clear_of_walls(tube, rule, robots):
    places = place_robots(tube, robots, rule, np.random.default_rng(1))
    assert places.shape == (robots, 2)
    assert places.dtype == np.float64
    assert clearance(tube, places) >= 0.2 - 1e-9
    if robots > 1:
        assert pdist(places).min() >= 0.6 - 1e-9
    cells = tube.frame.cells_of(places)
    assert standing_places(tube)[cells[:, 0], cells[:, 1]].all()


@given(
    st.integers(0, 2**32 - 1), st.sampled_from(RULES), st.sampled_from([0.1, 0.15, 0.3]),
    st.integers(1, 12),
)  # fmt: skip
def test_small_random_worlds(seed, rule, radius, robots):
    rng = np.random.default_rng(seed)
    rough = ndimage.gaussian_filter(rng.normal(size=(50, 60)), 4.0)
    world = world_from_array(rough > np.quantile(rough, 0.4), 0.1, origin_m=(-3.0, 2.0))
    try:
        places = place_robots(world, robots, rule, rng, radius)
    except WorldError as error:
        assert "room for" in str(error) or "fits" in str(error)  # noqa: PT017
        return
    assert clearance(world, places) >= radius + 0.05 - 1e-9
    if robots > 1:
        assert pdist(places).min() >= max(0.6, 2 * radius) - 1e-9


@pytest.mark.parametrize("rule", RULES)
def test_same_numbers_same_places(tube, rule):
    one = place_robots(tube, 20, rule, np.random.default_rng(5))
    two = place_robots(tube, 20, rule, np.random.default_rng(5))
    other = place_robots(tube, 20, rule, np.random.default_rng(6))
    np.testing.assert_array_equal(one, two)
    assert not np.array_equal(one, other)


def test_one_place_is_near_and_spread_is_not(tube):
    start = np.array(tube.start_m)
    near = place_robots(tube, 15, "one-place", np.random.default_rng(0))
    wide = place_robots(tube, 15, "spread", np.random.default_rng(0))
    assert np.hypot(*(near - start).T).max() < 3.0
    assert np.hypot(*(wide - start).T).max() > 15.0


def test_spread_takes_every_place_if_it_must():
    world = world_from_array(np.ones((13, 61), dtype=np.uint8), 0.1)
    counts = [len(place_robots(world, 5, "spread", np.random.default_rng(k))) for k in range(20)]
    assert counts == [5] * 20


def test_near_means_along_the_ground_not_through_a_wall():
    rows = ["#" * 60, "#" + "." * 58 + "#", "#" * 59 + ".#"[1:], "#S" + "." * 56 + "##", "#" * 60]
    rows[2] = "#" * 58 + ".#"
    rows[3] = "#S" + "." * 57 + "#"
    world = world_from_ascii("\n".join(rows), 0.5, pieces=5)
    places = place_robots(world, 10, "one-place", np.random.default_rng(0))
    assert (places[:, 1] < 1.0).all()


@pytest.mark.parametrize("rule", RULES)
def test_no_room_is_said_in_one_line(rule):
    world = world_from_ascii("######\n#S...#\n######", name="closet")
    with pytest.raises(WorldError, match=r"world 'closet' has room for \d robots") as caught:
        place_robots(world, 100, rule, np.random.default_rng(0))
    assert "\n" not in str(caught.value)
    assert "not for 100" in str(caught.value)


def test_unknown_rule_and_impossible_number(tube):
    rng = np.random.default_rng(0)
    with pytest.raises(WorldError, match="unknown start 'spred': did you mean 'spread'"):
        place_robots(tube, 3, "spred", rng)
    with pytest.raises(WorldError, match="robots = 0: expected at least 1"):
        place_robots(tube, 0, "spread", rng)


@pytest.mark.parametrize("robots", [1, 20, 21, 100])
def test_one_station_for_twenty_robots_or_for_each_ten_of_more(tube, robots):
    stations = place_stations(tube, robots)
    assert len(stations) == {1: 1, 20: 1, 21: 3, 100: 10}[robots]
    if len(stations) > 1:
        assert pdist(stations).min() >= 4.0 - 1e-9
    assert np.hypot(*(stations[0] - tube.start_m)) < 5.0
    cells = tube.frame.cells_of(stations)
    assert standing_places(tube)[cells[:, 0], cells[:, 1]].all()


def test_twenty_robots_find_room_at_a_station_and_leave_a_passage(tube):
    for x, y in place_stations(tube, 100):
        cells = np.argwhere(tube.free)
        centres = tube.frame.centres_of(cells)
        inside = np.hypot(*(centres - (x, y)).T) <= 1.5
        assert inside.sum() * tube.resolution_m**2 > 20 * 0.3**2 * 1.6
        # Take the whole disc away: what is left still hangs together.
        rest = tube.free.copy()
        rest[tuple(cells[np.hypot(*(centres - (x, y)).T) <= 1.5].T)] = 0
        labels, _ = ndimage.label(rest)
        sizes = np.bincount(labels.ravel())[1:]
        assert sizes.max() > 0.97 * rest.sum()


def test_all_who_start_from_one_place_are_within_reach_of_a_station(tube):
    places = place_robots(tube, 100, "one-place", np.random.default_rng(0))
    stations = place_stations(tube, 100)
    away = np.hypot(*(places[:, None] - stations[None]).transpose(2, 0, 1)).min(axis=1)
    assert away.max() < 6.0


def test_stations_set_by_hand_are_kept(tube):
    world = world_from_ascii("########\n#S....C#\n########")
    np.testing.assert_allclose(place_stations(world, 100), [[3.25, 0.75]])


def test_places_of_a_tight_world():
    world = world_from_ascii("###########\n#S........#\n###########", 0.5, pieces=5)
    stations = place_stations(world, 30)
    assert len(stations) == 3
    steps = distance_along_ground(standing_places(world), [start_cell(world)])
    assert steps.max() > 30


def test_a_thousand_robots(tube):
    world = load_world("lava-tube-wide")
    for rule in RULES:
        places = place_robots(world, 1000, rule, np.random.default_rng(0))
        assert pdist(places).min() >= 0.6 - 1e-9


@given(st.integers(0, 10**6), st.integers(1, 40), st.floats(0.1, 3.0), st.integers(1, 60))
def test_cells_are_taken_in_order_if_they_are_apart(seed, columns, spacing_m, wanted):
    frame = GridFrame(0.0, 0.0, 0.25, 30, columns)
    candidates = np.random.default_rng(seed).permutation(frame.size)
    slow: list[tuple[int, int]] = []
    for row, col in zip(*np.divmod(candidates, columns), strict=True):
        gaps = [(row - a) ** 2 + (col - b) ** 2 for a, b in slow]
        if len(slow) < wanted and min(gaps, default=1e9) >= (spacing_m / 0.25) ** 2 - 1e-9:
            slow.append((row, col))
    np.testing.assert_array_equal(take_apart(candidates, frame, spacing_m, wanted), slow)
