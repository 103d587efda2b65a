"""Every selector chooses what it chose before, and each term of its rule has its effect."""

from __future__ import annotations

import json
import math
from typing import Any

import numpy as np
import pytest
from golden_choices import FILE, choices
from hypothesis import given, settings
from hypothesis import strategies as st
from test_classic_rules import hall as any_hall

from swarmscout.core.enums import FREE, OCCUPIED, UNKNOWN
from swarmscout.destinations.hungarian import Hungarian
from swarmscout.destinations.information_gain import InformationGain
from swarmscout.destinations.llm_like import LlmLike
from swarmscout.destinations.minpos import MinPos
from swarmscout.destinations.multi_criteria import MultiCriteria
from swarmscout.destinations.nearest import Nearest
from swarmscout.destinations.nearest_euclidean import NearestEuclidean
from swarmscout.destinations.potential import Potential
from swarmscout.destinations.quantile_local import QuantileLocal
from swarmscout.destinations.registry import SELECTORS, make_selector
from swarmscout.destinations.selector import Selector
from swarmscout.destinations.utility import Utility
from swarmscout.destinations.view import LeaderView
from swarmscout.destinations.voronoi import Voronoi
from swarmscout.testing import leader_view, situations

Cell = tuple[int, int]

MIDDLE: Cell = (5, 15)
LEFT: Cell = (5, 5)
RIGHT: Cell = (5, 25)


@pytest.mark.parametrize("name", sorted(SELECTORS.built_in))
def test_choices_are_those_kept(name: str) -> None:
    assert choices(name) == json.loads(FILE.read_text(encoding="utf-8"))[name]


def hall(
    *more: tuple[Cell, int],
    leader: Cell = MIDDLE,
    members: tuple[Cell, ...] = (),
    others: tuple[tuple[Cell, Cell | None], ...] = (),
    seed: int = 0,
) -> LeaderView:
    """A hall, symmetric about its middle column, with an unknown cell on the left and the right.

    The leader looks to the right, as all robots do; `more` are cells and what they are instead.
    """
    labels = np.full((11, 31), OCCUPIED, dtype=np.uint8)
    labels[1:-1, 1:-1] = FREE
    labels[LEFT] = labels[RIGHT] = UNKNOWN
    for cell, label in more:
        labels[cell] = label
    return leader_view(labels, leader, members=members, others=others, seed=seed)


def side(rule: Selector, view: LeaderView, memory: Any = None) -> str:
    """On which side of the hall the chosen cell lies."""
    return "left" if rule.choose(view, memory).cell[1] < MIDDLE[1] else "right"


def only(**weights: float) -> MultiCriteria:
    """Multi-criteria with these terms alone."""
    none = dict.fromkeys(("way", "front", "turn_m", "near_gain", "open_gain", "wall", "apart"), 0.0)
    return MultiCriteria(**{**none, "ahead": 0.0, **weights})


LEFT_OF_MIDDLE: Cell = (5, 13)
RIGHT_OF_MIDDLE: Cell = (5, 17)
BESIDE_LEFT: Cell = (5, 8)
BESIDE_RIGHT: Cell = (5, 22)


def test_multi_criteria_way() -> None:
    for rule in (MultiCriteria(ahead=0.0, front=0.0), only(way=1.0)):
        assert side(rule, hall(leader=LEFT_OF_MIDDLE)) == "left"
        assert side(rule, hall(leader=RIGHT_OF_MIDDLE)) == "right"


def test_multi_criteria_front_counts_the_member_that_is_soonest_there() -> None:
    for rule in (only(front=1.0), MultiCriteria(turn_m=0.0)):
        assert side(rule, hall(members=(BESIDE_LEFT,))) == "left"
        assert side(rule, hall(members=(BESIDE_RIGHT,))) == "right"


def test_multi_criteria_turn() -> None:
    assert side(only(front=1.0, turn_m=2.0), hall()) == "right"
    # Looking to the right, 1 m farther costs less than an about-turn.
    assert side(only(front=1.0, turn_m=2.0), hall(leader=(5, 14))) == "right"
    assert side(only(front=1.0, turn_m=0.2), hall(leader=(5, 14))) == "left"
    assert side(MultiCriteria(), hall()) == "right"


def test_multi_criteria_gains() -> None:
    def wider(cell: Cell) -> tuple[tuple[Cell, int], ...]:
        return tuple(((cell[0] + off, cell[1]), UNKNOWN) for off in (1, 2))

    for rule in (only(near_gain=1.0), only(open_gain=1.0), MultiCriteria(turn_m=0.0)):
        assert side(rule, hall(*wider(LEFT))) == "left"
        assert side(rule, hall(*wider(RIGHT))) == "right"


