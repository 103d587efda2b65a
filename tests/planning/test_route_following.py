"""Along a route: robots arrive, and a route is kept until something speaks against it."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from known import exchange, knowledge_of, place
from numpy.typing import NDArray

from swarmscout.core.enums import CHARGE, FORWARD, NO_CONTACT, STOP
from swarmscout.core.events import EventLog
from swarmscout.core.grid import GridFrame
from swarmscout.mapping.footprint import Footprint
from swarmscout.mapping.log_odds import InverseSensorModel, log_odds_of
from swarmscout.mapping.occupancy import OccupancyGrids
from swarmscout.minds.minds import blank_minds
from swarmscout.planning.costs import RouteCosts
from swarmscout.planning.routes import Planner, Vehicle
from swarmscout.robots.bodies import TICKS, heading_table, place_bodies
from swarmscout.robots.motion import Motion
from swarmscout.worlds.world import World

MODEL = InverseSensorModel(
    -405, 847, log_odds_of(0.03), log_odds_of(0.97), log_odds_of(0.35), log_odds_of(0.65), 0.05
)
TABLE = heading_table()
RADIUS_M, FORWARD_M, TURN = 0.15, 0.2, 400


class Trip:
    """Robots that plan, steer and move in a world whose map they already have."""

    def __init__(
        self, world: World, cell_m: float, starts: NDArray[np.float64],
        headings: NDArray[np.int64], stations_m: NDArray[np.float64] | None = None,
        radius_m: float | None = None,
    ) -> None:  # fmt: skip
        """Robots are points to their maps unless a radius is given."""
        self.world = world
        self.frame = GridFrame.covering(world.extent, cell_m)
        robots = len(starts)
        self.bodies = place_bodies(starts, headings, np.ones(robots))
        self.minds = blank_minds(robots)
        footprint = radius_m and Footprint.of_disc(radius_m, cell_m, MODEL.hit_depth_m)
        self.grids = OccupancyGrids(self.frame, 1, MODEL, 8, footprint or None)
        body_m = radius_m or RADIUS_M
        costs = RouteCosts(
            round(1000 * cell_m), round(1000 * cell_m * math.sqrt(2.0)), 1000,
            int(MODEL.permille()[0]),
        )  # fmt: skip
        stations = np.zeros((0, 2)) if stations_m is None else stations_m
        vehicle = Vehicle(body_m, FORWARD_M, TURN, 1.4, TABLE)
        self.planner = Planner(self.frame, robots, costs, stations, vehicle)
        self.motion = Motion(world, robots, body_m, FORWARD_M, TURN, TABLE)
        self.knowledge = knowledge_of(self.minds, self.grids)
        self.action = np.zeros(robots, dtype=np.int64)
        self.log = EventLog(robots)
        self.step_number = 0
        self.tell(np.full(self.frame.shape, -5000))

    def tell(self, evidence: NDArray[np.int64]) -> None:
        """Add evidence [rows, columns] to the map."""
        low = np.zeros(1, dtype=np.int64)
        cells = np.arange(self.frame.size)[None].copy()
        self.grids.apply(0, cells, evidence.reshape(1, -1).copy(), low, low + self.frame.size)

    def tell_cell(self, cell: int, increment: int) -> None:
        """Add evidence to one cell of the map."""
        low = np.zeros(1, dtype=np.int64)
        self.grids.apply(0, np.array([[cell]]), np.array([[increment]]), low, low + 1)

    def plan(self) -> int:
        """Plan; returns how many routes were planned."""
        self.step_number += 1
        self.log.clear()
        place(self.minds, self.bodies.position)
        self.minds.own["heading"] = self.bodies.heading
        self.planner.plan(self.minds, self.knowledge, self.step_number, self.log)
        # What happened in this step is over in the next.
        self.grids.counts[:, 0] = 0
        return len(self.log.entries)

    def act(self, *, hears: bool = False) -> None:
        if hears:
            exchange(self.knowledge, self.minds, self.step_number)
        self.planner.steer(
            self.minds, self.knowledge, self.bodies.touch, self.step_number, self.action
        )
        self.motion.carry_out(self.action, self.bodies, self.step_number)

    def gap_to(self, cell: int) -> float:
        """Distance of robot 0 from a cell's centre."""
        x, y = self.frame.centre_of(*self.frame.unflat(cell))
        return float(np.hypot(*(self.bodies.position[0] - (x, y))))


def open_world(size_m: float = 8.0) -> World:
    cells = round(size_m / 0.1)
    return World("plain", np.ones((cells, cells), dtype=np.uint8), 0.1, (-2.0, 1.0))


def cell_at(trip: Trip, x_m: float, y_m: float) -> int:
    return trip.frame.flat(*trip.frame.cell_of(x_m, y_m))


