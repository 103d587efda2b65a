"""Law 5: teams partition the living robots, and join, leave and lead as the paper says."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from formation_reference import CHARGE, EXPLORE, JOIN, LEADER_EVENT, LEAVE, Population
from hypothesis import given, settings
from hypothesis import strategies as st
from known import place

PROFILE = settings(max_examples=40, deadline=None, derandomize=True, database=None)


def random_population(rng: np.random.Generator, **kwargs: Any) -> Population:
    robots = int(rng.integers(2, 15))
    edge = rng.uniform(1.0, 8.0)
    return Population(
        rng.uniform(0.0, edge, (robots, 2)),
        rng.integers(1, 7, robots),
        # Few distinct values, so that elections have ties.
        rng.integers(1, 4, robots) / 4.0,
        **kwargs,
    )


def walk(rng: np.random.Generator, population: Population, *, deaths: float, modes: float) -> None:
    """One step in which robots move, change mode, and now and then die."""
    minds = population.minds
    moved = minds.position_m + rng.normal(0.0, 0.3, (len(minds), 2))
    flips = rng.random(len(minds)) < modes
    mode = np.where(flips, 1 - minds.mode, minds.mode)
    dead = rng.random(len(minds)) < deaths
    population.step(moved, mode, dead)


def check_invariants(population: Population) -> None:
    minds = population.minds
    for team, members in population.teams().items():
        leaders = {int(minds.leader[i]) for i in members}
        assert len(leaders) == 1, f"team {team} has leaders {leaders}"
        heard = population.knowledge.heard[0]["step"]
        silent = {
            i for i in leaders - members if heard[i] >= population.number - population.silence
        }
        assert leaders - silent <= members, "a leader is a member that was heard not long ago"
        if any(minds.mode[i] == CHARGE for i in members):
            assert len(members) == 1, (
                "a robot in CHR mode is alone, in the step in which it changes"
            )


@PROFILE
@given(seed=st.integers(0, 10**6), rule=st.sampled_from(["charge", "general"]))
def test_every_step_is_what_the_reference_says(seed: int, rule: str) -> None:
    rng = np.random.default_rng(seed)
    population = random_population(rng, rule=rule, silence=int(rng.integers(0, 4)))
    deaths, modes = rng.choice([0.0, 0.02]), rng.choice([0.0, 0.1])
    for _ in range(25):
        walk(rng, population, deaths=deaths, modes=modes)
        snapshot = population.snapshot
        assert snapshot is not None
        partition, leaders = snapshot.outcome()
        assert population.partition() == partition
        assert {i: int(population.minds.leader[i]) for i in population.living} == leaders
        told = {
            kind: {row[1] for row in population.events if row[0] == kind} for kind in (JOIN, LEAVE)
        }
        assert told[JOIN] == snapshot.joiners(), "each that joins says so, and nobody else"
        assert told[LEAVE] == snapshot.leavers()
        moved = told[JOIN] | told[LEAVE]
        for i in population.living:
            assert (int(population.minds.team[i]) != snapshot.team[i][0]) is (i in moved)
        picks = snapshot.next_picks(population.minds.team.tolist())
        for team in snapshot.members:
            speaker = snapshot.speaker(team)
            if speaker in population.living:
                assert population.minds.own["partner"][speaker] == picks.get(team, -1)
        check_invariants(population)


@PROFILE
@given(seed=st.integers(0, 10**6))
def test_joins_keep_the_inequality_and_robots_are_conserved(seed: int) -> None:
    rng = np.random.default_rng(seed)
    population = random_population(rng)
    for _ in range(25):
        before = population.teams()
        walk(rng, population, deaths=0.0, modes=0.05)
        snapshot = population.snapshot
        assert snapshot is not None
        assert sorted(i for team in population.teams().values() for i in team) == population.living
        new_teams = {value for kind, _, _, value in population.events if kind == JOIN}
        for team in new_teams:
            members = population.teams().get(team, frozenset())
            origins = {t for t, were in before.items() if were & members}
            assert len(origins) <= 2, "a join is of two teams"
            if len(origins) < 2:
                continue  # All of one side left for charging in this very step.
            a, b = (before[t] for t in origins)
            pairs = [(i, j) for i in a for j in b if snapshot.may_join(i, j)]
            assert pairs, "some i and j recruited, were near, and kept the inequality both ways"
            assert all(snapshot.desired[i] > len(a) for i, _ in pairs)
            assert all(snapshot.desired[j] > len(b) for _, j in pairs)


@PROFILE
@given(seed=st.integers(0, 10**6))
def test_where_any_pair_may_join_one_does_within_two_steps(seed: int) -> None:
    rng = np.random.default_rng(seed)
    population = random_population(rng)
    population.step()
    for _ in range(20):
        snapshot = population.snapshot
        assert snapshot is not None
        robots = range(len(population.minds))
        possible = any(snapshot.may_join(i, j) for i in robots for j in robots if i < j)
        events = list(population.events)
        before = population.partition()
        population.step()  # Nobody moves: what was picked a step ago can be done now.
        events += population.events
        if possible:
            assert any(kind == JOIN for kind, *_ in events)
        else:
            assert population.partition() == before


def test_two_near_robots_join_in_the_second_step_and_not_beyond_d_join() -> None:
    for apart, together in ((1.999, True), (2.0, True), (2.001, False)):
        population = Population(np.array([[0.0, 0.0], [apart, 0.0]]), np.array([2, 2]), np.ones(2))
        population.step()
        assert len(population.partition()) == 2, "picks travel by beacon for one step"
        population.step()
        assert (len(population.partition()) == 1) is together


@pytest.mark.parametrize(
    ("desired_a", "desired_b", "join"),
    [
        ([4, 4], [4, 4], True),
        ([4, 4], [4, 3], False),  # Mean of b is 3.5 < 4, as a sees it.
        ([4, 3], [4, 4], False),  # The same the other way round.
        ([5, 3], [4, 4], True),  # A mean of 4 is enough, and one of a's robots (5) fits itself.
        ([9, 9], [3, 3], False),
    ],
)
def test_the_inequality_by_table(desired_a: list[int], desired_b: list[int], join: bool) -> None:
    places = np.array([[0.0, 0.0], [0.0, 0.5], [1.0, 0.0], [1.0, 0.5]])
    population = Population(places, np.array(desired_a + desired_b), np.ones(4))
    population.gather([0, 1], [2, 3])
    population.step()
    population.step()
    assert (len(population.partition()) == 1) is join


@pytest.mark.parametrize("wants", [3, 4])
@pytest.mark.parametrize("mirrored", [False, True])
def test_the_robots_that_meet_must_both_want_so_many(wants: int, mirrored: bool) -> None:
    # Both means are 4; only robot 2 of the right team is near, and it wants 3 or 4.
    places = np.array([[0.0, 0.0], [0.0, 0.5], [1.0, 0.0], [10.0, 0.0]])
    if mirrored:
        places[:, 0] *= -1.0
    population = Population(places, np.array([4, 4, wants, 8 - wants]), np.ones(4))
    population.gather([0, 1], [2, 3])
    population.step()
    population.step()
    assert (len(population.partition()) == 1) is (wants == 4)
    assert bool(population.events) is (wants == 4)


@PROFILE
@given(seed=st.integers(0, 10**6))
def test_the_larger_teams_leader_leads_and_ties_go_to_the_lower_id(seed: int) -> None:
    rng = np.random.default_rng(seed)
    sizes = rng.integers(1, 4, 2)
    robots = int(sizes.sum())
    names = rng.permutation(robots)
    a, b = names[: sizes[0]].tolist(), names[sizes[0] :].tolist()
    population = Population(
        rng.uniform(0.0, 1.0, (robots, 2)), np.full(robots, robots), rng.uniform(0, 1, robots)
    )
    population.gather(a, b)
    population.step()
    population.step()
    expected = a[0] if len(a) > len(b) else b[0] if len(b) > len(a) else min(a[0], b[0])
    assert set(population.minds.leader.tolist()) == {expected}
    assert {kind for kind, *_ in population.events} == {JOIN}
    assert len(population.events) == robots


@PROFILE
@given(seed=st.integers(0, 10**6), how=st.sampled_from(["charge", "death"]))
def test_election_is_by_charge_then_by_id(seed: int, how: str) -> None:
    rng = np.random.default_rng(seed)
    robots = int(rng.integers(2, 8))
    charge = rng.integers(1, 4, robots) / 4.0
    population = Population(rng.uniform(0, 1, (robots, 2)), np.full(robots, robots), charge)
    members = rng.permutation(robots).tolist()
    population.gather(members)
    population.step()
    leader, rest = members[0], sorted(members[1:])
    mode = np.full(robots, EXPLORE)
    dead = np.zeros(robots, dtype=np.bool_)
    if how == "charge":
        mode[leader] = CHARGE
    else:
        dead[leader] = True
    population.step(mode=mode, dead=dead)
    if how == "death":
        for _ in range(population.silence):
            assert {int(population.minds.leader[i]) for i in rest} == {leader}
            population.step()
        population.step()
    best = min(rest, key=lambda i: (-charge[i], i))
    assert {int(population.minds.leader[i]) for i in rest} == {best}
    elections = [row for row in population.events if row[0] == LEADER_EVENT]
    assert elections == [[LEADER_EVENT, best, leader, int(population.minds.team[best])]]
    leaves = [row[:3] for row in population.events if row[0] == LEAVE]
    assert leaves == ([[LEAVE, leader, leader]] if how == "charge" else [])


@PROFILE
@given(seed=st.integers(0, 10**6))
def test_names_of_robots_do_not_matter(seed: int) -> None:
    rng = np.random.default_rng(seed)
    robots = int(rng.integers(2, 12))
    places = rng.uniform(0.0, 4.0, (robots, 2))
    desired, charge = rng.integers(1, 7, robots), rng.permutation(robots) / robots
    order = rng.permutation(robots)  # New robot k is old robot order[k].
    old = Population(places, desired, charge)
    new = Population(places[order], desired[order], charge[order])
    for _ in range(12):
        moved = old.minds.position_m + rng.normal(0.0, 0.2, (robots, 2))
        old.step(moved)
        new.step(moved[order])
        renamed = frozenset(frozenset(int(order[k]) for k in team) for team in new.partition())
        assert renamed == old.partition()
    # A leader that leaves: the rest elect by charge, which has no ties here.
    mode = np.full(robots, EXPLORE)
    mode[old.minds.leader[int(rng.integers(robots))]] = CHARGE
    old.gather(*(sorted(team) for team in old.partition()))
    groups = [[int(np.flatnonzero(order == i)[0]) for i in sorted(t)] for t in old.partition()]
    new.gather(*groups)
    for population, modes in ((old, mode), (new, mode[order])):
        population.minds.own["partner"] = -1
        population.step(mode=modes)
    was = {int(order[k]): int(order[new.minds.leader[k]]) for k in range(robots)}
    assert was == {i: int(old.minds.leader[i]) for i in range(robots)}


@pytest.mark.parametrize("rule", ["charge", "general"])
@pytest.mark.parametrize("seed", range(6))
def test_two_teams_never_carry_the_same_id(seed: int, rule: str) -> None:
    rng = np.random.default_rng(seed)
    robots = 20
    population = Population(
        rng.uniform(0, 6, (robots, 2)), rng.integers(1, 6, robots), rng.random(robots), rule=rule
    )
    seen: dict[int, frozenset[int]] = {i: frozenset([i]) for i in range(robots)}
    for _ in range(400):
        minds = population.minds
        inside = np.clip(minds.position_m + rng.normal(0, 0.3, (robots, 2)), 0, 6)
        mode = np.where(rng.random(robots) < 0.03, 1 - minds.mode, minds.mode)
        population.step(inside, mode, rng.random(robots) < 0.0005)
        for team, members in population.teams().items():
            # An id stands for one team: later it may only have lost members.
            assert members <= seen.setdefault(team, members)
            seen[team] = members
        check_invariants(population)


def test_the_general_rule_removes_one_member_at_a_time() -> None:
    places = np.random.default_rng(0).uniform(0.0, 1.0, (6, 2))
    population = Population(places, np.array([5, 3, 2, 2, 4, 4]), np.ones(6), rule="general")
    population.gather([0, 1, 2, 3, 4, 5])
    left = []
    sizes = []
    for _ in range(6):
        population.minds.own["partner"] = -1  # Nobody joins again meanwhile.
        population.step()
        left += [row[1] for row in population.events if row[0] == LEAVE]
        sizes.append(max(len(team) for team in population.partition()))
        assert len([row for row in population.events if row[0] == LEAVE]) <= 1
    # Means: 20/6 < 6, without 3: 18/5 < 5, without 2: 16/4 = 4 — no longer below the size.
    assert left == [3, 2]
    assert sizes == [5, 4, 4, 4, 4, 4]


def test_the_general_rule_is_off_by_default() -> None:
    population = Population(np.zeros((3, 2)), np.array([1, 1, 1]), np.ones(3))
    population.gather([0, 1, 2])
    for _ in range(3):
        population.step()
    assert len(population.partition()) == 1


def test_a_silent_member_counts_until_the_timeout() -> None:
    silence = 3
    places = np.array([[0.0, 0.0], [0.5, 0.0], [1.0, 0.0]])
    population = Population(places, np.full(3, 3), np.ones(3), silence=silence)
    population.gather([0, 1, 2])
    population.step()
    population.step(dead=np.array([False, False, True]))
    sizes = []
    for _ in range(silence + 2):
        population.step()
        sizes.append(int(population.minds.own["size"][0]))
    # It was last heard in step 2, so steps 3, 4 and 5 still count it.
    assert sizes == [3, 3, 3, 2, 2]
    assert set(population.minds.leader[:2].tolist()) == {0}


def test_a_dead_robot_is_no_member_of_what_its_old_leader_does_next() -> None:
    # Robots 0 and 1 are a team; 1 dies; 0 joins 2 and 3, led by 2, and then leaves to charge.
    places = np.array([[0.0, 0.0], [0.1, 0.0], [0.5, 0.0], [0.6, 0.0]])
    population = Population(places, np.full(4, 9), np.ones(4), silence=10)
    population.gather([0, 1], [2, 3], leaders=[0, 2])
    place(population.minds, population.minds.position_m[:2] + 100.0, slice(2))
    population.step()
    population.step(dead=np.array([False, True, False, False]))
    back = population.minds.position_m.copy()
    back[0] = places[0]
    for _ in range(3):
        population.step(back)
    joined = {int(population.minds.team[i]) for i in (0, 2, 3)}
    assert len(joined) == 1
    mode = np.array([CHARGE, EXPLORE, EXPLORE, EXPLORE])
    leaves = 0
    for _ in range(4):
        population.step(mode=mode)
        leaves += sum(row[0] == LEAVE and row[1] == 0 for row in population.events)
    assert leaves == 1, "who is alone does not leave again"
    assert population.minds.own["size"][0] == 1


def test_columns_say_what_the_beacon_carries() -> None:
    population = Population(np.zeros((2, 2)), np.array([2, 2]), np.ones(2))
    for _ in range(3):
        population.step()
    own = population.minds.own
    assert own["size"].tolist() == [2, 2]
    assert own["leader"].tolist() == [0, 0]
    assert own["team"][0] == own["team"][1]
    assert own["desired"].tolist() == [2, 2]