def test_multi_criteria_near_gain_counts_within_a_metre_and_open_gain_within_open_m() -> None:
    # Two cells, 2.5 m off the right one's neighbourhood.
    far = (((1, 25), OCCUPIED), ((1, 26), UNKNOWN), ((1, 24), UNKNOWN))
    assert side(only(way=1.0), hall(leader=LEFT_OF_MIDDLE)) == "left"
    near, wide = only(near_gain=1.0), only(open_gain=1.0, open_m=2.63)
    view = hall(*far).among(np.abs(hall(*far).frontiers[:, 0] - 5) <= 1)
    assert side(near, view) == "left"  # A tie: the first cell.
    assert side(wide, view) == "right"
    assert side(only(open_gain=1.0, open_m=1.0), view) == "left"


def test_multi_criteria_walls_make_ground_less_open() -> None:
    def walled(cell: Cell) -> tuple[tuple[Cell, int], ...]:
        return tuple(((cell[0] + 3, cell[1] + off), OCCUPIED) for off in (-1, 0, 1))

    for rule in (only(open_gain=1.0, wall=5.2), MultiCriteria(turn_m=0.0)):
        assert side(rule, hall(*walled(LEFT))) == "right"
        assert side(rule, hall(*walled(RIGHT))) == "left"
    # What a wall takes away is what `wall` says: more unknown ground outweighs it when it is small.
    both = (*walled(RIGHT), ((6, 25), UNKNOWN))
    assert side(only(open_gain=1.0, wall=0.1), hall(*both)) == "right"
    assert side(only(open_gain=1.0, wall=5.2), hall(*both)) == "left"


def test_multi_criteria_keeps_off_the_destinations_of_others() -> None:
    at = (1, 15)
    for rule in (only(apart=1.0), MultiCriteria(turn_m=0.0)):
        assert side(rule, hall(others=((at, BESIDE_LEFT),))) == "right"
        assert side(rule, hall(others=((at, BESIDE_RIGHT),))) == "left"
    # Beyond apart_m a destination counts nothing, and neither does a team without one.
    ahead = only(apart=10.0, apart_m=1.0, ahead=1.0)
    assert side(ahead, hall(others=((at, (1, 25)),)), (1.0, 0.0)) == "right"
    assert side(ahead, hall(others=((RIGHT_OF_MIDDLE, None),)), (1.0, 0.0)) == "right"


def test_multi_criteria_goes_on_ahead() -> None:
    for rule in (only(ahead=1.0), MultiCriteria(turn_m=0.0)):
        assert side(rule, hall(), (-1.0, 0.0)) == "left"
        assert side(rule, hall(), (1.0, 0.0)) == "right"


def test_multi_criteria_remembers_a_share_of_each_direction() -> None:
    view = hall()
    for keep in (0.0, 0.63):
        choice = only(ahead=1.0, keep=keep).choose(view, (0.5, 0.25))
        x_m, y_m = view.frame.centre_of(*choice.cell)
        dx, dy = x_m - view.pose[0], y_m - view.pose[1]
        length = math.hypot(dx, dy)
        expected = (
            keep * 0.5 + (1 - keep) * dx / length,
            keep * 0.25 + (1 - keep) * dy / length,
        )
        assert choice.memory == pytest.approx(expected)


@settings(max_examples=150, deadline=None, derandomize=True, database=None)
@given(data=st.data(), seed=st.integers(0, 10**6), teams=st.integers(1, 6))
def test_multi_criteria_is_the_sum_that_its_docstring_says(
    data: st.DataObject, seed: int, teams: int
) -> None:
    view = any_hall(seed, teams, holes=9)
    # Mostly 0, so that now this term decides and now that.
    weight = st.sampled_from([0.0, 0.0, 0.0, 1.0, -1.0, 3.0])
    names = ("way", "front", "turn_m", "near_gain", "open_gain", "wall", "apart", "ahead")
    w = {name: data.draw(weight, label=name) for name in names}
    w["turn_m"] = abs(w["turn_m"])
    open_m, apart_m = data.draw(st.floats(0.5, 4.0)), data.draw(st.floats(0.5, 12.0))
    kept = data.draw(st.tuples(st.floats(-1.0, 1.0), st.floats(-1.0, 1.0)))
    x, y, _ = view.pose
    open_m2 = view.unknown_m2(open_m) - w["wall"] * view.area_m2("occupied", open_m)
    scores = []
    for f, at in enumerate(view.frontiers_m.tolist()):
        way = view.path_length_m[f]
        way = 1000.0 + view.distances_m[f] if math.isinf(way) else way
        soonest = math.inf
        for place, heading in zip(view.members_m, view.members_heading_rad, strict=True):
            dx, dy = at[0] - place[0], at[1] - place[1]
            off = math.atan2(dy, dx) - heading if (dx, dy) != (0.0, 0.0) else 0.0
            chord = 2.0 * abs(math.sin(0.5 * off))
            soonest = min(soonest, math.hypot(dx, dy) + w["turn_m"] * chord)
        score = w["near_gain"] * view.unknown_m2(1.0)[f] + w["open_gain"] * open_m2[f]
        score -= w["way"] * way + w["front"] * soonest
        for target in view.others.destinations_m.tolist():
            if not math.isnan(target[0]):
                score -= w["apart"] * max(0.0, 1.0 - math.dist(at, target) / apart_m)
        length = math.dist(at, (x, y))
        if length > 0.0:
            score += w["ahead"] * ((at[0] - x) * kept[0] + (at[1] - y) * kept[1]) / length
        scores.append(score)
    rule = MultiCriteria(**w, open_m=open_m, apart_m=apart_m)
    chosen = view.frontiers.tolist().index(list(rule.choose(view, kept).cell))
    assert scores[chosen] == pytest.approx(max(scores), abs=1e-7)