@settings(max_examples=60)
@given(seed=st.integers(0, 2**32 - 1), cell_m=st.sampled_from([0.1, 0.15, 0.25, 0.5, 1.0]))
def test_a_robot_alone_in_the_open_arrives(seed: int, cell_m: float) -> None:
    rng = np.random.default_rng(seed)
    world = open_world()
    low, high = np.array([-2.0, 1.0]) + 0.2, np.array([6.0, 9.0]) - 0.2
    start = rng.uniform(low, high)
    trip = Trip(world, cell_m, start[None], rng.integers(0, TICKS, 1))
    # A goal whose centre a body can reach.
    goal = cell_at(trip, *rng.uniform(low + cell_m, high - cell_m))
    trip.minds.own["target"][0] = goal
    away = trip.gap_to(goal)
    plans = 0
    # Three times the straight time and some for turning on the spot at the start.
    for _ in range(int(3.0 * away / FORWARD_M) + 30):
        plans += trip.plan()
        trip.act()
        if trip.action[0] == STOP:
            break
    # Nearer than about half a move it would have to circle (what a waypoint's reach allows for).
    assert trip.gap_to(goal) <= max(0.5 * cell_m, 0.61 * FORWARD_M)
    assert trip.action[0] == STOP
    assert plans <= 2
    # And there it stays.
    place = trip.bodies.position.copy()
    for _ in range(3):
        assert trip.plan() == 0
        trip.act()
    assert np.array_equal(trip.bodies.position, place)


@settings(max_examples=30)
@given(seed=st.integers(0, 2**32 - 1))
def test_a_robot_finds_its_way_through_a_known_maze_of_pillars(seed: int) -> None:
    rng = np.random.default_rng(seed)
    world = open_world()
    # Pillars fill map cells exactly, so that the map says the truth.
    trip = Trip(world, 1.0, np.array([[-1.5, 1.5]]), rng.integers(0, TICKS, 1))
    closed = np.zeros(trip.frame.shape, dtype=np.bool_)
    closed[2:-2, 2:-2] = rng.random((6, 6)) < 0.3
    free = np.kron(~closed[1:-1, 1:-1], np.ones((10, 10))).astype(np.uint8)
    trip.world = World("pillars", free, 0.1, (-2.0, 1.0))
    trip.tell(np.where(closed, 10000, 0))
    goal = cell_at(trip, 5.5, 8.5)
    trip.minds.own["target"][0] = goal
    for _ in range(250):
        trip.plan()
        trip.act()
    assert trip.gap_to(goal) <= 0.5


@given(seed=st.integers(0, 2**32 - 1))
def test_a_robot_that_charges_drives_to_the_station_and_waits_there(seed: int) -> None:
    rng = np.random.default_rng(seed)
    stations = np.array([[0.0, 3.0], [5.0, 8.0]])
    start = rng.uniform((-1.8, 1.2), (5.8, 8.8))
    trip = Trip(open_world(), 0.5, start[None], rng.integers(0, TICKS, 1), stations)
    trip.minds.own["mode"][0] = CHARGE
    nearest = int(np.argmin(np.hypot(*(stations - start).T)))
    ways = np.hypot(*(stations - start).T)
    for _ in range(150):
        trip.plan()
        trip.act()
    gaps = np.hypot(*(stations - trip.bodies.position[0]).T)
    assert gaps.min() <= 1.4
    assert trip.action[0] == STOP
    if abs(ways[0] - ways[1]) > 2.5:  # Ways over cells are not straight.
        assert gaps[nearest] <= 1.4


@given(st.integers(0, TICKS - 1), st.integers(0, TICKS - 1))
def test_a_robot_turns_the_short_way_and_drives_once_it_looks_ahead(
    heading: int, direction: int
) -> None:
    trip = Trip(open_world(), 0.5, np.array([[2.25, 5.25]]), np.array([heading]))
    goal = cell_at(trip, 2.25 + 2.4 * TABLE[direction, 0], 5.25 + 2.4 * TABLE[direction, 1])
    trip.minds.own["target"][0] = goal
    trip.plan()
    # All is free up to the goal, so that is what it heads for.
    x_m, y_m = trip.frame.centre_of(*trip.frame.unflat(goal))
    wanted = math.degrees(math.atan2(y_m - 5.25, x_m - 2.25))
    off = (wanted - heading / 10.0 + 180.0) % 360.0 - 180.0
    trip.act()
    if abs(off) < 30.0 - 1e-6:
        assert trip.action[0] == FORWARD
    elif 30.0 + 1e-6 < abs(off) < 180.0 - 1e-6:
        turned = (int(trip.bodies.heading[0]) - heading + 1800) % 3600 - 1800
        assert turned == math.copysign(400, off)


