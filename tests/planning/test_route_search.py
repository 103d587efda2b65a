"""Routes against Dijkstra's algorithm of NetworkX on random maps."""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import pairwise

import networkx as nx
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from known import knowledge_of
from known import place as put
from numpy.typing import NDArray

from swarmscout.comms.knowledge import Knowledge
from swarmscout.core.enums import CHARGE, ROUTE
from swarmscout.core.events import EventLog
from swarmscout.core.grid import GridFrame
from swarmscout.mapping.log_odds import InverseSensorModel, log_odds_of
from swarmscout.mapping.occupancy import OccupancyGrids
from swarmscout.minds.minds import Minds, blank_minds
from swarmscout.planning.costs import RouteCosts
from swarmscout.planning.places import dock_cells
from swarmscout.planning.route_table import LONGEST, STATION, blank_routes, by_goal
from swarmscout.planning.routes import Planner, Vehicle
from swarmscout.planning.tolls import STILL_STEPS

MODEL = InverseSensorModel(
    -405, 847, log_odds_of(0.03), log_odds_of(0.97), log_odds_of(0.35), log_odds_of(0.65), 0.05
)
ANGLES = np.arange(3600) * 2.0 * np.pi / 3600
TABLE = np.column_stack([np.cos(ANGLES), np.sin(ANGLES)]).round(15)
VEHICLE = Vehicle(0.15, 0.2, 400, 1.4, TABLE)
RULES = {"length": 1000, "probability": 0}

Integers = NDArray[np.int64]


def costs_for(rule: str, cell_m: float = 0.5, model: InverseSensorModel = MODEL) -> RouteCosts:
    return RouteCosts(
        straight=round(1000.0 * cell_m),
        diagonal=round(1000.0 * cell_m * math.sqrt(2.0)),
        base=RULES[rule],
        least=int(model.permille()[0]),
    )


def maps_of(
    frame: GridFrame, evidence: Integers, maps: int, model: InverseSensorModel = MODEL
) -> OccupancyGrids:
    """So many equal maps with the given evidence in each cell."""
    grids = OccupancyGrids(frame, maps, model, 8)
    for m in range(maps):
        low = np.zeros(1, dtype=np.int64)
        grids.apply(
            m,
            np.arange(frame.size)[None].copy(),
            evidence.reshape(1, -1).copy(),
            low,
            low + frame.size,
        )
    return grids


