"""The recommended rule: its formula, and what it prefers where one criterion decides."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from swarmscout.core.codes import FREE, OCCUPIED, UNKNOWN
from swarmscout.core.errors import SelectorError
from swarmscout.destinations.multi_criteria import MultiCriteria
from swarmscout.destinations.registry import make_selector
from swarmscout.destinations.ways import ways_m
from swarmscout.minds.view import LeaderView
from swarmscout.testing import leader_view

Cell = tuple[int, int]
RULE = MultiCriteria()


def hall(seed: int, teams: int) -> LeaderView:
    """A free hall with walls round it, unknown cells, a team of three and teams of one."""
    rng = np.random.default_rng(seed)
    labels = np.full((22, 26), OCCUPIED, dtype=np.uint8)
    labels[1:-1, 1:-1] = FREE
    for _ in range(8):
        labels[int(rng.integers(1, 21)), int(rng.integers(1, 25))] = UNKNOWN
    free = np.argwhere(labels == FREE)
    spots: list[Cell] = [(int(r), int(c)) for r, c in rng.permutation(free)[: 3 + 2 * teams]]
    others = tuple((spots[3 + 2 * t], spots[4 + 2 * t] if t % 2 else None) for t in range(teams))
    return leader_view(labels, spots[0], members=(spots[1], spots[2]), others=others, seed=seed)


def scores(rule: MultiCriteria, view: LeaderView, kept: Cell, home: Cell) -> NDArray[np.float64]:
    """The docstring's formula, in plain Python."""
    found = []
    ways = ways_m(view)
    disc = view.unknown_m2(rule.open_m) - rule.wall * view.area_m2("occupied", rule.open_m)
    for f, (x, y) in enumerate(view.frontiers_m.tolist()):
        gain = rule.least_m2 + rule.near_gain * view.unknown_m2(1.0)[f] + max(0.0, disc[f])
        efforts = []
        for (mx, my), heading in zip(view.members_m, view.members_heading_rad, strict=True):
            off = math.atan2(y - my, x - mx) - heading if (x, y) != (mx, my) else 0.0
            chord = 2.0 * abs(math.sin(off / 2.0))
            efforts.append(math.dist((x, y), (mx, my)) + rule.turn_m * chord)
        effort = rule.leader * ways[f] + (1.0 - rule.leader) * min(efforts)
        crowd = 0.0
        for place in view.others.destinations_m.tolist():
            if not math.isnan(place[0]):
                crowd += max(0.0, 1.0 - math.dist((x, y), place) / rule.apart_m)
        dx, dy = x - view.pose[0], y - view.pose[1]
        length = math.hypot(dx, dy) or 1.0
        found.append(
            math.log(gain)
            - rule.hurry * math.log(rule.start_m + effort)
            - rule.apart * crowd
            + rule.ahead * (dx * kept[0] + dy * kept[1]) / length
            + rule.outward_per_m * math.dist((x, y), home)
        )
    return np.array(found)


@settings(max_examples=40, deadline=None, derandomize=True, database=None)
@given(st.integers(0, 10_000), st.integers(0, 6), st.floats(0.1, 3.0), st.floats(0.0, 1.0))
def test_it_takes_the_best_by_its_formula(
    seed: int, teams: int, hurry: float, leader: float
) -> None:
    view = hall(seed, teams)
    rule = replace(RULE, hurry=hurry, leader=leader, apart_m=8.0)
    expected = scores(rule, view, (1, 0), (3, 4))
    chosen = view.frontiers.tolist().index(list(rule.choose(view, (1.0, 0.0, 3.0, 4.0)).cell))
    assert expected[chosen] == pytest.approx(expected.max(), abs=1e-9)


def corridor(**more: object) -> LeaderView:
    """A corridor 3 m wide, open at both ends; the leader stands in the middle."""
    labels = np.full((12, 60), UNKNOWN, dtype=np.uint8)
    labels[2, 15:45] = labels[9, 15:45] = OCCUPIED
    labels[3:9, 15:45] = FREE
    return leader_view(labels, (6, 30), **more)  # type: ignore[arg-type]


def test_it_goes_where_others_do_not() -> None:
    assert RULE.choose(corridor(others=(((6, 40), (6, 44)),)), None).cell[1] == 15
    assert RULE.choose(corridor(others=(((6, 20), (6, 15)),)), None).cell[1] == 44


def test_it_goes_on_and_outward() -> None:
    view = corridor()
    x, y, _ = view.pose
    for sign, column in ((1.0, 44), (-1.0, 15)):
        assert RULE.choose(view, (sign, 0.0, x, y)).cell[1] == column
        assert RULE.choose(view, (0.0, 0.0, x - 8.0 * sign, y)).cell[1] == column


def test_open_ground_is_worth_a_way() -> None:
    """Beside a corner that was left out, an open end farther off is taken all the same."""
    labels = np.full((12, 60), UNKNOWN, dtype=np.uint8)
    labels[2, 15:35] = labels[9, 15:35] = labels[2:10, 14] = OCCUPIED
    labels[3:9, 15:35] = FREE
    labels[3, 25] = UNKNOWN
    assert RULE.choose(leader_view(labels, (6, 25)), None).cell[1] == 34


def test_what_it_remembers() -> None:
    view = corridor()
    x, y, _ = view.pose
    first = RULE.choose(view, None)
    assert RULE.choose(view, 0.17) == RULE.choose(view, (1, 2)) == first
    kept_x, kept_y, home_x, home_y = first.memory
    assert (home_x, home_y) == (x, y)
    assert math.hypot(kept_x, kept_y) == pytest.approx(1.0 - RULE.keep)
    assert RULE.choose(view, (0.0, 0.0, 7.0, 8.0)).memory[2:] == (7.0, 8.0)


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("keep", 1.0), ("keep", -0.1), ("leader", 1.1), ("apart_m", 0.0), ("least_m2", 0.0),
        ("start_m", 0.0), ("near_gain", -1.0), ("turn_m", -1.0),
    ],
)  # fmt: skip
def test_impossible_parameters_are_named(name: str, value: float) -> None:
    with pytest.raises(SelectorError, match=name):
        make_selector("multi-criteria", {name: value})