def on_the_way() -> tuple[Trip, list[int]]:
    """A robot with a route of twelve straight cells, which has driven a little of it."""
    trip = Trip(open_world(), 0.5, np.array([[-1.25, 3.25]]), np.array([0]))
    trip.minds.own["target"][0] = cell_at(trip, 4.75, 3.25)
    assert trip.plan() == 1
    for _ in range(5):
        trip.act()
        assert trip.plan() == 0
    ahead = trip.planner.table.ahead(0).tolist()
    assert len(ahead) == 10
    return trip, ahead


def test_a_route_is_planned_anew_when_a_cell_on_it_closes() -> None:
    for which in (0, 4, 8):
        trip, ahead = on_the_way()
        trip.tell_cell(ahead[which], 10000)
        assert trip.plan() == 1
        now = trip.planner.table.ahead(0).tolist()
        assert ahead[which] not in now
        assert now[-1] == ahead[-1]


def test_a_route_is_planned_anew_when_it_would_come_to_cut_a_corner() -> None:
    trip = Trip(open_world(), 0.5, np.array([[-1.25, 1.75]]), np.array([450]))
    trip.minds.own["target"][0] = cell_at(trip, 2.75, 5.75)
    assert trip.plan() == 1
    before, after = trip.planner.table.ahead(0)[3:5].tolist()
    columns = trip.frame.columns
    assert after == before + columns + 1
    trip.tell_cell(before + 1, 10000)
    assert trip.plan() == 1
    route = trip.planner.table.ahead(0).tolist()
    assert (before, after) not in pairwise(route)


def test_a_route_is_kept_when_only_other_things_change() -> None:
    trip, ahead = on_the_way()
    columns = trip.frame.columns
    for cell in (ahead[3] + columns, ahead[3] - columns, ahead[0] - 2):
        trip.tell_cell(cell, 10000)  # Beside the route, and where the robot has been already.
        assert trip.plan() == 0
    trip.tell_cell(ahead[2], 5100)  # Dearer, but not closed.
    assert trip.plan() == 0
    assert trip.planner.table.ahead(0).tolist() == ahead


def test_a_route_is_planned_anew_when_the_goal_changes_or_the_robot_is_pushed_off() -> None:
    trip, ahead = on_the_way()
    trip.minds.own["target"][0] = ahead[2]
    assert trip.plan() == 1
    assert trip.planner.table.ahead(0).tolist()[-1] == ahead[2]
    assert trip.plan() == 0
    trip.bodies.position[0, 1] += 2.6
    assert trip.plan() == 1
    assert trip.plan() == 0
    trip.minds.own["target"][0] = -1
    assert trip.plan() == 0
    assert len(trip.planner.table.ahead(0)) == 0
    trip.act()
    assert trip.action[0] == STOP


def test_where_there_is_no_route_it_is_tried_again_after_ten_steps() -> None:
    trip, ahead = on_the_way()
    trip.tell_cell(ahead[-1], 10000)
    assert trip.plan() == 1
    assert trip.planner.table.state["cost"][0] == -1
    trip.tell_cell(ahead[-1], -10000)  # Open again, but nobody looks before its time.
    assert [trip.plan() for _ in range(10)] == [0] * 9 + [1]
    assert trip.planner.table.state["cost"][0] > 0


def test_a_closed_goal_leaves_the_robot_standing() -> None:
    trip, ahead = on_the_way()
    trip.tell_cell(ahead[-1], 10000)
    place = trip.bodies.position.copy()
    for _ in range(4):
        trip.plan()
        trip.act()
    assert np.array_equal(trip.bodies.position, place)
    assert trip.planner.table.state["length"][0] == 0


def test_a_robot_whose_charge_is_gone_plans_and_does_nothing() -> None:
    trip, _ = on_the_way()
    trip.minds.own["thinks"][0] = False
    trip.minds.own["target"][0] = cell_at(trip, 0.25, 7.25)
    assert trip.plan() == 0
    trip.act()
    assert trip.action[0] == STOP


@pytest.mark.parametrize("heading", range(0, TICKS, 450))
@pytest.mark.parametrize("hears", [False, True])
def test_two_robots_that_meet_head_on_get_past_each_other(heading: int, hears: bool) -> None:
    middle = np.array([2.25, 5.25])
    way = np.array([np.cos(heading * np.pi / 1800), np.sin(heading * np.pi / 1800)])
    starts = np.array([middle - 2.0 * way, middle + 2.0 * way])
    trip = Trip(open_world(), 0.5, starts, np.array([heading, heading + 1800]))
    goals = [cell_at(trip, *starts[1]), cell_at(trip, *starts[0])]
    trip.minds.own["target"] = goals
    touched = False
    for _ in range(120):
        trip.plan()
        trip.act(hears=hears)
        touched |= bool((trip.bodies.contact != NO_CONTACT).any())
    # Robots that hear nothing of each other feel it.
    assert touched != hears
    for i in range(2):
        x, y = trip.frame.centre_of(*trip.frame.unflat(goals[i]))
        assert np.hypot(*(trip.bodies.position[i] - (x, y))) <= 0.25 + 1e-9
