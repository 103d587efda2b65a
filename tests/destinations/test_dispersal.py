"""Members that fan out take different cells, each alone, as the slow definition says."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from known import exchange, knowledge_of
from numpy.typing import NDArray

from swarmscout import Mission, Scenario, load_world
from swarmscout.comms.knowledge import Knowledge
from swarmscout.core.enums import CHARGE
from swarmscout.core.grid import GridFrame
from swarmscout.destinations.dispersal import FAN, fan_out
from swarmscout.mapping.log_odds import InverseSensorModel
from swarmscout.mapping.occupancy import OccupancyGrids
from swarmscout.minds.minds import Minds, blank_minds
from swarmscout.robots.bodies import heading_table
from swarmscout.worlds import world_from_ascii

REACH_M, FAN_M, APART_M, TURN_M, KEEP_M = 0.5, 3.0, 1.0, 0.7, 0.9
FRONTIER_BIT = 4
STEP = 3
HALL = """
##############################
#S.......#.........#.........#
#........#.........#.........#
#........#.........#.........#
#........#.........#.........#
####..#######..#######..######
#............................#
#............................#
#............................#
#######..#######..#######..###
#........#.........#.........#
#........#.........#.........#
#........#.........#.........#
##############################
"""
MODEL = InverseSensorModel(-1, 1, -9, 9, -1, 1, 0.0)
HEADINGS = heading_table()


def some_minds(rng: np.random.Generator, frame: GridFrame, shared: bool) -> tuple[Minds, Knowledge]:
    """Two teams, some robots out of charge or charging, that look all ways and have met."""
    robots = int(rng.integers(2, 9))
    minds = blank_minds(robots)
    own = minds.own
    own["team"] = own["leader"] = rng.integers(0, 2, robots)
    own["mode"] = np.where(rng.random(robots) < 0.1, CHARGE, 0)
    own["thinks"] = own["sends"] = rng.random(robots) < 0.9
    own["x_m"] = rng.uniform(0.0, frame.cell_m * frame.columns, robots)
    own["y_m"] = rng.uniform(0.0, frame.cell_m * frame.rows, robots)
    own["heading"] = rng.integers(0, len(HEADINGS), robots)
    goals = rng.integers(-1, frame.size, 2)
    own["destination"] = goals[minds.team]
    own["target"] = np.where(
        rng.random(robots) < 0.5, minds.destination, rng.integers(0, frame.size, robots)
    )
    knowledge = knowledge_of(minds, OccupancyGrids(frame, 1, MODEL, 8))
    exchange(knowledge, minds, STEP, None if shared else rng.random((robots, robots)) < 0.7)
    knowledge.tell(minds, STEP)
    own["target"] = minds.destination  # As shared in this step; beacons tell the last one.
    return minds, knowledge


def fan(minds: Minds, knowledge: Knowledge, status: NDArray[np.uint8]) -> None:
    rules = np.zeros(1, dtype=FAN)
    frame = knowledge.grids.frame
    for name in ("origin_x_m", "origin_y_m", "cell_m", "rows", "columns"):
        rules[name] = getattr(frame, name)
    rules["candidate_bit"], rules["reach_m"], rules["fan_m"] = FRONTIER_BIT, REACH_M, FAN_M
    rules["apart_m"], rules["turn_m"], rules["keep_m"] = APART_M, TURN_M, KEEP_M
    fan_out(
        minds.own, knowledge.ear, knowledge.heard, knowledge.notices, status, HEADINGS, rules, STEP
    )


def by_definition(minds: Minds, knowledge: Knowledge, status: NDArray[np.uint8], robot: int) -> int:
    """One robot's target, worked out slowly."""
    frame = knowledge.grids.frame
    goal = int(minds.destination[robot])
    if not minds.thinking[robot] or goal < 0 or minds.mode[robot] == CHARGE:
        return goal
    row = knowledge.ear[robot]
    heard = knowledge.heard[row]
    team = [
        j
        for j in range(len(minds))
        if minds.team[j] == minds.team[robot] and heard["step"][j] == STEP
    ]
    if len(team) == 1:
        return goal

    def away(j: int, cell: int) -> float:
        x_m, y_m = frame.centre_of(*frame.unflat(cell))
        return math.dist((heard["x_m"][j], heard["y_m"][j]), (x_m, y_m))

    def effort(j: int, cell: int) -> float:
        x_m, y_m = frame.centre_of(*frame.unflat(cell))
        at_x_m, at_y_m, ticks = (heard[name][j] for name in ("x_m", "y_m", "heading"))
        change = 0.0 if cell == heard["target"][j] else KEEP_M
        if not away(j, cell):
            return change
        turn = math.atan2(y_m - at_y_m, x_m - at_x_m) - 2.0 * math.pi * ticks / len(HEADINGS)
        return change + away(j, cell) + TURN_M * 2.0 * abs(math.sin(0.5 * turn))

    def gap(a: int, b: int) -> float:
        return frame.cell_m * math.dist(frame.unflat(a), frame.unflat(b))

    cells = [
        cell
        for cell in range(frame.size)
        if status[row, cell] & FRONTIER_BIT
        and gap(cell, goal) <= FAN_M + 1e-9
        and min(away(j, cell) for j in team) > REACH_M
    ]
    targets = {min(team, key=lambda j: effort(j, goal)): goal}
    while True:
        pairs = [
            (effort(j, cell), j, cell)
            for j in team
            if j not in targets
            for cell in cells
            if all(gap(cell, other) >= APART_M - 1e-9 for other in targets.values())
        ]
        if not pairs:
            return targets.get(robot, goal)
        _, j, cell = min(pairs)
        targets[j] = cell


