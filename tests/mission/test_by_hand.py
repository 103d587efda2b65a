"""What a hand writes into a mission is checked before compiled code gets it."""

from __future__ import annotations

from operator import attrgetter
from typing import Any

import numpy as np
import pytest

from swarmscout import Mission, Scenario, ScenarioError, SelectorError, WorldError
from swarmscout.robots.parameters import BodyParameters
from swarmscout.worlds.arrays import world_from_ascii

WORLD = world_from_ascii("""
##########
#........#
#........#
####.....#
#........#
##########
""", resolution_m=1.0, pieces=10)  # fmt: skip


@pytest.fixture
def mission() -> Mission:
    mission = Mission(Scenario(robots=3, steps=50), world=WORLD)
    mission.step()
    return mission


@pytest.mark.parametrize(
    ("x", "y", "says"),
    [
        (np.nan, 3.0, "outside the world"),
        (1e12, 3.0, r"\[1\] = \(1e\+12, 3\) m lies outside the world: x from 0 to 10 m"),
        (3.0, -1e300, "outside the world"),
        (np.inf, np.inf, "outside the world"),
        (10.0, 3.0, "outside the world"),
        (2.0, 2.5, "is in a wall"),
    ],
)
def test_places_where_no_robot_can_be(mission: Mission, x: float, y: float, says: str) -> None:
    before, step = mission.bodies.position.copy(), mission.step_number
    mission.bodies.position[1] = x, y
    for _ in range(2):
        with pytest.raises(ScenarioError, match=says):
            mission.step()
    assert mission.step_number == step
    mission.bodies.position[:] = before
    mission.step()


def test_a_robot_can_be_put_elsewhere(mission: Mission) -> None:
    mission.bodies.position[2] = 7.5, 3.5
    mission.step()
    assert np.hypot(*(mission.bodies.position[2] - (7.5, 3.5))) < 0.3


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("heading", np.array([0, 10**9, 0])),
        ("heading", np.array([-1, 0, 0])),
        ("heading", np.zeros(3)),
        ("position", np.ones((3, 2), dtype=np.float32)),
        ("position", np.ones((2, 2))),
        ("position", np.ones((2, 3)).T),
    ],
)
def test_other_arrays(mission: Mission, name: str, value: Any) -> None:
    setattr(mission.bodies, name, value)
    with pytest.raises(ScenarioError, match=f"mission.bodies.{name}"):
        mission.step()


@pytest.mark.parametrize(
    ("name", "value"), [("leader", 3), ("leader", -1), ("destination", 10**9), ("destination", -2)]
)
def test_minds_that_point_nowhere(mission: Mission, name: str, value: int) -> None:
    column = getattr(mission.minds, name)
    before = column.copy()
    column[1] = value
    with pytest.raises(ScenarioError, match=rf"mission.minds.{name}\[1\] = {value}: expected"):
        mission.step()
    column[:] = before
    mission.step()


NUMBERS = ("partner", "place", "station", "mode", "cause", "heading", "aim")


@pytest.mark.parametrize("value", [-(2**62), -100, 10**6, 2**40, 2**62])
@pytest.mark.parametrize("name", NUMBERS)
def test_numbers_by_which_kernels_find_something(mission: Mission, name: str, value: int) -> None:
    before = mission.minds.own[name][1]
    mission.minds.own[name][1] = value
    with pytest.raises(ScenarioError, match=rf"minds.*{name}.*\[1\] = {value}: expected"):
        mission.step()
    mission.minds.own[name][1] = before
    mission.step()


@pytest.mark.parametrize("value", [-1, 10**6, -(2**62), 2**62])
@pytest.mark.parametrize(
    "name",
    [
        "knowledge.ear", "knowledge.rows", "knowledge.listeners", "knowledge.groups",
        "knowledge.versions", "log.length", "log.dropped",
    ],
)  # fmt: skip
def test_where_robots_find_what_they_know(mission: Mission, name: str, value: int) -> None:
    array = attrgetter(name)(mission)
    before = array.copy()
    array[...] = value
    with pytest.raises(ScenarioError, match=f"mission.{name} was changed by hand"):
        mission.step()
    array[...] = before
    mission.step()


@pytest.mark.parametrize("value", [-2, 10**6, -(2**62), 2**62])
@pytest.mark.parametrize("name", ["bounds", "counts"])
def test_numbers_of_the_maps(mission: Mission, name: str, value: int) -> None:
    array = getattr(mission.knowledge.grids, name)
    before = array.copy()
    array[...] = value
    with pytest.raises(ScenarioError, match=rf"mission.knowledge.grids.{name} holds {value}"):
        mission.step()
    array[...] = before
    mission.step()


