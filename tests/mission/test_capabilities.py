"""A robot can drive, sense, send, hear and think, each on its own."""

from __future__ import annotations

import pytest
from tape import Tape, small_world

from swarmscout import Mission, Scenario

ROBOTS, BROKEN = 6, 2


def mission_without(capability: str, steps: int = 40) -> tuple[Mission, Tape]:
    """A mission in which one robot lacks a capability from step 11 on."""
    tape = Tape()
    given = Scenario(robots=ROBOTS, steps=steps, destinations="nearest")
    mission = Mission(given, world=small_world(1), recorder=tape)
    while not mission.done:
        if mission.step_number == 10:
            mission.bodies.can[capability][BROKEN] = False
        mission.step()
    return mission, tape


def test_a_robot_that_cannot_drive_stays_and_is_judged_by_what_it_did() -> None:
    mission, _ = mission_without("drive")
    where = mission.bodies.position[BROKEN].copy()
    heading = int(mission.bodies.heading[BROKEN])
    again, _ = mission_without("drive", steps=11)
    assert again.bodies.position[BROKEN].tolist() == where.tolist()
    assert int(again.bodies.heading[BROKEN]) == heading
    assert mission.judge.mobile == ROBOTS - 1
    assert mission.judge.stranded == 0, "it has charge"
    # It goes on to sense: evidence of what it sees still arrives.
    assert mission.log.end()[BROKEN] > again.log.end()[BROKEN]


def test_missions_of_robots_that_cannot_drive_end() -> None:
    mission = Mission(Scenario(robots=3, steps=40), world=small_world(1))
    mission.step()
    mission.bodies.can["drive"] = False
    summary = mission.run()
    assert summary["end_reason"] == "no robot able to move"
    assert summary["steps"] == 2
    # A move that was not made does not count as distance.
    assert summary["distance_m"] <= 3 * 0.2


def test_a_robot_that_cannot_sense_adds_no_evidence() -> None:
    mission, _ = mission_without("sense")
    early, _ = mission_without("sense", steps=11)
    assert mission.log.end()[BROKEN] == early.log.end()[BROKEN]
    assert mission.bodies.position[BROKEN].tolist() != early.bodies.position[BROKEN].tolist()


def test_a_robot_that_cannot_send_is_not_heard_but_hears() -> None:
    mission, _ = mission_without("send")
    knowledge = mission.knowledge
    others = [i for i in range(ROBOTS) if i != BROKEN]
    assert len(set(knowledge.ear[others].tolist())) == 1
    row = knowledge.heard[knowledge.ear[others[0]]]
    # What is broken after step 10 is known to the robot in step 11, which is its last beacon.
    assert row["step"][BROKEN] == 11
    own = knowledge.heard[knowledge.ear[BROKEN]]
    assert (own["step"] == 40).all(), "it hears all others, and itself"
    assert knowledge.versions[knowledge.ear[others[0]], BROKEN] < mission.log.end()[BROKEN]
    # The swarm's map is what all logs together say, heard or not.
    total = sum(int(mission.map_of(i).evidence.sum()) for i in others[:1])
    assert int(mission.map.evidence.sum()) != total


def test_a_robot_that_cannot_hear_knows_itself_alone() -> None:
    mission, _ = mission_without("hear")
    own = mission.knowledge.heard[mission.knowledge.ear[BROKEN]]
    assert own["step"].tolist() == [40 if i == BROKEN else 11 for i in range(ROBOTS)]


def test_a_robot_that_cannot_think_does_nothing() -> None:
    mission, _ = mission_without("think")
    early, _ = mission_without("think", steps=11)
    assert mission.bodies.position[BROKEN].tolist() == early.bodies.position[BROKEN].tolist()


@pytest.mark.parametrize("capability", ["drive", "sense", "send", "hear", "think"])
def test_each_loss_leaves_a_whole_mission(capability: str) -> None:
    mission, tape = mission_without(capability)
    assert mission.end_reason == "steps used up"
    assert len(tape.records) == 41
    areas = mission.judge.area_m2
    assert areas == sorted(areas), "explored area never falls"