@settings(max_examples=150, deadline=None)
@given(st.integers(0, 2**32 - 1), st.booleans())
def test_targets_follow_the_definition(seed: int, shared: bool) -> None:
    rng = np.random.default_rng(seed)
    frame = GridFrame(0.0, 0.0, 0.5, *rng.integers(4, 20, 2).tolist())
    minds, knowledge = some_minds(rng, frame, shared)
    shape = (len(knowledge.heard), frame.size)
    status = np.where(rng.random(shape) < 0.2, FRONTIER_BIT, 0).astype(np.uint8)
    wanted = [by_definition(minds, knowledge, status, i) for i in range(len(minds))]
    fan(minds, knowledge, status)
    assert minds.target.tolist() == wanted


@settings(max_examples=100, deadline=None)
@given(st.integers(0, 2**32 - 1))
def test_who_heard_the_same_never_takes_the_same_cell(seed: int) -> None:
    rng = np.random.default_rng(seed)
    frame = GridFrame(0.0, 0.0, 0.5, 16, 16)
    minds, knowledge = some_minds(rng, frame, shared=True)
    status = np.where(rng.random((1, frame.size)) < 0.3, FRONTIER_BIT, 0).astype(np.uint8)
    fan(minds, knowledge, status)
    for team in (0, 1):
        who = (minds.team == team) & minds.thinking & (minds.mode != CHARGE)
        goal = minds.destination[who].max(initial=-1)
        own = minds.target[who]
        others = [int(cell) for cell in own if cell != goal]
        if goal >= 0 and len(own) > 1:
            assert len(set(others)) == len(others)
            assert goal in minds.target[minds.team == team]
        for cell in others:
            assert status[0, cell] & FRONTIER_BIT
            assert frame.cell_m * math.dist(frame.unflat(cell), frame.unflat(goal)) <= FAN_M


def test_shared_members_all_drive_to_the_destination() -> None:
    mission = Mission(Scenario(robots=9, steps=60), world=load_world("lava-tube-small"))
    while not mission.done:
        mission.step()
        assert mission.minds.target.tolist() == mission.minds.destination.tolist()


@pytest.mark.parametrize("selector", ["quantile", "nearest"])
def test_a_team_that_fans_out_explores_more(selector: str) -> None:
    world = load_world("lava-tube-small")
    area = {
        members: sum(
            Mission(
                Scenario.model_validate(
                    {
                        "steps": 150,
                        "seed": seed,
                        "destinations": selector,
                        "teams": {"members": members},
                    }
                ),
                world=world,
            ).run()["explored_m2"]
            for seed in range(4)
        )
        for members in ("shared", "fan")
    }
    assert area["fan"] > 1.2 * area["shared"]


def test_two_members_do_not_swap_their_targets_for_ever() -> None:
    world = world_from_ascii(HALL, 0.5, pieces=5)
    scenario = Scenario.model_validate(
        {
            "robots": 2,
            "steps": 900,
            "seed": 26,
            "destinations": "multi-criteria",
            "teams": {"desired_size": 2, "members": "fan"},
            "battery": {"enabled": False},
        }
    )
    summary = Mission(scenario, world=world).run()
    assert summary["explored_fraction"] > 0.98


def test_of_two_cells_that_are_about_as_good_a_member_keeps_its_own() -> None:
    frame = GridFrame(0.0, 0.0, 0.5, 16, 16)
    minds = blank_minds(2)
    own = minds.own
    own["team"] = own["leader"] = 0
    own["x_m"], own["y_m"] = [3.75, 4.25], [3.75, 3.75]
    goal, other = frame.flat(12, 6), frame.flat(12, 9)
    own["destination"] = goal
    status = np.zeros((1, frame.size), dtype=np.uint8)
    status[0, [goal, other]] = FRONTIER_BIT
    # Each looks at what is the other one's: without what it costs to change they would swap.
    for targets in ([goal, other], [other, goal]):
        own["heading"] = [600, 1200]
        own["target"] = targets
        knowledge = knowledge_of(minds, OccupancyGrids(frame, 1, MODEL, 8))
        exchange(knowledge, minds, STEP)
        knowledge.tell(minds, STEP)
        own["target"] = goal
        fan(minds, knowledge, status)
        assert minds.target.tolist() == targets