def test_a_map_with_more_frontiers_than_are_counted(mission: Mission) -> None:
    count = len(mission.map.frontiers())
    mission.knowledge.grids.status[...] = 4
    mission.knowledge.grids.bounds[...] = 0, mission.frame.rows - 1
    assert len(mission.map.frontiers()) == count < mission.frame.size


def test_evidence_is_read_only_between_steps(mission: Mission) -> None:
    for _ in range(2):
        for array in (mission.log.cells, mission.log.increments):
            with pytest.raises(ValueError, match="read-only"):
                array[0] = 10**6
        mission.step()


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("own", np.zeros(3)),
        ("avoided_next", np.zeros(3, dtype=np.int32)),
        ("avoided", np.zeros((3, 1, 2), dtype=np.int64)),
        ("given_up", np.zeros((3, 256))),
    ],
)
def test_other_arrays_of_minds(mission: Mission, name: str, value: Any) -> None:
    setattr(mission.minds, name, value)
    with pytest.raises(ScenarioError, match=rf"mission.minds.{name} is .*, expected"):
        mission.step()


@pytest.mark.parametrize(
    "links", [None, np.ones((2, 2), dtype=np.bool_), np.ones(3), [[1], [1, 2]], "all"]
)
def test_links_of_a_wrong_shape(links: Any) -> None:
    mission = Mission(Scenario(robots=3, steps=5), world=WORLD, links=lambda _: links)
    with pytest.raises(ScenarioError, match=r"links\(1\) returned .* expected bool\[3, 3\]"):
        mission.step()


def test_links_are_a_function() -> None:
    with pytest.raises(ScenarioError, match="expected a function of the step"):
        Mission(Scenario(robots=3), world=WORLD, links=np.ones((3, 3)))  # type: ignore[arg-type]
    mission = Mission(Scenario(robots=3), world=WORLD, links=lambda _: np.ones((3, 3), dtype=int))
    mission.step()


class NoSelector:
    pass


@pytest.mark.parametrize(
    ("given", "keys", "error", "says"),
    [
        ("lava-tube", {}, ScenarioError, r"Mission\(Scenario\(world='lava-tube'\)\)"),
        (None, {}, ScenarioError, "made of a Scenario, not of a NoneType"),
        (Scenario(), {"seed": -1}, ScenarioError, "'seed' = -1"),
        (Scenario(), {"seed": "x"}, ScenarioError, "'seed' = 'x'"),
        (Scenario(), {"world": "no-such"}, WorldError, "unknown world"),
        (Scenario(), {"world": np.ones((3, 3))}, WorldError, "not by a ndarray"),
        (Scenario(), {"selector": NoSelector()}, SelectorError, "selector is a NoSelector"),
        (Scenario(), {"selector": NoSelector}, SelectorError, "the class NoSelector"),
    ],
)
def test_wrong_arguments(given: Any, keys: Any, error: type[Exception], says: str) -> None:
    with pytest.raises(error, match=says):
        Mission(given, **keys)


@pytest.mark.parametrize(
    ("keys", "says"),
    [
        ({"robots": -1}, "Scenario: key 'robots' = -1: should be greater than or equal to 1"),
        ({"robotts": 3}, "Scenario: unknown key 'robotts': did you mean 'robots'?"),
        ({"teams": {"desired": 3}}, "did you mean 'desired_size'?"),
        ({"teams": 3}, "key 'teams' = 3: it is a section, give its keys"),
        ({"world": np.ones((99, 99))}, "key 'world' = a ndarray: should be a valid string"),
        ({"map": {"p_free": 0.9}}, "p_free = 0.9 must be below 0.5"),
    ],
)
def test_scenarios_made_in_python(keys: Any, says: str) -> None:
    with pytest.raises(ScenarioError) as caught:
        Scenario(**keys)
    assert says in str(caught.value)
    assert "\n" not in str(caught.value)


def test_sections_made_in_python() -> None:
    with pytest.raises(ScenarioError, match="BodyParameters: key 'radius_m' = -1"):
        BodyParameters(radius_m=-1)
    with pytest.raises(ScenarioError, match=r"give keys by name, as Scenario\(world=…\)"):
        Scenario("paper")  # type: ignore[call-arg]
    assert Scenario(body=BodyParameters(radius_m=0.2)).body.radius_m == 0.2


def test_a_mission_shows_itself_in_a_line(mission: Mission) -> None:
    assert repr(mission).startswith("<Mission: 3 robots in ascii, quantile, seed 0, step 1 of 50, ")
    for name in ("bodies", "minds", "step_number", "end_reason", "map", "stations_m"):
        assert name in (Mission.__doc__ or "")
        assert hasattr(mission, name)
