"""Robots that hear each other keep clear, get through, and give up what they cannot reach."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from test_route_following import FORWARD_M, RADIUS_M, Trip, cell_at, open_world

from swarmscout.comms.messages import BEACON
from swarmscout.core.enums import CHARGE, EXPLORE, FORWARD, NO_CONTACT, STOP, WALL_CONTACT
from swarmscout.mapping.footprint import STATION_ZONE
from swarmscout.planning.following import FAIL_STEPS
from swarmscout.planning.neighbours import (
    MOST_NEAR,
    NEIGHBOUR,
    empty_buckets,
    fill_buckets,
    look_round,
)
from swarmscout.robots.bodies import TICKS
from swarmscout.robots.motion import Motion
from swarmscout.worlds.world import World


def left_to_go(trip: Trip, goals: list[int]) -> np.ndarray:
    """Each robot's distance from its goal, in metres."""
    ends = np.array([trip.frame.centre_of(*trip.frame.unflat(goal)) for goal in goals])
    gaps: np.ndarray = np.hypot(*(trip.bodies.position - ends).T)
    return gaps


@pytest.mark.parametrize("robots", [2, 5, 8, 12])
def test_robots_on_a_circle_change_places_without_a_touch(robots: int) -> None:
    angles = 2.0 * math.pi * np.arange(robots) / robots
    ways = np.column_stack((np.cos(angles), np.sin(angles)))
    starts = np.array([2.1, 5.1]) + 2.5 * ways
    headings = (np.round(angles * TICKS / (2.0 * math.pi)).astype(np.int64) + 1800) % TICKS
    trip = Trip(open_world(), 0.25, starts, headings)
    goals = [cell_at(trip, *(np.array([2.1, 5.1]) - 2.5 * way)) for way in ways]
    trip.minds.own["target"] = goals
    touched = 0
    for _ in range(200):
        trip.plan()
        trip.act(hears=True)
        touched += int((trip.bodies.contact != NO_CONTACT).sum())
        if (left_to_go(trip, goals) < 0.3).all():
            break
    assert (left_to_go(trip, goals) < 0.3).all()
    assert touched <= robots // 4


@settings(max_examples=25, deadline=None)
@given(seed=st.integers(0, 2**32 - 1))
def test_nobody_drives_into_a_place_that_it_knows_to_be_taken(seed: int) -> None:
    rng = np.random.default_rng(seed)
    places = rng.permutation(49)[:20]
    lattice = np.column_stack((places % 7, places // 7)).astype(np.float64)
    starts = 0.35 * lattice + np.array([1.0, 4.0])
    trip = Trip(open_world(), 0.5, starts, rng.integers(0, TICKS, 20))
    trip.minds.own["target"] = [
        cell_at(trip, *rng.uniform((-1.5, 1.5), (5.5, 8.5))) for _ in starts
    ]
    for _ in range(40):
        trip.plan()
        before = trip.bodies.position.copy()
        trip.act(hears=True)
        for i in np.flatnonzero(trip.action == FORWARD):
            way = trip.planner._headings[trip.bodies.heading[i]] * FORWARD_M
            gap = np.hypot(*(before - before[i]).T)
            after = np.hypot(*(before - before[i] - way).T)
            gap[i] = after[i] = np.inf
            # Nearer than bodies are wide only to whom it drives away from.
            assert ((after >= 2.0 * RADIUS_M - 1e-9) | (after > gap)).all()


def test_a_crowd_in_a_hall_comes_through_a_crowd_that_goes_the_other_way() -> None:
    left = [(-1.75 + 0.5 * (k % 2), 3.25 + 0.5 * (k // 2)) for k in range(10)]
    right = [(5.25 + 0.5 * (k % 2), 3.25 + 0.5 * (k // 2)) for k in range(10)]
    trip = Trip(open_world(), 0.5, np.array(left + right), np.repeat([0, 1800], 10))
    goals = [cell_at(trip, x, y) for x, y in right + left]
    trip.minds.own["target"] = goals
    for _ in range(150):
        trip.plan()
        trip.act(hears=True)
    # Some goals lie behind robots that have arrived already.
    assert (left_to_go(trip, goals) < 2.0).all()


def behind_glass() -> Trip:
    """A robot whose map says that all is free, in a world with a wall right across."""
    world = open_world()
    free = world.free.copy()
    free[:, 40] = 0
    trip = Trip(world, 0.5, np.array([[1.0, 5.25]]), np.array([0]))
    walled = World("walled", free, 0.1, (-2.0, 1.0))
    trip.motion = Motion(walled, 1, RADIUS_M, FORWARD_M, 400, trip.planner._headings)
    trip.minds.own["target"][0] = cell_at(trip, 5.25, 5.25)
    return trip


def test_who_cannot_get_on_gives_up_and_does_not_scrub_at_a_wall() -> None:
    trip = behind_glass()
    bumps = 0
    for _ in range(FAIL_STEPS + 40):
        trip.plan()
        trip.act()
        bumps += int(trip.bodies.contact[0] == WALL_CONTACT)
        if trip.planner.table.state["failed_until"][0] > 0:
            break
    assert trip.planner.table.state["failed_until"][0] == trip.step_number + 10
    assert trip.action[0] == STOP
    assert bumps <= 8


def test_who_turns_to_and_fro_stands() -> None:
    trip = behind_glass()
    trip.minds.own["target"][0] = -1
    for _ in range(12):
        trip.plan()
        trip.act()
        trip.bodies.position[0, 0] += 0.1 * (-1) ** trip.step_number
    assert trip.minds.own["still"][0] >= 11
    trip.bodies.position[0, 0] += 0.5
    trip.plan()
    trip.act()
    assert trip.minds.own["still"][0] == 0


def test_a_robot_says_where_it_means_to_drive_and_that_it_stands() -> None:
    trip = Trip(open_world(), 0.5, np.array([[1.0, 5.25]]), np.array([0]))
    trip.minds.own["target"][0] = cell_at(trip, 5.25, 5.25)
    trip.plan()
    trip.act()
    assert trip.minds.own["aim"][0] == 0
    trip.minds.own["target"][0] = -1
    trip.plan()
    trip.act()
    assert trip.minds.own["aim"][0] == -1


@pytest.mark.parametrize("in_zone", [False, True])
def test_who_has_charged_leaves_the_station_before_others_come_in(in_zone: bool) -> None:
    trip = Trip(open_world(), 0.5, np.array([[0.25, 5.25], [3.25, 5.25]]), np.array([0, 1800]))
    if in_zone:
        trip.grids.status[:] |= STATION_ZONE
    trip.minds.own["mode"] = [EXPLORE, CHARGE]
    trip.minds.own["aim"] = [0, 1800]
    heard = np.zeros(2, dtype=BEACON)
    for name in BEACON.names:
        if name != "step":
            heard[name] = trip.minds.own[name]
    rules = trip.planner._rights
    chain, seen = trip.planner._chain, np.zeros(2, dtype=NEIGHBOUR)
    around = np.zeros(MOST_NEAR + 1, dtype=np.int64)
    near = np.zeros(MOST_NEAR + 1, dtype=NEIGHBOUR)
    for i in (0, 1):
        fill_buckets(heard, chain, seen, rules[0])
        n, _ = look_round(
            trip.minds.own[i], heard, trip.grids.status[0], chain, seen, around, near, i, 0,
            trip.planner._headings, rules[0],
        )  # fmt: skip
        empty_buckets(heard, chain, rules[0])
        assert n == 1
        # The other one goes first, as seen by the robot that explores, exactly outside.
        assert near[0]["first"] == ((i == 0) != in_zone)