@dataclass
class Place:
    """A map, robots on it that know where to go, and where others stand for long."""

    frame: GridFrame
    evidence: Integers
    rule: str
    starts: Integers
    goals: Integers
    standing: NDArray[np.bool_]
    stations_m: NDArray[np.float64]

    def plan(
        self, *, maps: int = 1, who: list[int] | None = None
    ) -> tuple[Planner, OccupancyGrids, Integers]:
        """Let some of the robots plan; the others want nothing."""
        robots = len(self.starts)
        grids = maps_of(self.frame, self.evidence, maps)
        minds = blank_minds(robots)
        self.fill(minds)
        for i in range(robots):
            if who is not None and i not in who:
                minds.own["target"][i] = -1
                minds.own["mode"][i] = 0
        planner, log = self.planner(), EventLog(robots)
        planner.plan(minds, self.knowledge(minds, grids), 7, log)
        return planner, grids, log.entries

    def planner(self) -> Planner:
        costs = costs_for(self.rule, self.frame.cell_m)
        return Planner(self.frame, len(self.starts), costs, self.stations_m, VEHICLE)

    def knowledge(self, minds: Minds, grids: OccupancyGrids) -> Knowledge:
        knowledge = knowledge_of(minds, grids)
        knowledge.heard["x_m"], knowledge.heard["y_m"] = minds.own["x_m"], minds.own["y_m"]
        knowledge.heard["step"], knowledge.heard["station"] = 7, -1
        knowledge.heard["mode"] = np.where(self.goals == STATION, CHARGE, 0)
        knowledge.still[:] = np.where(self.standing, STILL_STEPS, STILL_STEPS - 1)
        return knowledge

    def fill(self, minds: Minds) -> None:
        places = self.frame.centres_of(self.frame.unflat_many(self.starts))
        put(minds, places + 0.2 * self.frame.cell_m)
        minds.own["target"] = np.maximum(self.goals, -1)
        minds.own["mode"] = np.where(self.goals == STATION, CHARGE, 0)

    def round_robots(self, home: bool) -> Integers:
        """What others add to the price of each cell, on the way home or out."""
        other_way = (self.goals == STATION) != home
        more = np.where(self.standing, 3000, np.where(other_way, 2000, 0))
        added = np.zeros(self.frame.shape, dtype=np.int64)
        for cell, extra in zip(self.starts.tolist(), more.tolist(), strict=True):
            row, col = divmod(cell, self.frame.columns)
            near = added[max(0, row - 1) : row + 2, max(0, col - 1) : col + 2]
            np.maximum(near, extra, out=near)
        return added.ravel()

    def graph(self, price: NDArray[np.int16], start: int, goal: int = 0) -> nx.DiGraph:
        """All moves that are allowed, and what they cost, from one robot's point of view."""
        per_metre = price.astype(np.int64) + RULES[self.rule]
        per_metre[price < 0] = 1000 + RULES[self.rule]
        per_metre += self.round_robots(goal == STATION)
        lengths = costs_for(self.rule, self.frame.cell_m)
        open_ = (price >= 0).reshape(self.frame.shape)
        graph = nx.DiGraph()
        graph.add_nodes_from(range(self.frame.size))
        for a in range(self.frame.size):
            if price[a] < 0 and a != start:
                continue
            row, col = divmod(a, self.frame.columns)
            for dr, dc in np.ndindex(3, 3):
                r, c = row + dr - 1, col + dc - 1
                if not self.frame.contains(r, c) or not open_[r, c] or (dr == dc == 1):
                    continue
                diagonal = dr != 1 and dc != 1
                if diagonal and not (open_[row, c] and open_[r, col]):
                    continue
                b = self.frame.flat(r, c)
                length = lengths.diagonal if diagonal else lengths.straight
                graph.add_edge(a, b, cost=length * int(per_metre[a] + per_metre[b]))
        return graph

    def goal_cells(self, i: int) -> list[int]:
        if self.goals[i] == STATION:
            return docks_by_definition(self.frame, self.stations_m)
        return [int(self.goals[i])]


def docks_by_definition(frame: GridFrame, stations_m: NDArray[np.float64]) -> list[int]:
    centres = frame.centres_of(frame.unflat_many(np.arange(frame.size)))
    gaps = np.hypot(*(centres[:, None] - stations_m[None]).transpose(2, 0, 1))
    return np.flatnonzero((gaps <= 1.5 * frame.cell_m).any(axis=1)).tolist()


def random_place(seed: int, rule: str, occupied: float, stations: int = 0) -> Place:
    rng = np.random.default_rng(seed)
    frame = GridFrame(*rng.uniform(-3.0, 3.0, 2).tolist(), 0.5, *rng.integers(2, 13, 2).tolist())
    evidence = rng.integers(-5000, 620, frame.size)
    # Large plains of one price have many routes of equal cost.
    evidence[rng.random(frame.size) < rng.choice([0.0, 0.8])] = -5000
    evidence[rng.random(frame.size) < occupied] = 2000
    robots = 6
    # Some start or stand in occupied cells, some share a cell, some want the same.
    starts = rng.integers(0, frame.size, robots)
    starts[1] = starts[0]
    goals = rng.integers(0, frame.size, robots)
    goals[rng.random(robots) < 0.5] = goals[0]
    if stations:
        goals[rng.random(robots) < 0.6] = STATION
    left, right, bottom, top = frame.extent
    stations_m = rng.uniform((left, bottom), (right, top), (stations, 2))
    return Place(frame, evidence, rule, starts, goals, rng.random(robots) < 0.4, stations_m)