@pytest.mark.parametrize(
    "rule", [Nearest(), NearestEuclidean(), Utility(), InformationGain(), Potential(), LlmLike()]
)
def test_nearer_is_better(rule: Selector) -> None:
    assert side(rule, hall(leader=LEFT_OF_MIDDLE)) == "left"
    assert side(rule, hall(leader=RIGHT_OF_MIDDLE)) == "right"


@pytest.mark.parametrize("rule", [Utility(), Potential(), LlmLike()])
def test_destinations_of_others_push_away(rule: Selector) -> None:
    at = (1, 15)
    assert side(rule, hall(others=((at, (5, 6)),), leader=LEFT_OF_MIDDLE)) == "right"
    assert side(rule, hall(others=((at, (5, 24)),), leader=RIGHT_OF_MIDDLE)) == "left"


@pytest.mark.parametrize(
    ("near", "far"),
    [
        (Utility(range_m=3.0), Utility(range_m=30.0)),
        (Potential(range_m=3.0), Potential(range_m=30.5)),
        (LlmLike(apart_m=3.0), LlmLike(apart_m=25.0)),
    ],
)
def test_they_push_as_far_as_their_range(near: Selector, far: Selector) -> None:
    # 4 m from the nearest frontier cell on the left.
    view = hall(others=(((5, 14), (5, 14)),), leader=(5, 14))
    crowded = hall(others=(((1, 5), (1, 5)), ((9, 5), (9, 5))), leader=LEFT_OF_MIDDLE)
    assert side(near, view) == "left"
    assert side(far, crowded) == "right"


def test_utility_weighs_the_way_by_beta() -> None:
    view = hall(others=(((1, 15), (5, 6)),), leader=LEFT_OF_MIDDLE)
    assert side(Utility(beta_per_m=0.01), view) == "right"
    assert side(Utility(beta_per_m=1.0), view) == "left"


def test_information_gain_weighs_area_against_the_way() -> None:
    view = hall(((6, 25), UNKNOWN), ((4, 25), UNKNOWN), leader=LEFT_OF_MIDDLE)
    assert side(InformationGain(decay_per_m=0.05), view) == "right"
    assert side(InformationGain(decay_per_m=2.0), view) == "left"
    assert side(InformationGain(reach_m=0.6, decay_per_m=0.5), view) == "left"


def test_potential_is_pushed_by_places_too_and_by_as_much_as_push_says() -> None:
    view = hall(others=((BESIDE_LEFT, None),), leader=LEFT_OF_MIDDLE)
    assert side(Potential(), view) == "right"
    assert side(Potential(push_m3=0.01), view) == "left"


def test_llm_like_gains_from_frontiers_and_loses_from_obstacles() -> None:
    # Between two unknown cells a frontier has six others beside it.
    view = hall(((5, 27), UNKNOWN))
    assert side(LlmLike(frontier_m=3.0), view) == "right"
    assert side(LlmLike(frontier_m=0.0), view) == "left"
    ring = tuple(((5 + r, 5 + c), OCCUPIED) for r in (-2, 2) for c in range(-2, 3))
    ring += tuple(((5 + r, 5 + c), OCCUPIED) for r in range(-1, 2) for c in (-2,))
    ring += (((4, 7), OCCUPIED), ((6, 7), OCCUPIED))
    view = hall(*ring, leader=LEFT_OF_MIDDLE)
    assert side(LlmLike(obstacle_m=7.6), view) == "right"
    assert side(LlmLike(obstacle_m=0.0), view) == "left"


