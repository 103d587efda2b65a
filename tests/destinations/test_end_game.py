"""The end game: leaders wait, places that sensors cannot resolve are closed, dead claims fade."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from test_renewal import FAR, INSIDE, Desk

from swarmscout.core.enums import FREE, NOT_CANDIDATE, OVERDUE, REACHED, UNKNOWN, UNREACHABLE
from swarmscout.destinations.candidates import LOOK_STEPS
from swarmscout.minds.given_up import (
    FOR_GOOD,
    PART,
    STANDS,
    TRIES,
    avoided_until,
    nothing_given_up,
    remember,
)
from swarmscout.mission import build
from swarmscout.mission.mission import Mission
from swarmscout.mission.scenario import Scenario
from swarmscout.testing import small_world
from swarmscout.worlds.arrays import world_from_array

SLIVER = (11, 10)
OCCUPIED = 2


def sliver_desk(**renewal: Any) -> Desk:
    """Everything is known but for a corner, which makes one cell a frontier."""
    desk = Desk(**renewal)
    desk.label(slice(0, 12), slice(0, 12), FREE)
    desk.label(slice(11, 12), slice(11, 12), UNKNOWN)
    desk.label(slice(10, 11), slice(10, 12), OCCUPIED)
    assert desk.grids.frontiers(0).tolist() == [desk.frame.flat(*SLIVER)]
    return desk


def stand_at(desk: Desk, cell: tuple[int, int]) -> None:
    """The team reaches a cell, and drives back inside."""
    desk.head_for(cell)
    desk.put(0, cell)
    desk.decide()
    desk.put(0, INSIDE)


def test_a_leader_waits_while_its_only_frontier_is_avoided_and_at_last_for_good() -> None:
    desk = sliver_desk()
    stood: list[int] = []
    for _ in range(200):
        if desk.minds.destination[0] >= 0:
            stood.append(desk.number + 1)
            stand_at(desk, SLIVER)
        else:
            desk.decide()
    # It comes as soon as it may. The third time belongs to the second try, which lasts 60 steps.
    assert stood == [2, 34, 66, 98]
    mind = desk.minds.own[0]
    assert mind["destination"] == -1
    assert mind["hopeless"]
    assert len(desk.asked.views) == len(stood)


def test_waiting_costs_no_decision_and_ends_when_something_new_is_seen() -> None:
    desk = sliver_desk()
    for _ in range(STANDS):
        stand_at(desk, SLIVER)
        desk.number += 130
    asked = len(desk.asked.views)
    assert desk.decide(50) == []
    assert len(desk.asked.views) == asked
    desk.label(slice(0, 2), slice(0, 2), UNKNOWN)
    decisions = [desk.decide() for _ in range(LOOK_STEPS)]
    assert sum(map(len, decisions)) == 1
    assert (11, 10) not in desk.offered()


def test_who_hears_of_it_has_it_closed_and_so_is_what_lies_beside_it() -> None:
    desk = Desk()
    for _ in range(STANDS):
        stand_at(desk, FAR)
        desk.number += 130
    desk.minds.own["destination"] = -1
    desk.minds.own["mode"][3] = 0
    desk.decide()
    offered = {view.robot: view.frontiers.tolist() for view in desk.asked.views}
    for robot in (0, 3):
        assert len(offered[robot]) == 28 - 3
        # The place of FAR are the cells (8, 8) … (9, 9), of which three are frontiers.
        assert not [cell for cell in offered[robot] if min(cell) >= 8]


def test_a_destination_that_others_closed_is_dropped() -> None:
    desk = Desk()
    desk.head_for(FAR)
    desk.minds.given_up[0]["until"] = FOR_GOOD
    side = 2
    place = FAR[0] // side * 12 + FAR[1] // side
    desk.minds.given_up[0]["place"] = place
    (decision,) = desk.decide()
    assert decision.cause == "no frontier any more"
    assert FAR not in desk.offered()


def walled_desk() -> Desk:
    """A wall parts the room; robots stand on the left."""
    desk = Desk()
    desk.label(slice(0, 12), slice(6, 7), OCCUPIED)
    for robot in range(4):
        desk.put(robot, (5, 3))
    return desk


def test_what_no_route_reaches_is_not_offered_once_that_is_known() -> None:
    desk = walled_desk()
    assert desk.decide()[0].frontiers > 11, "at first nobody looks for routes"
    desk.planner.table.state["failed_until"][0] = 99
    (decision,) = desk.decide()
    assert decision.cause == "unreachable"
    assert desk.offered()
    assert max(col for _, col in desk.offered()) < 6
    assert desk.minds.own["doubts"].tolist() == [True, True, True, True], "all heard of it"


def test_without_a_reachable_frontier_nothing_is_decided_until_a_way_opens() -> None:
    desk = walled_desk()
    # On the left, all is known, down to the edge of the map.
    desk.label(slice(0, 12), slice(0, 6), FREE)
    desk.head_for(FAR)
    desk.planner.table.state["failed_until"][0] = 99
    assert desk.decide() == []
    desk.planner.table.state["failed_until"][0] = 0
    assert desk.decide(40) == []
    assert desk.asked.views == []
    assert desk.minds.own["hopeless"][0]
    desk.label(slice(5, 6), slice(6, 7), FREE)
    decisions = [d for _ in range(LOOK_STEPS) for d in desk.decide()]
    assert [d.cause for d in decisions] == ["none yet"]


@pytest.mark.parametrize(
    ("change", "over"),
    [
        ("nothing", True),
        ("a destination", False),
        ("a leader that has not looked", False),
        ("a lost leader", False),
        ("all charge", False),
        ("one that charges has heard of nothing", False),
        ("one that charges cannot drive", True),
    ],
)
def test_when_nobody_has_anything_left(change: str, over: bool) -> None:
    desk = sliver_desk()
    for _ in range(STANDS):
        stand_at(desk, SLIVER)
        desk.number += 130
    own, mobile = desk.minds.own, np.ones(4, dtype=np.bool_)
    if change == "a destination":
        own["destination"][1] = 3
    if change == "a leader that has not looked":
        own["hopeless"][0] = False
    if change == "a lost leader":
        own["leader"][2] = 1
    if change == "all charge":
        own["mode"] = 1
    if "one that charges" in change:
        desk.minds.given_up[3] = nothing_given_up(1)[0]
        mobile[3] = change != "one that charges cannot drive"
    args = desk.minds, desk.knowledge, desk.planner, mobile, desk.number
    assert desk.destinations.exhausted(*args) is over


def test_claims_of_a_silent_team_fade() -> None:
    desk = Desk()
    desk.minds.own["mode"][3] = 0
    desk.minds.own["destination"][3] = desk.frame.flat(*FAR)
    seen = []
    for _ in range(9):
        desk.minds.own["destination"][:3] = -1
        desk.decide()
        seen.append(len(desk.asked.views[-1].others.leaders))
        desk.minds.own["thinks"][3] = False
        desk.minds.own["sends"][3] = False
    assert seen == [1] * 6 + [0] * 3, "heard in step 1, it counts for silence_steps = 5 more"


@pytest.mark.parametrize(
    ("range_m", "reach_m", "cell_m", "expected"),
    [
        (1.0, 0.5, 0.5, 0.5),
        (0.9, 0.5, 0.5, 0.4),
        (0.3, 0.5, 0.5, 0.25),
        (0.3, 0.1, 0.5, 0.1),
        (1.0, 3.0, 0.25, 0.75),
        (np.inf, 3.0, 0.5, 3.0),
    ],
)
def test_reach_is_never_more_than_the_sensor_needs(
    range_m: float, reach_m: float, cell_m: float, expected: float
) -> None:
    given = {"renewal": {"reach_m": reach_m}, "map": {"cell_m": cell_m}}
    scenario = Scenario.model_validate(given)
    frame = build.make_frame(small_world(1), scenario)
    made = build.make_destinations(scenario, frame, None, None, None, range_m, 0.25)
    assert made._rules["reach_m"][0] == pytest.approx(expected)


CAUSES = st.sampled_from([REACHED, NOT_CANDIDATE, OVERDUE, UNREACHABLE])


@settings(max_examples=200, deadline=None)
@given(st.lists(st.tuples(st.integers(0, 5), CAUSES, st.booleans(), st.integers(0, 90))))
def test_what_is_remembered_of_few_places(told: list[tuple[int, int, bool, int]]) -> None:
    """Against a dictionary that forgets nothing."""
    table, known = nothing_given_up(1)[0], {}
    step = 0
    for place, why, ours, later in told:
        step += later
        remember(table, place, why, ours, 30, step)
        tries, stands, until, again = known.get(place, (0, 0, -1, -1))
        if again < step:
            tries, stands = tries + 1, stands + (why == REACHED)
            again = step + 30 * 2 ** (tries - 1)
            if stands == STANDS or tries == TRIES:
                until = again = FOR_GOOD
        if why in (OVERDUE, UNREACHABLE):
            until = max(until, again)
        known[place] = tries, stands, until, again
        for each in range(6):
            assert avoided_until(table, each) == known.get(each, (0, 0, -1, -1))[2]


def test_own_tries_are_remembered_in_a_full_table_and_what_is_closed_stays() -> None:
    table = nothing_given_up(1)[0]
    for step in (0, 31, 92):
        remember(table, 7, REACHED, False, 30, step)
    assert avoided_until(table, 7) == FOR_GOOD
    for place in range(1000, 9000):
        remember(table, place, REACHED, False, 30, 100)
    for place in range(20000, 20000 + PART):
        remember(table, place, OVERDUE, True, 30, 100)
    assert avoided_until(table, 7) == FOR_GOOD
    kept = [avoided_until(table, place) == 130 for place in range(20000, 20000 + PART)]
    assert all(kept)


def two_rooms() -> Any:
    """Rooms joined by a slit that no robot fits through, though its sensor sees into it."""
    free = np.zeros((140, 360), dtype=bool)
    free[20:120, 20:120] = True
    free[20:120, 240:340] = True
    free[76:82, 119:241] = True
    return world_from_array(free, 0.05, name="two rooms", start_m=(3.5, 3.5))


@pytest.mark.parametrize("linked", [True, False])
def test_a_mission_ends_when_nobody_has_a_reachable_frontier(linked: bool) -> None:
    keys = {"robots": 3, "steps": 1500, "destinations": "nearest", "battery": {"enabled": False}}
    links = None if linked else lambda step: np.eye(3, dtype=np.bool_)
    mission = Mission(Scenario.model_validate(keys), world=two_rooms(), links=links)
    decided = 0
    while not mission.done:
        mission.step()
        decided += len(mission.decisions)
    assert mission.end_reason in ("no reachable frontier left", "no frontier left")
    assert mission.step_number < 1200
    assert decided < 250
    assert mission.summary()["sensable_fraction"] > 0.9
