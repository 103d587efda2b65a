"""Shortcuts in looking for a way among others change nothing: plain loops say the same."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from test_route_following import FORWARD_M, RADIUS_M, Trip, open_world

from swarmscout.comms.messages import BEACON
from swarmscout.core.enums import CHARGE
from swarmscout.planning import neighbours, right_of_way
from swarmscout.planning.neighbours import ALONE, MOST_NEAR, MOVES, NEIGHBOUR, SECOND_LEG

STEP = 57
SEEDS = st.integers(0, 2**32 - 1)


class Crowd:
    """Robots round robot 0, and what it knows of them; robots are in the corner of a room.

    Attributes:
        near: NEIGHBOUR[m], whom it can meet as the package says.
        everybody: NEIGHBOUR[n], all that are near.
    """

    def __init__(self, seed: int, robots: int = 12) -> None:
        self.rng = rng = np.random.default_rng(seed)
        places = np.array([1.0, 4.0]) + rng.uniform(0.0, 2.4, (robots, 2))
        # Another one is close by.
        places[1] = places[0] + rng.uniform(-0.4, 0.4, 2)
        trip = Trip(open_world(), 0.5, places, rng.integers(0, 9, robots) * 400)
        planner = trip.planner
        self.headings, self.rules = planner._headings, planner._rights[0]
        self.status, self.route = trip.knowledge.grids.status[0], planner.table.state[0]
        heard = np.zeros(robots, dtype=BEACON)
        heard["x_m"], heard["y_m"] = places.T
        heard["step"] = STEP - (rng.random(robots) < 0.1)
        heard["heading"] = rng.integers(0, 9, robots) * 400
        aims = [np.full(robots, -1), heard["heading"], rng.integers(0, 9, robots) * 400]
        heard["aim"] = np.choose(rng.integers(0, 3, robots), aims)
        heard["still"] = rng.integers(0, 8, robots)
        heard["mode"] = np.where(rng.random(robots) < 0.4, CHARGE, CHARGE - 1)
        self.me = me = trip.minds.own[0]
        me["x_m"], me["y_m"] = places[0]
        me["heading"] = heard["heading"][0]
        seen = np.zeros(robots, dtype=NEIGHBOUR)
        chain = planner._chain
        neighbours.fill_buckets(heard, chain, seen, self.rules)
        around = np.empty(MOST_NEAR + 1, dtype=np.int64)
        near = np.empty(MOST_NEAR + 1, dtype=NEIGHBOUR)
        n, met = neighbours.look_round(
            me, heard, trip.grids.status[0], chain, seen, around, near, 0, STEP, self.headings,
            self.rules,
        )  # fmt: skip
        neighbours.empty_buckets(heard, chain, self.rules)
        assert (chain == -1).all()
        reach = 2 * MOVES * FORWARD_M + 2 * RADIUS_M
        gaps = np.hypot(*(places - places[0]).T)
        assert set(around[:n]) == set(np.flatnonzero(gaps <= reach)) - {0}
        self.near, self.everybody = near[:met].copy(), seen[around[:n]]
        shift = STEP // 20
        for other, j in zip(self.everybody, around[:n], strict=True):
            other["first"] = (j + shift) % robots < shift % robots
            if (heard["mode"][j] == CHARGE) != (heard["mode"][0] == CHARGE):
                other["first"] = heard["mode"][j] == CHARGE

    def free_moves(
        self, x: float, y: float, dx: float, dy: float, start: int, most: int
    ) -> tuple[int, int]:
        """How many moves are free, with shortcuts, and by a plain loop over everybody."""
        of, rules = (self.status, self.route), self.rules
        fast = right_of_way._free_moves(*of, self.near, x, y, dx, dy, start, most, STEP, rules)
        for m in range(most):
            met = any(
                neighbours.meets(other, x, y, dx, dy, start + m, rules) != ALONE
                for other in self.everybody
            )
            if met or right_of_way._is_closed(*of, x, y, dx, dy, STEP, rules):
                return fast, m
            x += dx
            y += dy
        return fast, most


@settings(max_examples=60, deadline=None)
@given(seed=SEEDS)
def test_moves_are_free_as_a_plain_look_at_everybody_says(seed: int) -> None:
    crowd = Crowd(seed)
    for _ in range(40):
        turns, moves = crowd.rng.integers(0, 2), int(crowd.rng.integers(0, MOVES + 1))
        dx, dy = FORWARD_M * crowd.headings[400 * crowd.rng.integers(0, 9)]
        x, y = float(crowd.me["x_m"]), float(crowd.me["y_m"])
        fast, plain = crowd.free_moves(x, y, dx, dy, int(turns), MOVES)
        assert fast == plain
        # And any way on, after a detour.
        x, y = x + moves * dx, y + moves * dy
        angle = crowd.rng.uniform(-math.pi, math.pi)
        dx, dy = FORWARD_M * math.cos(angle), FORWARD_M * math.sin(angle)
        late = int(moves + crowd.rng.integers(moves == 0, 5))
        fast, plain = crowd.free_moves(x, y, dx, dy, late, SECOND_LEG)
        assert fast == plain


def plain_detour(crowd: Crowd, wanted: int) -> tuple[float, int, int]:
    """The best detour, found by trying all."""
    me, route, rules = crowd.me, crowd.route, crowd.rules
    gx, gy = me["x_m"] + route["wish_x_m"], me["y_m"] + route["wish_y_m"]
    straight = neighbours.turns_to(me["heading"], wanted, 400, 3600)
    best: tuple[float, int, int] = (math.inf, 0, 0)
    for k in range(9):
        side = -(k + 1) // 2 if k % 2 else k // 2
        heading = int(me["heading"] + (straight + side) * 400) % 3600
        turns = abs(neighbours.turns_to(me["heading"], heading, 400, 3600))
        dx, dy = FORWARD_M * crowd.headings[heading]
        x, y = float(me["x_m"]), float(me["y_m"])
        for m in range(1, crowd.free_moves(x, y, dx, dy, turns, MOVES)[1] + 1):
            spent = turns + m + abs(side)
            time = spent + right_of_way._second_leg(
                crowd.status, route, crowd.near, x + m * dx, y + m * dy, gx, gy, spent, STEP,
                math.inf, rules,
            )  # fmt: skip
            if time < best[0]:
                best = (time, heading, m)
    return best


@settings(max_examples=60, deadline=None)
@given(seed=SEEDS, limit=st.floats(0.0, 20.0))
def test_the_best_detour_is_the_best_of_all(seed: int, limit: float) -> None:
    crowd = Crowd(seed)
    wanted = int(crowd.rng.integers(0, 3600))
    away = crowd.rng.uniform(0.05, 3.0)
    crowd.route["wish_x_m"], crowd.route["wish_y_m"] = away * crowd.headings[wanted]
    time, heading, moves = plain_detour(crowd, wanted)
    found: Any = right_of_way._best_detour(
        crowd.me, crowd.status, crowd.route, crowd.near, wanted, STEP, crowd.headings, limit,
        crowd.rules,
    )  # fmt: skip
    assert found == ((heading, moves) if time < limit else (0, 0))


@pytest.mark.parametrize("ticks", [3600, 3599, 7])
def test_turns_are_the_nearest_way_round(ticks: int) -> None:
    rng = np.random.default_rng(ticks)
    for heading, wanted in rng.integers(0, ticks, (200, 2)).tolist():
        off = (wanted - heading + ticks // 2) % ticks - ticks // 2
        assert neighbours.turns_to(heading, wanted, 1, ticks) == off


def test_in_the_first_step_a_robot_is_where_it_is_though_it_drives_ahead() -> None:
    rules = Crowd(0).rules
    other = np.zeros(1, dtype=NEIGHBOUR)[0]
    other["x_m"], other["dx_m"], other["wants"], other["first"] = 0.4, FORWARD_M, True, True
    for start, met in ((0, neighbours.JAMMED), (1, ALONE)):
        assert neighbours.meets(other, 0.0, 0.0, FORWARD_M, 0.0, start, rules) == met
        assert neighbours.may_meet(other, 0.0, 0.0, FORWARD_M, 0.0, start, 1, rules) == (start == 0)