def test_minpos_leaves_a_frontier_to_those_who_are_nearer() -> None:
    assert side(MinPos(), hall(leader=LEFT_OF_MIDDLE)) == "left"
    assert side(MinPos(), hall(leader=RIGHT_OF_MIDDLE)) == "right"
    assert side(MinPos(), hall(leader=LEFT_OF_MIDDLE, others=((BESIDE_LEFT, None),))) == "right"
    # One is nearer on the left and two on the right: the left has the lower rank.
    teams = ((BESIDE_LEFT, None), (BESIDE_RIGHT, None), ((6, 22), None))
    assert side(MinPos(), hall(leader=RIGHT_OF_MIDDLE, others=teams)) == "left"


def test_minpos_takes_what_has_no_way_last() -> None:
    ring = [((5 + r, 5 + c), OCCUPIED) for r in (-2, 2) for c in range(-2, 3)]
    ring += [((5 + r, 5 + c), OCCUPIED) for r in range(-1, 2) for c in (-2, 2)]
    view = hall(*ring, leader=LEFT_OF_MIDDLE, others=((BESIDE_RIGHT, None),))
    assert side(MinPos(), view) == "right"


def test_hungarian_leaves_what_is_cheaper_for_others() -> None:
    assert side(Hungarian(), hall(leader=LEFT_OF_MIDDLE, others=((BESIDE_LEFT, None),))) == "right"
    assert side(Hungarian(), hall(leader=LEFT_OF_MIDDLE, others=(((5, 16), None),))) == "left"
    # Two frontiers and three teams: the one that gets none takes its nearest.
    teams = ((BESIDE_LEFT, None), (BESIDE_RIGHT, None))
    assert side(Hungarian(), hall(leader=LEFT_OF_MIDDLE, others=teams)) == "left"
    assert side(Hungarian(), hall(leader=RIGHT_OF_MIDDLE, others=teams)) == "right"


def test_voronoi_takes_its_own_cell_first() -> None:
    assert side(Voronoi(), hall(leader=LEFT_OF_MIDDLE)) == "left"
    assert side(Voronoi(), hall(leader=LEFT_OF_MIDDLE, others=((BESIDE_LEFT, None),))) == "right"
    teams = ((BESIDE_LEFT, None), (BESIDE_RIGHT, None))
    assert side(Voronoi(), hall(leader=LEFT_OF_MIDDLE, others=teams)) == "left"
    assert side(Voronoi(), hall(leader=RIGHT_OF_MIDDLE, others=teams)) == "right"


def test_nearest_goes_by_route_and_nearest_euclidean_by_the_straight_line() -> None:
    # A wall between the leader and the left, open at its lower end only.
    wall = [((row, 12), OCCUPIED) for row in range(1, 9)]
    view = hall(*wall, leader=LEFT_OF_MIDDLE)
    assert side(Nearest(), view) == "right"
    assert side(NearestEuclidean(), view) == "left"


@settings(max_examples=30, deadline=None, derandomize=True, database=None)
@given(
    seed=st.integers(0, 5),
    number=st.integers(0, 9),
    radius_m=st.floats(0.0, 8.0),
    sigma=st.sampled_from([0.0, 0.02, 0.4]),
)
def test_quantile_local_is_the_baseline_among_near_frontiers(
    seed: int, number: int, radius_m: float, sigma: float
) -> None:
    view = list(situations(seed))[number].view
    view = view.among(view.frontiers[:, 0] >= 0)
    rule = QuantileLocal(radius_m=radius_m, sigma=sigma)
    choice = rule.choose(view, None)
    view = view.among(view.frontiers[:, 0] >= 0)
    bias = view.character.uniform(0.19, 0.32)
    quantile = min(1.0, max(0.0, view.rng.normal(bias, sigma)))
    everywhere = [
        (float(d), *cell) for d, cell in zip(view.distances_m, view.frontiers.tolist(), strict=True)
    ]
    near = sorted(f for f in everywhere if f[0] <= radius_m) or sorted(everywhere)
    assert tuple(choice.cell) == near[round(quantile * (len(near) - 1))][1:]
    assert choice.memory == bias
    assert rule.choose(view.among(view.frontiers[:, 0] >= 0), 0.9).memory == 0.9


def test_random_has_no_memory() -> None:
    view, rule = next(iter(situations(0))).view, make_selector("random")
    again = [rule.choose(view.among(view.frontiers[:, 0] >= 0), memory) for memory in (None, 3)]
    assert again[0].cell == again[1].cell
