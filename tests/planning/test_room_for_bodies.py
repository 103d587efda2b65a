"""Robots drive where their bodies have room, at every size of cells and bodies."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from test_route_following import Trip, cell_at, open_world

import swarmscout as ss
from swarmscout.core.enums import FREE
from swarmscout.destinations.features import Frontiers, Scratch
from swarmscout.mapping.footprint import TIGHT
from swarmscout.robots.bodies import TICKS
from swarmscout.worlds import world_from_array
from swarmscout.worlds.world import World


def walled(seed: int, cell_m: float, radius_m: float) -> Trip:
    """A map in which all is known, a tenth of the cells are walls; a robot in its middle."""
    rng = np.random.default_rng(seed)
    start = np.array([2.0 + 0.3 * cell_m, 5.0 + 0.3 * cell_m])
    trip = Trip(open_world(), cell_m, start[None], rng.integers(0, TICKS, 1), radius_m=radius_m)
    walls = rng.random(trip.frame.shape) < rng.uniform(0.0, 0.1)
    trip.tell(np.where(walls, 10000, 0))
    return trip


@settings(max_examples=25)
@given(
    st.integers(0, 2**32 - 1),
    st.sampled_from([0.25, 0.5]),
    st.sampled_from([0.1, 0.15, 0.3, 0.5]),
)
def test_routes_walks_and_costs_agree_on_where_there_is_room(
    seed: int, cell_m: float, radius_m: float
) -> None:
    trip = walled(seed, cell_m, radius_m)
    rng = np.random.default_rng(seed + 1)
    start = cell_at(trip, *trip.bodies.position[0])
    labels = trip.grids.view(0).labels.ravel()
    goals = np.sort(rng.choice(np.flatnonzero(labels == FREE), 12, replace=False))
    goals = goals[goals != start]
    costs = trip.planner.costs_from(trip.grids, 0, start, goals)
    place = trip.grids.exits(0, np.array([start]))
    found = Frontiers(trip.grids, 0, goals, Scratch(trip.frame)).walks(place)
    assert np.array_equal(np.isfinite(costs), found[0] >= 0)
    entries = trip.grids.entries(0, goals)
    for goal, cost, entry in zip(goals.tolist(), costs.tolist(), entries.tolist(), strict=True):
        trip.minds.own["target"][0] = goal
        trip.planner.table.state["failed_until"][0] = 0
        trip.plan()
        route = trip.planner.table.state[0]
        assert (route["cost"] >= 0) == np.isfinite(cost)
        if route["cost"] >= 0:
            assert trip.planner.costs.in_metres(int(route["cost"])) == cost
            ahead = trip.planner.table.ahead(0)
            assert not (trip.grids.status[0, ahead] & TIGHT).any()
            assert [entry] == ahead[-1:].tolist() or (len(ahead) == 0 and entry in (start, *place))


@pytest.mark.parametrize("cell_m", [0.05, 0.1])
def test_a_robot_gets_out_of_where_it_has_no_room(cell_m: float) -> None:
    trip = Trip(open_world(), cell_m, np.array([[0.0, 5.0]]), np.zeros(1, np.int64), radius_m=0.3)
    # A wall appears beside the robot, nearer than its radius: its position was wrong, say.
    evidence = np.zeros(trip.frame.shape, dtype=np.int64)
    row, col = trip.frame.cell_of(0.0, 5.1)
    evidence[row, col - 40 : col + 40] = 10000
    trip.tell(evidence)
    goal = cell_at(trip, 3.0, 3.0)
    trip.minds.own["target"][0] = goal
    for _ in range(60):
        trip.plan()
        trip.act()
    assert trip.gap_to(goal) <= 0.15


def room(size_m: float = 5.0) -> World:
    free = np.zeros((140, 140), dtype=np.bool_)
    free[20 : 20 + round(size_m / 0.05), 20:120] = True
    return world_from_array(free, 0.05, name="room")


@pytest.mark.parametrize(
    ("cell_m", "radius_m", "least"),
    [(0.5, 0.4, 0.99), (0.25, 0.15, 0.99), (0.25, 0.3, 0.99), (0.1, 0.15, 0.9), (0.1, 0.5, 0.75)],
)
def test_alone_in_a_room_a_robot_keeps_off_the_walls(
    cell_m: float, radius_m: float, least: float
) -> None:
    shares, explored = [], []
    for seed in range(2):
        run = ss.explore(
            room(), robots=1, steps=400, seed=seed, map={"cell_m": cell_m},
            body={"radius_m": radius_m}, battery={"enabled": False},
        )  # fmt: skip
        shares.append(run.summary["blocked_share"])
        explored.append(run.summary["explored_fraction"])
    assert np.mean(shares) < 0.03
    assert np.mean(explored) >= least


@pytest.mark.parametrize("offset_m", [0.0, 0.025, 0.05, 0.075])
def test_a_door_a_cell_wider_than_the_robot_is_passed(offset_m: float) -> None:
    free = np.zeros((200, 320), dtype=np.bool_)
    free[40:120, 40:120] = free[40:120, 136:216] = True
    low = 70 + round(offset_m / 0.025)
    free[low : low + 16, 110:140] = True  # 0.4 m wide, 0.4 m long.
    world = world_from_array(free, 0.025, name="door", start_m=(2.0, 2.0))
    run = ss.explore(
        world, robots=1, steps=400, seed=1, map={"cell_m": 0.1}, battery={"enabled": False}
    )
    assert run.summary["explored_fraction"] > 0.55


def test_cells_of_five_centimetres_work() -> None:
    run = ss.explore(
        room(), robots=1, steps=120, seed=0, map={"cell_m": 0.05}, battery={"enabled": False},
        sensor={"model": "lidar", "range_m": 3.0},
    )  # fmt: skip
    assert run.summary["explored_fraction"] > 0.95
    assert run.summary["blocked_share"] < 0.03