places = st.builds(
    random_place,
    st.integers(0, 2**32 - 1),
    st.sampled_from(["length", "probability"]),
    st.sampled_from([0.0, 0.1, 0.25, 0.4]),
    st.integers(0, 3),
)


@settings(max_examples=80)
@given(places)
def test_routes_are_optimal_and_lead_from_cell_to_cell(place: Place) -> None:
    planner, grids, events = place.plan()
    price = grids.price[0]
    table = planner.table
    for i, start in enumerate(place.starts.tolist()):
        graph = place.graph(price, start, int(place.goals[i]))
        ends = [cell for cell in place.goal_cells(i) if price[cell] >= 0]
        best = nx.single_source_dijkstra_path_length(graph, start, weight="cost")
        reachable = [best[cell] for cell in ends if cell in best]
        event = [row for row in events.tolist() if row[1] == i]
        assert len(event) == 1
        assert event[0][0] == ROUTE
        assert event[0][3] == place.goals[i]
        # Of the stations the robot has taken one, if a way leads there.
        goal = table.state["goal"][i]
        chosen = place.goals[i] == STATION and reachable
        assert goal < STATION if chosen else goal == place.goals[i]
        if not reachable:
            assert table.state["cost"][i] == -1
            assert table.state["length"][i] == 0
            assert table.state["failed_until"][i] == 17
            assert event[0][2] == -1
            continue
        assert table.state["cost"][i] == min(reachable)
        assert table.state["failed_until"][i] == 0
        way = [start, *table.ahead(i).tolist()]
        assert event[0][2] == table.state["length"][i] == len(way) - 1
        assert way[-1] in ends
        assert (price[way[1:]] >= 0).all()
        # Each move is an edge: to a neighbour, into no occupied cell and round no corner.
        assert sum(graph.edges[a, b]["cost"] for a, b in pairwise(way)) == min(reachable)


@settings(max_examples=60)
@given(places)
def test_a_route_does_not_depend_on_who_else_asks(place: Place) -> None:
    together, _, _ = place.plan()
    apart, _, _ = place.plan(maps=len(place.starts))
    for i in range(len(place.starts)):
        alone, _, _ = place.plan(who=[i])
        for other in (apart, alone):
            assert other.table.state["cost"][i] == together.table.state["cost"][i]
            assert other.table.ahead(i).tolist() == together.table.ahead(i).tolist()


@settings(max_examples=60)
@given(places, st.integers(0, 2**32 - 1))
def test_route_costs_from_a_cell_equal_dijkstra(place: Place, seed: int) -> None:
    rng = np.random.default_rng(seed)
    # The costs between candidates know of no robots.
    place.standing[:], place.goals[:] = False, 0
    grids = maps_of(place.frame, place.evidence, 1)
    planner = place.planner()
    start = int(place.starts[0])
    graph = place.graph(grids.price[0], start)
    lengths = nx.single_source_dijkstra_path_length(graph, start, weight="cost")
    open_ = np.flatnonzero(grids.price[0] >= 0)
    targets = rng.integers(0, place.frame.size, 15)
    wanted = np.array([lengths.get(int(t), np.inf) for t in targets]) / 2e6
    assert np.array_equal(planner.costs_from(grids, 0, start, targets), wanted)

    for at_most in (1, 3):
        some = np.intersect1d(targets, open_)
        if len(some) == 0:
            continue
        exact = np.array([lengths.get(int(t), np.inf) for t in some]) / 2e6
        found = planner.costs_from(grids, 0, start, some, at_most)
        # The nearest so many, and those just as near; of the rest nothing is said.
        limit = np.sort(exact)[min(at_most, len(some)) - 1]
        assert np.array_equal(found, np.where(exact <= limit, exact, np.inf))


