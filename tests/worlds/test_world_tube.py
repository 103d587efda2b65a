"""Generated tubes: valid for every seed, the same everywhere, with what was ordered."""

from __future__ import annotations

import dataclasses
import itertools

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import ndimage
from skimage.measure import label

from swarmscout.core.errors import WorldError
from swarmscout.core.streams import stream
from swarmscout.worlds import (
    TubeParameters,
    check_world,
    generate_tube,
    load_world,
    named_worlds,
    place_robots,
    reachable,
)
from swarmscout.worlds.catalogue import NAMED_TUBES
from swarmscout.worlds.tube_depth import OUTSIDE_M, ROUND_M, join_passage
from swarmscout.worlds.tube_maze import _gabriel_edges, _nodes
from swarmscout.worlds.tube_plan import plan_tube

SMALL = TubeParameters(
    size_m=60.0, length_m=90.0, width_m=5.0, braids=1, branches=3, branch_length_m=14.0,
    pillars=3, piles=5, resolution_m=0.2,
)  # fmt: skip
SMALL_WORLDS = [name for name in named_worlds() if name != "lava-network"]
DIGEST_LAVA_TUBE = "2428c47270e39e3615063d6b92a2bf37fabf14509765fd7163dd24b23b583104"


def islands(world, at_least_m2: float) -> int:
    """Blocks of rock that are closed in by free space."""
    labels = label(world.free == 0, connectivity=2, background=0)
    edge = {0, *labels[0], *labels[-1], *labels[:, 0], *labels[:, -1]}
    sizes = np.bincount(labels.ravel()) * world.resolution_m**2
    return sum(size >= at_least_m2 for k, size in enumerate(sizes) if k not in edge)


@pytest.mark.parametrize("name", SMALL_WORLDS)
@pytest.mark.parametrize("seed", [*range(8), 12345678901])
def test_named_worlds_are_good_for_any_seed(name, seed):
    # Half the resolution, to look at many: the plan is the same at every resolution.
    world = load_world(name, seed=seed, resolution_m=0.2)
    check_world(world, 100)
    area = reachable(world).sum() * world.resolution_m**2
    assert area >= (1500.0 if name != "lava-tube-small" else 600.0)
    assert area >= 0.85 * world.free.sum() * world.resolution_m**2
    assert 50.0 <= max(world.extent[1], world.extent[3]) <= 140.0
    assert world.start_m is not None


@pytest.mark.parametrize("name", SMALL_WORLDS)
def test_named_worlds_at_their_own_resolution(name):
    world = load_world(name)
    assert world.resolution_m == 0.1
    assert world.name == name
    check_world(world, 100)
    assert label(world.free, connectivity=1).max() == 1
    # A wall all round: no tube leaves the raster.
    border = np.concatenate([world.free[0], world.free[-1], world.free[:, 0], world.free[:, -1]])
    assert not border.any()


def test_lava_tube_has_the_size_that_missions_want():
    areas = [reachable(load_world("lava-tube", s, resolution_m=0.2)).sum() * 0.04 for s in range(4)]
    assert 2000.0 <= min(areas) <= max(areas) <= 3500.0


def test_the_same_seed_gives_the_same_world_and_another_another():
    one, two = generate_tube(SMALL), generate_tube(SMALL)
    np.testing.assert_array_equal(one.free, two.free)
    np.testing.assert_array_equal(one.ground_m, two.ground_m)
    np.testing.assert_array_equal(one.ceiling_m, two.ceiling_m)
    assert one.source["digest"] == two.digest
    assert generate_tube(dataclasses.replace(SMALL, seed=1)).digest != one.digest


def test_default_worlds_have_not_changed_by_accident():
    assert load_world("lava-tube").digest == DIGEST_LAVA_TUBE, "raise RULES in worlds/tube.py"


@pytest.mark.parametrize("seed", range(6))
def test_braids_rejoin(seed):
    base = TubeParameters(
        seed=seed, size_m=112.0, width_m=5.0, braids=5, branches=0, pillars=0, piles=0,
        resolution_m=0.2, winding=0.7,
    )  # fmt: skip
    braids = sum(passage.kind == "braid" for passage in plan_tube(base))
    assert braids >= 2
    assert islands(generate_tube(base), 10.0) >= braids
    none = generate_tube(dataclasses.replace(base, braids=0))
    assert islands(none, 10.0) == 0


def test_branches_are_blind_and_leave_the_trunk_as_it_is():
    none = plan_tube(dataclasses.replace(SMALL, branches=0))
    some = plan_tube(SMALL)
    assert len(some) > len(none)
    for one, two in zip(none, some, strict=False):
        np.testing.assert_array_equal(one.points_m, two.points_m)
    assert (
        islands(generate_tube(dataclasses.replace(SMALL, braids=0, pillars=0, piles=0)), 4.0) == 0
    )


