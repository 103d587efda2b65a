"""Members that fan out take different cells, each alone, as the slow definition says."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from swarmscout import Mission, Scenario, load_world
from swarmscout.core.enums import CHARGE
from swarmscout.core.grid import GridFrame
from swarmscout.destinations.dispersal import fan_out
from swarmscout.minds.minds import (
    DESTINATION,
    LEADER,
    MODE,
    TARGET,
    TEAM,
    Minds,
    blank_minds,
)
from swarmscout.robots.bodies import heading_table

REACH_M, FAN_M, APART_M, TURN_M = 0.5, 3.0, 1.0, 0.7
FRONTIER_BIT = 4
HEADINGS = heading_table()


def some_minds(rng: np.random.Generator, frame: GridFrame, shared: bool) -> Minds:
    """Two teams, some robots out of charge or charging, that look all ways."""
    robots = int(rng.integers(2, 9))
    minds = blank_minds(robots, shared=shared)
    minds.state[:, TEAM] = rng.integers(0, 2, robots)
    minds.state[:, LEADER] = minds.state[:, TEAM]
    minds.state[:, MODE] = np.where(rng.random(robots) < 0.1, CHARGE, 0)
    minds.sending[:] = rng.random(robots) < 0.9
    minds.reading[:, 0] = rng.uniform(0.0, frame.cell_m * frame.columns, robots)
    minds.reading[:, 1] = rng.uniform(0.0, frame.cell_m * frame.rows, robots)
    minds.reading[:, 2] = rng.integers(0, len(HEADINGS), robots)
    goals = rng.integers(-1, frame.size, 2)
    minds.heard_reading[:] = minds.reading
    minds.state[:, DESTINATION] = goals[minds.team]
    minds.state[:, TARGET] = minds.state[:, DESTINATION]
    return minds


def fan(minds: Minds, frame: GridFrame, status: NDArray[np.uint8], links: Any) -> None:
    scratch = np.zeros((2, minds.robots), dtype=np.int64)
    fan_out(
        minds.state, minds.sending, links, minds.heard_reading, status, FRONTIER_BIT, HEADINGS,
        np.zeros(frame.size, dtype=np.int64), np.zeros((minds.robots, frame.size)), scratch[0],
        scratch[1], 0.0, 0.0, frame.cell_m, frame.rows, frame.columns, REACH_M, FAN_M, APART_M,
        TURN_M,
    )  # fmt: skip


def by_definition(
    minds: Minds, frame: GridFrame, status: NDArray[np.uint8], links: Any, robot: int
) -> int:
    """One robot's target, worked out slowly."""
    goal = int(minds.state[robot, DESTINATION])
    if not minds.sending[robot] or goal < 0 or minds.mode[robot] == CHARGE:
        return goal
    k = minds.row(robot)
    team = [
        j
        for j in range(minds.robots)
        if minds.team[j] == minds.team[robot]
        and minds.sending[j]
        and (minds.listeners == 1 or j == robot or links[robot, j])
    ]
    if len(team) == 1:
        return goal

    def away(j: int, cell: int) -> float:
        x_m, y_m = frame.centre_of(*frame.unflat(cell))
        return math.dist(minds.heard_reading[k, j, :2], (x_m, y_m))

    def effort(j: int, cell: int) -> float:
        x_m, y_m = frame.centre_of(*frame.unflat(cell))
        at_x_m, at_y_m, ticks = minds.heard_reading[k, j, :3]
        if not away(j, cell):
            return 0.0
        turn = math.atan2(y_m - at_y_m, x_m - at_x_m) - 2.0 * math.pi * ticks / len(HEADINGS)
        return away(j, cell) + TURN_M * 2.0 * abs(math.sin(0.5 * turn))

    def gap(a: int, b: int) -> float:
        return frame.cell_m * math.dist(frame.unflat(a), frame.unflat(b))

    cells = [
        cell
        for cell in range(frame.size)
        if status[k, cell] & FRONTIER_BIT
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
    minds = some_minds(rng, frame, shared)
    maps = minds.listeners
    status = np.where(rng.random((maps, frame.size)) < 0.2, FRONTIER_BIT, 0).astype(np.uint8)
    links = rng.random((minds.robots, minds.robots)) < 0.7
    wanted = [by_definition(minds, frame, status, links, i) for i in range(minds.robots)]
    fan(minds, frame, status, links)
    assert minds.target.tolist() == wanted


@settings(max_examples=100, deadline=None)
@given(st.integers(0, 2**32 - 1))
def test_who_heard_the_same_never_takes_the_same_cell(seed: int) -> None:
    rng = np.random.default_rng(seed)
    frame = GridFrame(0.0, 0.0, 0.5, 16, 16)
    minds = some_minds(rng, frame, shared=True)
    status = np.where(rng.random((1, frame.size)) < 0.3, FRONTIER_BIT, 0).astype(np.uint8)
    fan(minds, frame, status, np.zeros((1, 1), dtype=np.bool_))
    for team in (0, 1):
        who = (minds.team == team) & minds.sending & (minds.mode != CHARGE)
        goal = minds.state[who, DESTINATION].max(initial=-1)
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
