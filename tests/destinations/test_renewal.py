"""When a team needs a new destination, what it avoids then, and how members learn of it."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from known import exchange, knowledge_of, place

from swarmscout.core.enums import CAUSES, CHARGE, DROP, FREE, UNKNOWN
from swarmscout.core.errors import SelectorError
from swarmscout.core.events import EventLog
from swarmscout.core.grid import GridFrame
from swarmscout.core.recorder import Decision
from swarmscout.destinations.renewal import due_step
from swarmscout.destinations.selector import Choice
from swarmscout.destinations.view import LeaderView
from swarmscout.mapping.occupancy import OccupancyGrids
from swarmscout.minds.minds import blank_minds
from swarmscout.mission import build
from swarmscout.mission.scenario import Scenario

# A free square whose rim is all frontier: cells 2 … 9 of 12.
FAR, NEAR, INSIDE = (9, 9), (2, 2), (5, 5)


class Asked:
    """Chooses what it was told, or the first frontier; keeps its views."""

    def __init__(self) -> None:
        self.next: Any = None
        self.views: list[LeaderView] = []

    def choose(self, view: LeaderView, memory: Any) -> Any:
        self.views.append(view)
        if self.next is not None:
            return self.next
        row, col = view.frontiers[0].tolist()
        return Choice((row, col), memory=(memory or 0) + 1)


class Desk:
    """A team of three (led by robot 0) and a robot alone (3), before decisions only."""

    def __init__(self, literal: bool = False, **renewal: Any) -> None:
        if literal:
            renewal = {"rule": "reached", "avoid_steps": 0, **renewal}
        scenario = Scenario.model_validate({"robots": 4, "renewal": renewal})
        self.frame = GridFrame(0.0, 0.0, 0.5, 12, 12)
        model = build.make_model(scenario)
        self.grids = OccupancyGrids(self.frame, 1, model, 8)
        self.label(slice(2, 10), slice(2, 10), FREE)
        self.minds = blank_minds(4)
        self.minds.own["team"][:3] = self.minds.own["leader"][:3] = 0
        self.minds.own["size"][:3] = 3
        self.minds.own["mode"][3] = CHARGE
        place(self.minds, self.frame.centre_of(*INSIDE))
        self.knowledge = knowledge_of(self.minds, self.grids)
        self.minds.own["charge"] = 1.0
        self.planner = build.make_planner(scenario, self.frame, np.zeros((1, 2)))
        self.asked = Asked()
        self.destinations = build.make_destinations(scenario, self.frame, None)
        self.destinations.selector = self.asked
        self.number = 0
        self.events: list[list[int]] = []

    def label(self, rows: slice, columns: slice, label: int) -> None:
        cells = np.zeros((12, 12), dtype=bool)
        cells[rows, columns] = True
        flat = np.flatnonzero(cells)
        target = {FREE: -3000, UNKNOWN: 0}.get(label, 3000)
        change = target - self.grids.evidence[0, flat].astype(np.int64)
        many = np.array([len(flat)])
        self.grids.apply(0, flat[None], change[None], 0 * many, many)

    def put(self, robot: int, cell: tuple[int, int], aside_m: float = 0.0) -> None:
        x_m, y_m = self.frame.centre_of(*cell)
        place(self.minds, (x_m + aside_m, y_m), slice(robot, robot + 1))

    def head_for(self, cell: tuple[int, int], due: int = 10**6) -> None:
        self.minds.own["destination"][:3] = self.frame.flat(*cell)
        self.minds.own["due_at"][:3] = due

    def decide(self, steps: int = 1) -> list[Decision]:
        decisions: list[Decision] = []
        for _ in range(steps):
            self.number += 1
            exchange(self.knowledge, self.minds, self.number)
            log = EventLog(4)
            decisions = self.destinations.decide(
                self.minds, self.knowledge, self.planner, self.number, log
            )
            self.events = log.entries.tolist()
        return decisions

    def offered(self) -> list[tuple[int, int]]:
        return [tuple(cell) for cell in self.asked.views[-1].frontiers.tolist()]


def test_the_first_destination() -> None:
    desk = Desk()
    (decision,) = desk.decide()
    assert (decision.cause, decision.leader, decision.cell) == ("none yet", 0, NEAR)
    assert decision.frontiers == len(desk.offered()) == 28
    flat = desk.frame.flat(*NEAR)
    assert desk.minds.destination.tolist() == [flat, flat, flat, -1], "members know at once"
    assert desk.events == []
    assert desk.decide() == [], "and none is needed until there is a cause"


@pytest.mark.parametrize("literal", [False, True])
@pytest.mark.parametrize("member", [0, 1, 2])
@pytest.mark.parametrize(("aside_m", "reached"), [(0.0, True), (0.5, True), (-0.501, False)])
def test_reached_by_any_member(literal: bool, member: int, aside_m: float, reached: bool) -> None:
    desk = Desk(literal)
    desk.head_for(FAR)
    desk.put(member, FAR, aside_m)
    decisions = desk.decide()
    assert [decision.cause for decision in decisions] == ["reached"] * reached
    if reached:
        assert desk.asked.views[0].previous == FAR
        code = CAUSES.index("reached")
        assert desk.events == [[DROP, 0, code, desk.frame.flat(*FAR)]]


def test_who_does_not_count_as_having_reached_it() -> None:
    desk = Desk()
    desk.head_for(FAR)
    desk.put(3, FAR)
    assert desk.decide() == [], "another team's robot"
    desk.put(1, FAR)
    desk.minds.own["thinks"][1] = False
    assert desk.decide() == [], "a member that is silent"
    desk.minds.own["thinks"][1] = True
    desk.minds.own["destination"][1] = desk.frame.flat(*NEAR)
    assert desk.decide() == [], "a member that heads elsewhere"
    assert desk.minds.destination[1] == desk.frame.flat(*FAR), "which then hears where to go"
    assert len(desk.decide()) == 1


@pytest.mark.parametrize(
    ("what", "cause", "literal_cause"),
    [
        ("no frontier", "no frontier any more", None),
        ("occupied", "no frontier any more", None),
        ("overdue", "overdue", None),
        ("unreachable", "unreachable", "unreachable"),
        ("nothing", None, None),
    ],
)
@pytest.mark.parametrize("literal", [False, True])
def test_causes(what: str, cause: str | None, literal_cause: str | None, literal: bool) -> None:
    desk = Desk(literal)
    desk.head_for(FAR, due=desk.number if what == "overdue" else 10**6)
    if what == "no frontier":
        desk.label(slice(8, 12), slice(8, 12), FREE)
    if what == "occupied":
        desk.label(slice(9, 10), slice(9, 10), 2)
    if what == "unreachable":
        desk.planner.table.state["failed_until"][0] = 99
    expected = literal_cause if literal else cause
    assert [decision.cause for decision in desk.decide()] == [expected] * (expected is not None)


def test_a_member_without_a_route_is_no_cause() -> None:
    desk = Desk()
    desk.head_for(FAR)
    desk.planner.table.state["failed_until"][1] = 99
    assert desk.decide() == []


def test_overdue_comes_after_three_times_the_straight_time_and_thirty_steps() -> None:
    assert due_step(7, 4.0, 0.2, 3.0, 30) == 7 + 60 + 30
    desk = Desk()
    desk.asked.next = Choice(FAR)
    (decision,) = desk.decide()
    due = due_step(1, decision.distance_m, 0.2, 3.0, 30)
    assert desk.minds.own["due_at"][:3].tolist() == [due] * 3
    desk.asked.next = None
    assert desk.decide(due - 1) == []
    assert [d.cause for d in desk.decide()] == ["overdue"]
    assert desk.number == due + 1


@pytest.mark.parametrize(
    ("cause", "avoided"),
    [("reached", True), ("unreachable", True), ("overdue", True), ("none", False)],
)
def test_what_was_given_up_is_avoided_for_thirty_steps(cause: str, avoided: bool) -> None:
    desk = Desk()
    desk.head_for(FAR, due=0 if cause == "overdue" else 10**6)
    if cause == "reached":
        desk.put(1, FAR)
    if cause == "unreachable":
        desk.planner.table.state["failed_until"][0] = 99
    desk.decide()
    desk.planner.table.state["failed_until"][0] = 0
    given_up = desk.number
    for later in range(33):
        # Asked anew in each step, and led by another member from the tenth step on.
        leader = 0 if later < 10 else 2
        desk.minds.own["leader"][:3] = leader
        desk.minds.own["destination"][:3] = -1
        desk.put(1, INSIDE)
        desk.decide()
        assert desk.asked.views[-1].robot == leader
        gone = avoided and desk.number <= given_up + 30
        assert (FAR not in desk.offered()) is gone


def test_another_team_does_not_avoid_it() -> None:
    desk = Desk()
    desk.minds.own["mode"][3] = 0
    desk.head_for(FAR)
    desk.put(1, FAR)
    desk.decide()
    by_robot = {view.robot: view.frontiers.tolist() for view in desk.asked.views}
    assert list(FAR) not in by_robot[0]
    assert list(FAR) in by_robot[3]


def test_literal_avoids_nothing() -> None:
    desk = Desk(literal=True)
    desk.head_for(FAR)
    desk.put(0, FAR)
    desk.decide()
    assert FAR in desk.offered()


def test_without_any_frontier_nothing_is_asked() -> None:
    desk = Desk()
    desk.label(slice(0, 12), slice(0, 12), FREE)
    assert desk.decide() == []
    assert desk.asked.views == []


def test_memory_belongs_to_the_robot_that_decided() -> None:
    desk = Desk()
    for _ in range(3):
        desk.minds.own["destination"][:3] = -1
        desk.decide()
    desk.minds.own["leader"][:3] = 1
    desk.minds.own["destination"][:3] = -1
    desk.decide()
    assert desk.destinations.memories == [3, 1, None, None]


class Fails:
    def choose(self, view: LeaderView, memory: Any) -> Choice:
        raise RuntimeError("out of luck")


@pytest.mark.parametrize(
    ("answer", "says"),
    [
        (None, "returned NoneType, not a Choice (step 1, robot 0)"),
        ((2, 2), "returned tuple, not a Choice"),
        (Choice(INSIDE), "chose cell (5, 5), which is no frontier of robot 0's view in step 1"),
        (Choice((-1, 2)), "no frontier"),
        (Choice((2, 99)), "no frontier"),
        (Choice((2.0, 2.0)), "no frontier"),  # type: ignore[arg-type]
        (Choice((2.9, 2.1)), "no frontier"),  # type: ignore[arg-type]
        (Choice(("2", "2")), "no frontier"),  # type: ignore[arg-type]
        (Choice(None), "no frontier"),  # type: ignore[arg-type]
        (Choice((2, 2, 2)), "no frontier"),  # type: ignore[arg-type]
        (Choice(tuple(np.array([2, 2]))), ""),
    ],
)
def test_answers_outside_the_contract_stop_the_mission(answer: Any, says: str) -> None:
    desk = Desk()

    class Fixed:
        def choose(self, view: LeaderView, memory: Any) -> Any:
            return answer

    desk.destinations.selector = Fixed()
    if not says:
        assert desk.decide()[0].cell == NEAR
        return
    with pytest.raises(SelectorError) as caught:
        desk.decide()
    assert says in str(caught.value)


def test_a_cell_that_is_avoided_is_not_to_be_chosen() -> None:
    desk = Desk()
    desk.head_for(FAR)
    desk.put(0, FAR)
    desk.asked.next = Choice(FAR)
    with pytest.raises(SelectorError, match=r"choose one of view\.frontiers"):
        desk.decide()


def test_a_selector_that_fails_is_named() -> None:
    desk = Desk()
    desk.destinations.selector = Fails()
    with pytest.raises(SelectorError, match="failed in step 1 for robot 0: RuntimeError: out of"):
        desk.decide()