def test_pillars_stand_in_wide_places():
    wide = dataclasses.replace(
        SMALL, width_m=9.0, narrowest_m=7.0, braids=0, branches=0, piles=0, pillars=0
    )
    pillared = generate_tube(dataclasses.replace(wide, pillars=10))
    assert islands(generate_tube(wide), 0.3) == 0
    assert islands(pillared, 0.3) >= 5


@pytest.mark.parametrize("seed", range(4))
def test_a_tube_is_as_wide_as_was_said(seed):
    parameters = dataclasses.replace(
        SMALL, seed=seed, braids=0, branches=0, pillars=0, piles=0, resolution_m=0.1
    )
    world = generate_tube(parameters)
    depth = ndimage.distance_transform_edt(world.free) * world.resolution_m
    trunk = plan_tube(parameters)[0].points_m
    shift = np.array(world.start_m) - trunk[4]
    rows, cols = world.frame.cells_of(trunk + shift).T
    assert depth[rows, cols].min() > 0.8
    assert depth.max() < 0.5 * parameters.widest_m + 1.5


def test_heights_are_plausible():
    world = load_world("lava-tube")
    assert world.ground_m is not None
    assert world.ceiling_m is not None
    free = world.free != 0
    gap = (world.ceiling_m - world.ground_m)[free]
    assert gap.min() >= 0.5
    assert 2.0 < np.quantile(gap, 0.9) < 6.0
    rise = np.hypot(*np.gradient(world.ground_m.astype(float), world.resolution_m))
    assert np.quantile(np.degrees(np.arctan(rise[free])), 0.95) < 30.0
    assert np.abs(world.ground_m[free]).max() < 5.0
    assert world.ground_m.dtype == world.ceiling_m.dtype == np.float32


@given(
    st.integers(0, 10**6), st.sampled_from(["tube", "maze"]), st.floats(3.0, 9.0),
    st.integers(0, 3), st.floats(0.0, 2.0),
)  # fmt: skip
def test_other_parameters_give_valid_worlds_too(seed, layout, width, few, winding):
    world = generate_tube(
        TubeParameters(
            seed=seed, layout=layout, size_m=45.0, length_m=50.0, width_m=width, narrowest_m=2.5,
            braids=few, branches=few, branch_length_m=10.0, pillars=few, piles=few,
            winding=winding, resolution_m=0.25,
        )
    )  # fmt: skip
    check_world(world, 20)
    assert reachable(world).sum() * 0.0625 >= 100.0


@pytest.mark.parametrize(
    ("name", "value", "says"),
    [
        ("size_m", 0.0, "size_m = 0.0: expected 30 to 1000"),
        ("length_m", float("nan"), "length_m = nan"),
        ("braids", -1, "braids = -1"),
        ("braids", 1.5, "expected a whole number"),
        ("seed", -1, "seed = -1"),
        ("width_m", 20.0, "expected narrowest_m = 3.2 to widest_m = 12"),
        ("layout", "mase", "did you mean 'maze'"),
        ("resolution_m", 0.001, "resolution_m = 0.001"),
        ("resolution_m", "fine", "expected a number"),
    ],
)
def test_impossible_parameters(name, value, says):
    with pytest.raises(WorldError) as caught:
        dataclasses.replace(TubeParameters(), **{name: value})
    assert says in str(caught.value)


def test_every_named_world_has_its_own_parameters():
    assert len({parameters for _, parameters in NAMED_TUBES.values()}) == len(NAMED_TUBES)


def test_the_network_has_room_for_twenty_thousand_robots():
    world = load_world("lava-network", seed=1)
    check_world(world, 20_000)
    assert len(place_robots(world, 20_000, "spread", np.random.default_rng(0))) == 20_000
    assert 130_000.0 <= reachable(world).sum() * world.resolution_m**2 <= 200_000.0


def test_the_net_joins_two_points_without_a_third_between_them():
    nodes = _nodes(stream(5, "test"), TubeParameters(layout="maze", size_m=150.0, width_m=5.0))
    edges = []
    for one, other in itertools.combinations(range(len(nodes)), 2):
        middle = (nodes[one] + nodes[other]) / 2
        radius2 = ((nodes[one] - middle) ** 2).sum()
        if not (((nodes - middle) ** 2).sum(axis=1) < radius2 - 1e-6).any():
            edges.append((one, other))
    assert _gabriel_edges(nodes) == edges
    assert len(nodes) > 30


def test_tubes_are_joined_with_a_rounded_corner():
    one, other = np.random.default_rng(3).uniform(OUTSIDE_M, 6.0, size=(2, 40, 50))
    blend = np.maximum(ROUND_M - np.abs(one - other), 0.0)
    expected = np.maximum(one, other) + blend * blend / (4.0 * ROUND_M)
    join_passage(one, other)
    np.testing.assert_array_equal(one, expected)
