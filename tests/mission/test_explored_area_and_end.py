"""Laws 9 and 10: explored area, the end of a mission, and what its summary says."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from tape import LITERAL, Tape, closet, scenario_of, small_world

from swarmscout.core.enums import CHARGE, EVENTS, FORWARD, JOIN, LEAVE, LEFT, MODE, RIGHT
from swarmscout.core.errors import ScenarioError
from swarmscout.mapping.log_odds import log_odds_of
from swarmscout.mission.mission import Mission
from swarmscout.worlds.reachability import reachable

CASES: list[tuple[str, dict[str, Any]]] = [
    ("paper", {}),
    ("paper-literal", LITERAL),
    ("spread, nearest", {"start": "spread", "destinations": "nearest"}),
    ("noise", {"body": {"position_noise_m": 0.3, "heading_noise_deg": 10.0}}),
    ("no noise at all", {"sensor": {"noise_m": 0.0}}),
    ("4 neighbours, small cells", {"map": {"frontier_neighbours": 4, "cell_m": 0.3}}),
    ("one ray", {"sensor": {"rays": 1, "fan_deg": 0.0, "range_m": 2.0}}),
    ("distance rule, centre", {"teams": {"position": "center"}}),
    ("general leaving", {"teams": {"leave_rule": "general", "desired_size": 3}}),
    ("no battery", {"battery": {"enabled": False}}),
    ("the way back", {"battery": {"capacity_steps": 200, "return_rule": "distance"}}),
]


def recorded(keys: dict[str, Any], seed: int = 2) -> tuple[Mission, Tape]:
    tape = Tape()
    mission = Mission(scenario_of(keys, seed=seed), world=small_world(seed), recorder=tape)
    mission.run()
    return mission, tape


@pytest.fixture(scope="module", params=CASES, ids=[name for name, _ in CASES])
def case(request: pytest.FixtureRequest) -> tuple[Mission, Tape]:
    return recorded(request.param[1])


def test_area_grows_within_bounds_and_equals_a_recount(case: tuple[Mission, Tape]) -> None:
    mission, tape = case
    world, frame = mission.world, mission.frame
    reach = reachable(world, mission.scenario.body.radius_m) != 0
    rows, columns = np.nonzero(reach)
    x = world.origin_m[0] + (columns + 0.5) * world.resolution_m
    y = world.origin_m[1] + (rows + 0.5) * world.resolution_m
    behind = np.zeros(frame.shape, dtype=int)
    for point_x, point_y in zip(x, y, strict=True):
        behind[frame.cell_of(point_x, point_y)] += 1
    truth, cell_m2 = mission.judge.truth, world.resolution_m**2
    half_free = truth.free / np.maximum(truth.total, 1) >= 0.5
    assert mission.judge.sensable_m2 == pytest.approx(behind.ravel()[half_free].sum() * cell_m2)
    free_below = log_odds_of(mission.scenario.map.free_below)
    odds = np.zeros(frame.size, dtype=int)
    ever = np.zeros(frame.size, dtype=bool)
    area = -1.0
    for record in tape.records:
        assert len(set(record.map_cells.tolist())) == len(record.map_cells)
        assert (odds[record.map_cells] != record.map_log_odds).all(), "only what changed"
        odds[record.map_cells] = record.map_log_odds
        ever |= odds < free_below
        recount = behind.ravel()[ever].sum() * world.resolution_m**2
        coverage = record.coverage
        sensed = behind.ravel()[ever & half_free].sum() * cell_m2
        assert mission.judge.sensed_m2[record.step] == pytest.approx(sensed)
        assert coverage["explored_m2"] == pytest.approx(recount, abs=1e-9)
        assert coverage["explored_m2"] >= area
        area = float(coverage["explored_m2"])
        assert area <= reach.sum() * world.resolution_m**2 + 1e-9
        assert coverage["explored_fraction"] == pytest.approx(area / mission.judge.reachable_m2)
    assert (odds.reshape(frame.shape) == mission.map.log_odds).all(), "the map from its changes"
    labels = mission.map.labels
    counted = tape.records[-1].coverage["known_cells"]
    assert counted == np.count_nonzero(labels)
    assert tape.records[-1].coverage["frontier_cells"] == len(mission.map.frontiers())


def test_the_summary_is_consistent(case: tuple[Mission, Tape]) -> None:
    mission, tape = case
    summary = tape.summary
    assert summary is not None
    assert set(summary) == {
        *("version", "rules_version", "world", "start", "selector", "robots", "seed", "steps"),
        *(
            "task",
            "score",
            "end_reason",
            "explored_m2",
            "explored_fraction",
            "reachable_m2",
            "sensable_m2",
            "sensable_fraction",
            "time_to_sensable",
            "area_at_step",
        ),
        *("time_to", "overlap_ratio", "distance_m", "forward_share", "turn_share"),
        *("blocked_share", "joins", "leaves", "teams", "charges", "stranded", "map_accuracy"),
        "map_mixed_share",
    }
    records = tape.records[1:]
    area = [float(record.coverage["explored_m2"]) for record in tape.records]
    assert summary["steps"] == len(records) == mission.step_number
    assert summary["explored_m2"] == area[-1]
    expected = {str(s): area[s] for s in range(50, len(area), 50)}
    assert summary["area_at_step"] == expected
    sensed = mission.judge.sensed_m2
    assert summary["sensable_fraction"] == sensed[-1] / summary["sensable_m2"] <= 1.0
    for key, areas, most in (
        ("time_to", area, "reachable"),
        ("time_to_sensable", sensed, "sensable"),
    ):
        for share, step in summary[key].items():
            part = float(share.rstrip("%")) / 100 * summary[f"{most}_m2"]
            reached = [s for s, a in enumerate(areas) if a >= part - 1e-9]
            assert step == (reached[0] if reached else None)
    shares = [summary[f"{what}_share"] for what in ("forward", "turn", "blocked")]
    assert all(share >= 0 for share in shares)
    assert sum(shares) <= 1 + 1e-12
    for key in ("overlap_ratio", "map_accuracy", "map_mixed_share", "explored_fraction"):
        assert 0 <= summary[key] <= 1
    # Recounts from what was recorded.
    before = tape.records[0]
    forward = turns = acted = blocked = 0
    distance = 0.0
    for record in records:
        gone = np.hypot(*(record.pose - before.pose)[:, :2].T)
        distance += gone.sum()
        moved = gone > 0
        able = record.alive
        acted += able.sum()
        forward += moved.sum()
        turns += (able & np.isin(record.action, (LEFT, RIGHT))).sum()
        blocked += (able & (record.action == FORWARD) & (record.contact != 0)).sum()
        assert not (moved & (record.action != FORWARD)).any()
        before = record
    assert summary["distance_m"] == pytest.approx(distance)
    assert summary["distance_m"] == pytest.approx(forward * mission.scenario.body.forward_m)
    assert shares == pytest.approx([forward / acted, turns / acted, blocked / acted])
    rows = [row for record in records for row in record.events.tolist()]
    assert all(0 <= kind < len(EVENTS) for kind, *_ in rows)
    assert summary["leaves"] == sum(row[0] == LEAVE for row in rows)
    assert summary["joins"] == len({row[3] for row in rows if row[0] == JOIN})
    assert summary["charges"] == sum(row[0] == MODE and row[2] != CHARGE for row in rows)
    last = tape.records[-1]
    assert summary["stranded"] == (~last.alive).sum()
    exploring = last.alive & (last.mode != CHARGE)
    assert sum(summary["teams"]) == exploring.sum()


def test_the_recorded_teams_are_whole_in_each_step(case: tuple[Mission, Tape]) -> None:
    """Laws 4 and 5 in a mission: charge within bounds, teams with one leader, CHR alone."""
    mission, tape = case
    for record in tape.records:
        assert ((record.charge >= 0) & (record.charge <= 1)).all()
        living = np.flatnonzero(record.alive)
        teams = {team: living[record.team[living] == team] for team in set(record.team[living])}
        for members in teams.values():
            leaders = set(record.leader[members].tolist())
            assert len(leaders) == 1
            assert leaders <= set(members.tolist())
            if (record.mode[members] == CHARGE).any():
                assert len(members) == 1
            else:
                assert len(set(record.destination[members].tolist())) == 1
            if mission.scenario.teams.leave_rule == "charge":
                assert len(members) <= max(1, int(record.desired[members].max()))


def test_a_stranded_robot_does_nothing(case: tuple[Mission, Tape]) -> None:
    _, tape = case
    stopped: dict[int, list[float]] = {}
    for record in tape.records:
        for i in np.flatnonzero(~record.alive).tolist():
            pose = record.pose[i].tolist()
            assert stopped.setdefault(i, pose) == pose
            assert record.charge[i] == 0


def test_everything_explored_ends_a_mission() -> None:
    tape = Tape()
    mission = Mission(
        scenario_of(robots=1, steps=500, battery={"enabled": False}), world=closet(), recorder=tape
    )
    summary = mission.run()
    assert summary["end_reason"] == "everything reachable explored"
    assert summary["steps"] < 500
    assert summary["explored_fraction"] == 1.0
    assert summary["time_to"]["99%"] <= summary["steps"]
    assert mission.done
    with pytest.raises(ScenarioError, match="over: everything reachable explored"):
        mission.step()


def test_a_mission_that_has_seen_nothing_yet_goes_on() -> None:
    # One ray says too little in one step to call any cell free: no frontier, but no end either.
    given = scenario_of(robots=1, sensor={"rays": 1, "fan_deg": 0.0}, seed=2)
    summary = Mission(given, world=small_world(2)).run()
    assert summary["steps"] == 120
    assert summary["explored_m2"] > 0


def test_no_robot_able_to_move_ends_a_mission() -> None:
    battery = {"capacity_steps": 5, "start_min": 1.0, "charge_below": 0.0}
    summary = Mission(scenario_of(battery=battery), world=small_world(0)).run()
    assert summary["end_reason"] == "no robot able to move"
    assert summary["stranded"] == 8
    assert summary["steps"] == 5


@pytest.mark.parametrize("steps", [1, 37])
def test_steps_used_up_ends_a_mission(steps: int) -> None:
    summary = Mission(scenario_of(steps=steps), world=small_world(0)).run()
    assert (summary["end_reason"], summary["steps"]) == ("steps used up", steps)


def test_a_summary_can_be_asked_for_at_any_time() -> None:
    mission = Mission(scenario_of(), world=small_world(0))
    assert mission.summary()["steps"] == 0
    assert mission.summary()["explored_m2"] == 0.0
    seen: list[int] = []
    mission.step()
    assert mission.summary()["end_reason"] is None
    mission.run(on_step=lambda m: seen.append(m.step_number))
    assert seen == list(range(2, 121))
    assert mission.run() == mission.summary(), "running a mission that is over runs nothing"


def test_believed_poses_are_noisy_and_true_ones_are_not() -> None:
    body = {"position_noise_m": 0.2, "heading_noise_deg": 15.0}
    mission = Mission(scenario_of(body=body, robots=8, steps=60), world=small_world(1))
    errors, turned = [], []
    while not mission.done:
        where, heading = mission.bodies.position.copy(), mission.bodies.heading.copy()
        mission.step()
        able = mission.minds.own["thinks"]
        errors.append((mission.minds.position_m - where)[able].ravel())
        turned.append(((mission.minds.own["heading"] - heading + 1800) % 3600 - 1800)[able])
    assert np.std(np.concatenate(errors)) == pytest.approx(0.2, rel=0.1)
    assert np.std(np.concatenate(turned)) == pytest.approx(150, rel=0.1)
    assert mission.explored_m2 > 0