def test_a_search_leaves_nothing_behind_for_the_next() -> None:
    place = random_place(11, "length", 0.2, 1)
    place.standing[:] = True
    planner = place.planner()
    grids = maps_of(place.frame, place.evidence, 1)
    targets = np.arange(place.frame.size)
    first = planner.costs_from(grids, 0, int(place.starts[0]), targets)
    minds = blank_minds(len(place.starts))
    place.fill(minds)
    planner.plan(minds, place.knowledge(minds, grids), 7, EventLog(len(minds)))
    again = planner.costs_from(grids, 0, int(place.starts[0]), targets)
    assert np.array_equal(first, again)


def place_from(picture: str, goal: tuple[int, int], *starts: tuple[int, int]) -> Place:
    """A map drawn by hand, top row first: `#` is occupied, everything else is free."""
    rows = picture.split()[::-1]
    evidence = np.array([[5000 if c == "#" else -5000 for c in row] for row in rows])
    frame = GridFrame(0.0, 0.0, 0.5, *evidence.shape)
    return Place(
        frame, evidence.ravel(), "length", np.array([frame.flat(*s) for s in starts]),
        np.full(len(starts), frame.flat(*goal)), np.zeros(len(starts), dtype=np.bool_),
        np.zeros((0, 2)),
    )  # fmt: skip


def test_corners_are_not_cut() -> None:
    place = place_from("..# ... ...", (2, 1), (1, 2))
    planner, _, _ = place.plan()
    assert planner.table.ahead(0).tolist() == [4, 7]
    between = place_from(".# #.", (0, 1), (1, 0))
    planner, _, _ = between.plan()
    assert planner.table.state["cost"][0] == -1


def test_a_robot_in_an_occupied_cell_gets_out_but_nobody_passes_it() -> None:
    place = place_from(".#. .#. .#.", (1, 2), (1, 1), (1, 0))
    planner, _, _ = place.plan()
    assert planner.table.ahead(0).tolist() == [5]
    assert planner.table.state["cost"][1] == -1
    assert planner.table.state["length"][1] == 0


HALL = " ".join(["." * 9] * 7)


def test_robots_that_stand_are_driven_round_with_room_for_a_body() -> None:
    place = place_from(HALL, (3, 8), (3, 0), (3, 4))
    place.goals[1] = -1
    planner, _, _ = place.plan()
    assert planner.table.ahead(0).tolist() == list(range(28, 36))
    place.standing[1] = True
    planner, _, _ = place.plan()
    rows, columns = np.divmod(planner.table.ahead(0), 9)
    assert not ((np.abs(rows - 3) <= 1) & (np.abs(columns - 4) <= 1)).any()
    # But where there is no other way, the way leads past it.
    corridor = place_from(".....", (0, 4), (0, 0), (0, 2))
    corridor.goals[1] = -1
    corridor.standing[1] = True
    planner, _, _ = corridor.plan()
    assert planner.table.ahead(0).tolist() == [1, 2, 3, 4]


@pytest.mark.parametrize("goes_home", [False, True])
def test_ways_out_and_ways_home_part(goes_home: bool) -> None:
    place = place_from(HALL, (3, 8), (3, 0), (3, 3), (3, 5))
    place.stations_m = np.array([place.frame.centre_of(3, 8)])
    if goes_home:
        place.goals[0] = STATION
    same, other = place.goals[0], -1 if goes_home else STATION
    place.goals[1:] = same
    planner, _, _ = place.plan(who=[0])
    assert 31 in planner.table.ahead(0)
    place.goals[1:] = other
    planner, _, _ = place.plan(who=[0])
    assert 31 not in planner.table.ahead(0)


