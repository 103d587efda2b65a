"""Robots that charge share the stations and their places, and go home in time."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from swarmscout.core.enums import CHARGE, EXPLORE
from swarmscout.core.grid import GridFrame
from swarmscout.mission.mission import Mission
from swarmscout.mission.scenario import Scenario
from swarmscout.planning.docking import weigh_stations
from swarmscout.planning.places import lay_places
from swarmscout.planning.route_table import NO_PLACE, STATION, WAITS
from swarmscout.planning.way_home import ask_ways
from swarmscout.worlds.arrays import world_from_array


@given(seed=st.integers(0, 2**32 - 1), cell_m=st.sampled_from([0.1, 0.25, 0.5, 1.0]))
def test_places_lie_inside_the_range_and_apart(seed: int, cell_m: float) -> None:
    rng = np.random.default_rng(seed)
    frame = GridFrame(0.0, 0.0, cell_m, round(8 / cell_m), round(8 / cell_m))
    stations = rng.uniform(2.0, 6.0, (2, 2))
    within_m = max(cell_m, 1.2)
    for station, row in zip(stations, lay_places(frame, stations, within_m, 0.5), strict=True):
        places = frame.centres_of(frame.unflat_many(row[row >= 0]))
        assert 1 <= len(places) <= 48
        assert (np.hypot(*(places - station).T) <= within_m).all()
        gaps = np.hypot(*(places[:, None] - places[None]).transpose(2, 0, 1))
        assert (gaps[~np.eye(len(places), dtype=bool)] >= 0.5 - 1e-9).all()
        assert (row[np.argmax(row < 0) :] < 0).all() or (row >= 0).all()


def hall(robots: int, rule: str, steps: int, **battery: float) -> Mission:
    """Robots in an empty hall; 30 have three stations."""
    world = world_from_array(np.ones((160, 200), dtype=np.uint8), resolution_m=0.1)
    return Mission(
        Scenario(
            robots=robots, steps=steps, destinations="nearest", start="spread",
            battery={"return_rule": rule, **battery},
        ),
        world=world,
    )  # fmt: skip


def test_no_two_robots_stand_at_the_same_place_and_all_stations_are_used() -> None:
    mission = hall(30, "distance", 260, capacity_steps=200)
    used = set()
    while not mission.done:
        mission.step()
        own = mission.minds.own
        charges = (own["mode"] == CHARGE) & mission.bodies.alive
        used |= set(own["station"][charges].tolist()) - {-1}
        # Who chose the same place in one step has parted in the next but one.
        places = own["place"][charges & (own["place"] >= 0)]
        settled = [p for p in places.tolist() if (places == p).sum() > 2]
        assert not settled
        assert (own["place"][~charges & mission.bodies.alive] == -1).all()
    assert used == {0, 1, 2}


@pytest.mark.parametrize("robots", [1, 8])
def test_nobody_is_lost_in_a_hall_and_those_charged_explore_again(robots: int) -> None:
    mission = hall(robots, "distance", 700, capacity_steps=250)
    summary = mission.run()
    assert summary["stranded"] == 0
    assert summary["charges"] >= robots


def test_those_without_a_place_wait_and_the_one_with_least_charge_goes_first() -> None:
    mission = hall(12, "distance", 1, station_range_m=1.5)
    planner, own, knowledge = mission.planner, mission.minds.own, mission.knowledge
    mission.step()
    station = mission.stations_m[0]
    turn = np.linspace(0.0, 2.0 * np.pi, 12, endpoint=False)
    own["x_m"], own["y_m"] = station[0] + 2.5 * np.cos(turn), station[1] + 2.5 * np.sin(turn)
    own["mode"], own["station"], own["place"] = CHARGE, 0, WAITS
    own["charge"] = np.linspace(0.2, 0.5, 12)
    planner._places[:, 1:] = -1  # One place is left.
    knowledge.heard["step"] = 0
    mission.minds.own["team"] = np.arange(12)
    for name in ("x_m", "y_m", "charge", "mode", "station", "place"):
        knowledge.heard[name][0] = own[name]
    knowledge.heard["step"] = 2
    knowledge.still[:] = 0
    planner.plan(mission.minds, knowledge, 2, mission.events)
    assert own["place"][0] == planner._places[0, 0]
    assert (own["place"][1:] == WAITS).all()


def seen_hall(robots: int) -> Mission:
    """Robots that have seen all of an empty hall with three stations."""
    mission = hall(robots, "distance", 100)
    mission.step()
    grids = mission.knowledge.grids
    cells = grids.frame.size
    low = np.zeros(1, dtype=np.int64)
    evidence = np.full((1, cells), -5000)
    grids.apply(0, np.arange(cells)[None].copy(), evidence, low, low + cells)
    return mission


def look_home(mission: Mission, step: int = 5) -> None:
    nothing = np.zeros(len(mission.minds), dtype=np.int64)
    mission.planner.look_home(mission.minds, mission.knowledge, nothing, nothing, step)


def test_who_runs_out_of_charge_on_its_way_turns_to_the_station_that_it_passes() -> None:
    mission = seen_hall(30)
    own, routes = mission.minds.own, mission.planner.table.state
    near, far = (
        mission.stations_m[0],
        int(np.hypot(*(mission.stations_m - mission.stations_m[0]).T).argmax()),
    )
    own["mode"][0], own["station"][0], own["place"][0] = CHARGE, far, NO_PLACE
    own["x_m"][0], own["y_m"][0] = near[0] + 2.0, near[1]
    routes["length"][0], routes["at"][0] = 40, 0
    own["charge"][0] = 1.0
    look_home(mission)
    assert own["station"][0] == far
    own["charge"][0] = 0.05
    look_home(mission)
    assert own["station"][0] == 0


def test_the_way_home_is_known_anew_before_it_has_to_be_taken() -> None:
    # Others may have come to the nearest station since it was last looked up.
    mission = seen_hall(30)
    own, rules = mission.minds.own, mission.planner._rules
    own["mode"], own["way_m"] = EXPLORE, 5.0
    needed = 5.0 * rules["share_per_m"][0] + rules["share_reserve"][0]
    nothing = np.zeros(30, dtype=np.int64)
    for charge, asks in ((needed + 0.01, 30), (needed + 0.3, 0)):
        own["charge"] = charge
        found = ask_ways(
            own, mission.knowledge.ear, nothing, nothing, mission.planner.table.state,
            mission.planner._home.state, rules, 5,
        )  # fmt: skip
        assert found == asks


def test_a_station_with_half_of_its_places_claimed_repels_more() -> None:
    mission = seen_hall(30)
    planner, knowledge = mission.planner, mission.knowledge
    routes = planner.table.state
    routes["need"], routes["wanted"], routes["map"] = 0, STATION, 0
    routes["need"][0] = 1
    costs = []
    for load in range(20):
        knowledge.heard["step"], knowledge.heard["station"] = 2, -1
        knowledge.heard["station"][0, :load] = 0
        weigh_stations(
            knowledge.heard, routes, knowledge.grids.status, mission.stations_m, planner._places,
            planner._queues, planner._rules, 2,
        )  # fmt: skip
        costs.append(int(planner._queues[0, 0]))
        assert planner._queues[0, 1] == 0
    more = np.diff(costs)
    assert costs[0] == 0
    assert (more[1:] >= more[:-1]).all()
    assert more[-1] > 3 * more[0] > 0
