"""Law 6: with full communication, a map per robot gives the same mission as the shared map."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from tape import LITERAL, Tape, scenario_of, small_world, state_of

from swarmscout.core.enums import CHARGE
from swarmscout.mission.mission import Mission


def full(robots: int) -> Any:
    return lambda step: np.ones((robots, robots), dtype=np.bool_)


def assert_same(a: np.ndarray, b: np.ndarray, what: str) -> None:
    assert a.dtype == b.dtype, what
    assert a.tobytes() == b.tobytes(), what


@pytest.mark.parametrize("destinations", ["quantile", "nearest"])
@pytest.mark.parametrize(
    "scenario",
    [{}, LITERAL, {"teams": {"members": "fan"}}],
    ids=["paper", "paper-literal", "fan"],
)
@pytest.mark.parametrize("seed", [0, 1, 2])
def test_the_same_mission_step_by_step(
    seed: int, scenario: dict[str, Any], destinations: str
) -> None:
    given = scenario_of(scenario, seed=seed, destinations=destinations)
    world = small_world(seed)
    tapes = Tape(), Tape()
    shared = Mission(given, world=world, recorder=tapes[0])
    separate = Mission(given, world=world, links=full(8), recorder=tapes[1])
    while not shared.done:
        shared.step()
        separate.step()
        mine, theirs = state_of(shared), state_of(separate)
        for name in mine:
            assert_same(mine[name], theirs[name], f"{name} in step {shared.step_number}")
        for robot in range(8):
            all_know, each_knows = shared.knowledge, separate.knowledge
            row = each_knows.ear[robot]
            for table in ("evidence", "status", "price"):
                one, many = getattr(all_know.grids, table)[0], getattr(each_knows.grids, table)[row]
                assert_same(one, many, f"{table} of robot {robot} in step {shared.step_number}")
            assert_same(all_know.heard[0], each_knows.heard[row], "what was heard")
            assert_same(all_know.still[0], each_knows.still[row], "who stands")
        assert len(separate.knowledge.rows) == 1, "robots that know the same share a row"
        assert (versions(separate) == separate.log.end()).all(), "all versions are complete"
    assert separate.end_reason == shared.end_reason
    assert separate.summary() == shared.summary()
    for one, other in zip(tapes[0].records, tapes[1].records, strict=True):
        assert one.decisions == other.decisions
        assert one.coverage == other.coverage
        assert sorted(one.events.tolist()) == sorted(other.events.tolist())
        assert dict(zip(one.map_cells.tolist(), one.map_log_odds.tolist(), strict=True)) == dict(
            zip(other.map_cells.tolist(), other.map_log_odds.tolist(), strict=True)
        )


class Weather:
    """Random symmetric links that change from step to step, the same whenever asked."""

    def __init__(self, robots: int, share: float, seed: int, lasts: int = 7) -> None:
        self.robots, self.share, self.seed, self.lasts = robots, share, seed, lasts

    def __call__(self, step: int) -> np.ndarray:
        rng = np.random.default_rng((self.seed, step // self.lasts))
        upper = np.triu(rng.random((self.robots, self.robots)) < self.share, 1)
        return upper | upper.T


def versions(mission: Mission) -> np.ndarray:
    """int64[N, N], how many entries of each log each robot has."""
    return mission.knowledge.versions[mission.knowledge.ear]


def replay(mission: Mission, tape: Tape, known: np.ndarray) -> np.ndarray:
    """A map made of the prefixes that a version vector names."""
    total = np.zeros(mission.frame.size, dtype=np.int64)
    rows = np.concatenate(
        [record.evidence for record in tape.records if record.evidence is not None]
    )
    for robot, count in enumerate(known):
        entries = rows[rows[:, 0] == robot][:count]
        np.add.at(total, entries[:, 1], entries[:, 2])
    return total


@pytest.mark.parametrize("share", [0.0, 0.1, 0.4])
@pytest.mark.parametrize("seed", [0, 1])
def test_maps_differ_exactly_as_version_vectors_say(share: float, seed: int) -> None:
    given = scenario_of(seed=seed, steps=100)
    weather = Weather(8, share, seed)
    tape = Tape()
    mission = Mission(given, world=small_world(seed), links=weather, recorder=tape)
    expected = np.zeros((8, 8), dtype=np.int64)
    sending = np.ones(8, dtype=np.bool_)
    while not mission.done:
        mission.step()
        step = mission.step_number
        # Version vectors by sets: mine grows, and I take the best of what those I hear had.
        length = mission.log.end()
        had = expected.copy()
        np.fill_diagonal(had, length)
        expected = had.copy()
        for i in range(8):
            for j in np.flatnonzero(weather(step)[i] & sending):
                expected[i] = np.maximum(expected[i], had[j])
        assert (versions(mission) == expected).all()
        sending = mission.minds.own["sends"].copy()
        if step % 20 == 0 or mission.done:
            for i in range(8):
                own = replay(mission, tape, expected[i])
                assert_same(mission.map_of(i).evidence.ravel(), own, "maps")
            assert_same(mission.swarm.evidence[0], replay(mission, tape, length), "swarm's map")
    assert mission.end_reason is not None
    if share == 0.0:
        assert (versions(mission) == np.diag(mission.log.end())).all()


@pytest.mark.parametrize("share", [0.05, 0.3, 0.8])
@pytest.mark.parametrize("rule", ["charge", "general"])
def test_invariants_with_partial_links(share: float, rule: str) -> None:
    given = scenario_of(seed=5, robots=10, steps=250, teams={"leave_rule": rule, "desired_size": 4})
    mission = Mission(given, world=small_world(2), links=Weather(10, share, 5))
    area, edges = 0.0, 0
    while not mission.done:
        mission.step()
        minds, bodies = mission.minds, mission.bodies
        capacity = given.battery.capacity_steps
        assert ((bodies.charge >= 0) & (bodies.charge <= capacity)).all()
        assert (minds.own["thinks"] == bodies.alive).all()
        assert mission.explored_m2 >= area
        area = mission.explored_m2
        for i in np.flatnonzero(bodies.alive):
            leader = minds.leader[i]
            assert 0 <= leader < 10
            if minds.mode[i] == CHARGE:
                assert leader == i, "a robot in CHR mode follows nobody"
            same = np.flatnonzero(minds.team == minds.team[i])
            edges += len(same) > 1
            assert minds.own["destination"][i] < mission.frame.size
        gaps = np.hypot(*(bodies.position[:, None] - bodies.position[None]).transpose(2, 0, 1))
        assert gaps[np.triu_indices(10, 1)].min() >= 2 * given.body.radius_m - 1e-6
    assert edges > 0, "teams formed"
    assert mission.end_reason in ("steps used up", "everything reachable explored")


def test_with_full_links_again_beliefs_agree_again() -> None:
    weather = Weather(8, 0.2, 3)

    def links(step: int) -> np.ndarray:
        return np.ones((8, 8), dtype=np.bool_) if step > 60 else weather(step)

    mission = Mission(scenario_of(seed=3, steps=80), world=small_world(3), links=links)
    while mission.step_number < 70:
        mission.step()
    for robot in range(8):
        assert (mission.map_of(robot).evidence == mission.map.evidence).all()
    knowledge = mission.knowledge
    living = np.flatnonzero(mission.minds.thinking)
    heard = knowledge.heard[knowledge.ear]
    assert (heard[np.ix_(living, living)] == heard[living[0], living]).all()
    minds = mission.minds
    for i in living:
        followed = minds.leader[i]
        assert minds.own["leader"][followed] == followed
        assert minds.own["team"][followed] == minds.own["team"][i]