def test_of_several_stations_the_nearest_by_route_is_taken() -> None:
    # The lower station is near as the crow flies, but behind a wall.
    place = place_from(
        ".......... .######### .......... .......... .......... ..........", (0, 0), (5, 9)
    )
    place.goals[:] = STATION
    place.stations_m = np.array([[4.75, 1.25], [0.25, 2.75]])
    planner, _, _ = place.plan()
    assert planner.table.ahead(0)[-1] == place.frame.flat(5, 1)


@given(st.integers(0, 2**32 - 1))
def test_dock_cells_are_those_round_a_station(seed: int) -> None:
    rng = np.random.default_rng(seed)
    frame = GridFrame(*rng.uniform(-3.0, 3.0, 2).tolist(), 0.5, *rng.integers(1, 12, 2).tolist())
    stations_m = rng.uniform(-4.0, 8.0, (3, 2))
    expected = [
        [cell, s] for s in range(3) for cell in docks_by_definition(frame, stations_m[s : s + 1])
    ]
    assert dock_cells(frame, stations_m).tolist() == expected


def test_long_routes_are_cut_and_continued() -> None:
    columns = 3 * LONGEST
    frame = GridFrame(0.0, 0.0, 0.5, 1, columns)
    grids = maps_of(frame, np.full(columns, -5000), 1)
    planner = Planner(frame, 1, costs_for("length"), np.zeros((0, 2)), VEHICLE)
    minds = blank_minds(1)
    minds.own["target"][0] = columns - 1
    put(minds, (0.25, 0.25))
    knowledge, log = knowledge_of(minds, grids), EventLog(1)
    driven = [0]
    state = planner.table.state[0]
    plans = 0
    for step in range(columns + 5):
        log.clear()
        planner.plan(minds, knowledge, step, log)
        plans += len(log.entries)
        ahead = planner.table.ahead(0)
        assert len(ahead) <= LONGEST
        if state["at"] >= state["length"]:
            break
        driven.append(int(ahead[0]))
        minds.own["x_m"][0] = frame.centre_of(0, driven[-1])[0]
        state["at"] += 1
    assert driven == list(range(columns))
    assert plans == 3


@pytest.mark.parametrize("rule", ["length", "probability"])
def test_cells_that_are_certainly_free_still_cost_something(rule: str) -> None:
    """With nearly no saturation a free cell's probability rounds to 0; its price must not."""
    model = InverseSensorModel(
        -405, 847, log_odds_of(0.0001), log_odds_of(0.97), log_odds_of(0.35), log_odds_of(0.65), 0.0
    )
    frame = GridFrame(0.0, 0.0, 0.5, 4, 5)
    grids = maps_of(frame, np.full(frame.size, -20000), 1, model)
    planner = Planner(frame, 1, costs_for(rule, model=model), np.zeros((0, 2)), VEHICLE)
    minds = blank_minds(1)
    minds.own["target"][0] = 19
    put(minds, (0.25, 0.25))
    planner.plan(minds, knowledge_of(minds, grids), 1, EventLog(1))
    assert planner.table.ahead(0).tolist()[-1:] == [19]
    assert planner.table.state["cost"][0] > 0


@settings(max_examples=50, deadline=None)
@given(st.lists(st.tuples(st.integers(0, 2), st.integers(-4, 3), st.booleans()), max_size=20))
def test_robots_that_share_a_map_and_a_goal_are_grouped_in_order(
    asks: list[tuple[int, int, bool]],
) -> None:
    routes = blank_routes(len(asks)).state
    for route, (m, goal, needs) in zip(routes, asks, strict=True):
        route["map"], route["wanted"], route["need"] = m, goal, needs
    for home in (False, True):
        wanted: dict[tuple[int, int], list[int]] = {}
        for i, (m, goal, needs) in enumerate(asks):
            if needs and (goal <= STATION) == home:
                wanted.setdefault((m, goal), []).append(i)
        robots, groups = by_goal(routes, home)
        assert [robots[begin:end].tolist() for begin, end in groups] == list(wanted.values())
