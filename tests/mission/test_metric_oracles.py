"""Overlap and map accuracy equal a recount, cell by cell, from what was recorded and the truth."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from tape import Tape, scenario_of, small_world

from swarmscout.core.enums import FREE, OCCUPIED, UNKNOWN
from swarmscout.core.grid import GridFrame
from swarmscout.mapping.log_odds import log_odds_of
from swarmscout.mission.metrics import Judge, map_truth
from swarmscout.mission.mission import Mission
from swarmscout.robots.bodies import place_bodies
from swarmscout.worlds.arrays import world_from_ascii

CASES: list[dict[str, Any]] = [
    {"robots": 1},
    {"robots": 2, "start": "spread"},
    {"robots": 8, "body": {"position_noise_m": 0.3, "heading_noise_deg": 10.0}},
    {"robots": 5, "map": {"cell_m": 0.25}, "sensor": {"noise_m": 0.0}},
]


@pytest.fixture(scope="module", params=CASES, ids=str)
def flown(request: pytest.FixtureRequest) -> tuple[Mission, Tape]:
    """A mission with evidence recorded: robots have maps of their own, and hear each other."""
    tape = Tape()
    given = scenario_of(request.param, steps=60, radio={"model": "disc", "range_m": 1e6})
    mission = Mission(given, world=small_world(2), recorder=tape)
    mission.run()
    return mission, tape


def test_overlap_is_the_share_of_cells_that_several_robots_saw(flown: tuple[Mission, Tape]) -> None:
    mission, tape = flown
    robots_of: dict[int, set[int]] = {}
    for record in tape.records:
        for robot, cell, _ in [] if record.evidence is None else record.evidence.tolist():
            robots_of.setdefault(cell, set()).add(robot)
    several = sum(len(robots) > 1 for robots in robots_of.values())
    assert tape.summary is not None
    assert tape.summary["overlap_ratio"] == several / len(robots_of)
    if mission.scenario.robots == 1:
        assert several == 0, "a robot alone sees a cell often, and never overlaps"
    else:
        assert 0 < several < len(robots_of)


def test_accuracy_is_the_share_of_known_cells_that_are_labelled_right(
    flown: tuple[Mission, Tape],
) -> None:
    mission, tape = flown
    world, frame, rules = mission.world, mission.frame, mission.scenario.map
    truth: dict[tuple[int, int], list[bool]] = {}
    for row, col in np.ndindex(world.free.shape):
        x_m = world.origin_m[0] + (col + 0.5) * world.resolution_m
        y_m = world.origin_m[1] + (row + 0.5) * world.resolution_m
        truth.setdefault(frame.cell_of(x_m, y_m), []).append(bool(world.free[row, col]))
    odds = np.zeros(frame.size, dtype=np.int64)
    for record in tape.records:
        odds[record.map_cells] = record.map_log_odds
    right = wrong = mixed = 0
    for cell, value in enumerate(odds.tolist()):
        free = value < log_odds_of(rules.free_below)
        if not free and value <= log_odds_of(rules.occupied_above):
            continue
        behind = set(truth.get(frame.unflat(cell), [False]))
        mixed += len(behind) == 2
        right += behind == {free}
        wrong += behind == {not free}
    assert tape.summary is not None
    assert right > 0
    if mission.scenario.body.position_noise_m:
        assert wrong > 0
    assert tape.summary["map_accuracy"] == right / (right + wrong)
    assert tape.summary["map_mixed_share"] == mixed / (right + wrong + mixed)


def test_accuracy_by_hand() -> None:
    # Map cells of 2 × 2 raster cells: wall, free and half free, from left to right.
    world = world_from_ascii("##...#\n##S..#\n", 0.25)
    frame = GridFrame(*world.origin_m, 0.5, rows=1, columns=3)
    bodies = place_bodies(np.array([[0.75, 0.25]]), np.zeros(1, dtype=np.int64), np.ones(1))
    judge = Judge(map_truth(world, frame, 0.05), bodies, 0.3, (-3000, 3000))
    for labels, accuracy, mixed in [
        ((OCCUPIED, FREE, UNKNOWN), 1.0, 0.0),
        ((FREE, FREE, UNKNOWN), 0.5, 0.0),
        ((OCCUPIED, OCCUPIED, FREE), 0.5, 1 / 3),
        ((FREE, OCCUPIED, OCCUPIED), 0.0, 1 / 3),
        ((UNKNOWN, UNKNOWN, FREE), None, 1.0),
        ((UNKNOWN, FREE, UNKNOWN), 1.0, 0.0),
        ((UNKNOWN, UNKNOWN, UNKNOWN), None, None),
    ]:
        grids = SimpleNamespace(status=np.array([labels], dtype=np.uint8))
        said = judge._map_accuracy(grids)
        assert (said["map_accuracy"], said["map_mixed_share"]) == (accuracy, mixed)
