"""The blindfold test: change what robot i cannot know, and i decides the same.

Two equal missions run to the same step. In one of them the truth is changed where no robot has ever
sensed, and so are the messages that robot i does not hear and other robots' private state. Then
both take one more step, and all that robot i has in mind afterwards must be the same.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from functools import cache
from typing import Any

import numpy as np
from scipy import ndimage

from swarmscout.core.enums import FREE
from swarmscout.destinations.selector import Choice, Selector
from swarmscout.destinations.view import LeaderView
from swarmscout.minds.given_up import FOR_GOOD
from swarmscout.mission.mission import Mission
from swarmscout.mission.scenario import Scenario
from swarmscout.planning.route_table import NOWHERE
from swarmscout.teams.policy import DesiredSizePolicy
from swarmscout.teams.robots_view import RobotsView
from swarmscout.testing import small_world
from swarmscout.testing.fingerprints import fingerprint

ROBOTS = 8
cave = cache(small_world)
MakeSelector = Callable[[Mission], Selector]
MakePolicy = Callable[[Mission], DesiredSizePolicy]


def run_to(
    step: int,
    make: MakeSelector,
    seed: int,
    links: Any = None,
    sizes: MakePolicy | None = None,
) -> Mission:
    """A mission, stopped after a step; the decisions of the last step stand in `decided`."""
    scenario = Scenario.model_validate(
        {
            "robots": ROBOTS,
            "steps": 200,
            "seed": seed,
            "battery": {"capacity_steps": 150, "start_min": 0.3},
            "teams": {
                "leave_rule": "charge" if sizes is None else "general",
                "members": "fan",
                "fan_m": 5.0,
            },
            "renewal": {"reach_m": 1.0},
        }
    )
    mission = Mission(scenario, world=cave(seed), links=links, recorder=Decided())
    mission.destinations.selector = make(mission)
    if sizes is not None:
        mission.sizes.policy = sizes(mission)
    for _ in range(step):
        mission.step()
    return mission


class Decided:
    """Keeps the last step's decisions, and the steps that had any."""

    def __init__(self) -> None:
        self.last: list[Any] = []
        self.steps: list[int] = []

    def begin(self, mission: Any) -> None:
        mission.decided = self

    def record(self, record: Any) -> None:
        self.last = list(record.decisions)
        if record.decisions:
            self.steps.append(record.step)

    def end(self, summary: Any) -> None: ...


def change_truth(mission: Mission) -> None:
    """Turn free into wall and wall into free where no robot has sensed or can be in a step."""
    world, frame = mission.world, mission.frame
    unsensed = mission.swarm.evidence[0] == 0
    rows, columns = np.indices(world.free.shape)
    points = np.stack([columns, rows], axis=-1) * world.resolution_m + np.array(world.origin_m)
    cells = frame.cells_of(points + 0.5 * world.resolution_m)
    far = unsensed[cells[..., 0] * frame.columns + cells[..., 1]]
    gaps = points[None] - mission.bodies.position[:, None, None]
    far &= np.hypot(gaps[..., 0], gaps[..., 1]).min(axis=0) > 2.0
    free = np.where(far, 1 - world.free, world.free).astype(np.uint8)
    assert far.sum() > 500
    mission.world = dataclasses.replace(world, free=np.ascontiguousarray(free))


def change_private_state(mission: Mission, others: list[int], rng: np.random.Generator) -> None:
    """What no message carries: why and since when they head somewhere, what they avoid, remember.

    All robots hear which destinations are given up in the step. So what makes a leader give up its
    own stays: whether it is overdue, and whether the team has come to its route's end.
    """
    minds, table = mission.minds, mission.planner.table
    step, frame, frontiers = mission.step_number + 1, mission.frame, mission.swarm.frontiers(0)
    side = int(mission.destinations._rules[0]["place_cells"])
    for j in others:
        minds.own["cause"][j] = rng.integers(0, 6)
        due_at = minds.own["due_at"][j]
        minds.own["due_at"][j] = rng.choice([step, 10**6] if due_at >= step else [-1, step - 1])
        if len(frontiers):
            minds.avoided[j, :, 0] = rng.choice(frontiers, minds.avoided.shape[1])
            minds.avoided[j, :, 1] = 10**6
            cells = rng.choice(frontiers, minds.given_up.shape[1])
            places = cells // frame.columns // side * frame.columns + cells % frame.columns // side
            if (
                minds.given_up[j]["until"] != FOR_GOOD
            ).all():  # What is closed is closed for all who have heard of it.
                minds.given_up[j]["place"] = places
                minds.given_up[j]["until"] = 10**6
        minds.own["look_at"][j], minds.own["doubts"][j] = 10**6, rng.random() < 0.5
        # Forgotten: what another selector's memory looks like is its own affair.
        mission.destinations.memories[j] = None
        if table.state["at"][j] < table.state["length"][j]:
            table.state["goal"][j] = NOWHERE  # It plans anew in the same step as robot i.


def scramble(mission: Mission, others: list[int], rng: np.random.Generator) -> None:
    """Everything of robots that i does not hear at all in this step."""
    minds, knowledge = mission.minds, mission.knowledge
    change_private_state(mission, others, rng)
    teams, size = minds.team.copy(), mission.frame.size
    for j in others:
        own = minds.own[j]
        own["team"], own["leader"] = rng.choice(teams), rng.integers(0, ROBOTS)
        own["mode"], own["size"] = rng.integers(0, 2), rng.integers(1, 6)
        own["desired"], own["partner"] = rng.integers(1, 6), rng.integers(-1, ROBOTS)
        own["destination"] = rng.integers(-1, size)
        mission.bodies.charge[j] = rng.uniform(2.0, 150.0)
        knowledge.notices[j] = tuple(rng.integers(-1, ROBOTS, len(knowledge.notices.dtype)))
    for row in set(knowledge.ear[others].tolist()) - set(np.delete(knowledge.ear, others).tolist()):
        cells = rng.permutation(size)[:40]
        many = np.array([40])
        knowledge.grids.apply(row, cells[None], rng.integers(-4000, 4000, (1, 40)), 0 * many, many)


def in_mind(mission: Mission, i: int) -> dict[str, Any]:
    """All that robot i has made up its mind about."""
    minds, table = mission.minds, mission.planner.table
    return {
        "own": str(minds.own[i]),
        "avoided": minds.avoided[i].tolist(),
        "given up": minds.given_up[i].tolist(),
        "memory": repr(mission.destinations.memories[i]),
        "route state": [np.asarray(value).tolist() for value in table.state[i].tolist()],
        "route": table.ahead(i).tolist(),
        "route cost": int(table.state["cost"][i]),
        "action": int(mission.action[i]),
        "decisions": [fingerprint(d) for d in mission.decided.last if d.leader == i],  # type: ignore[attr-defined]
    }


def differences(a: Mission, b: Mission, robots: list[int]) -> list[str]:
    found = []
    for i in robots:
        mine, theirs = in_mind(a, i), in_mind(b, i)
        found += [
            f"step {a.step_number}, robot {i}: {what} {mine[what]} became {theirs[what]}"
            for what in mine
            if mine[what] != theirs[what]
        ]
    return found


def peeks(
    make: MakeSelector,
    sizes: MakePolicy | None = None,
    *,
    seeds: tuple[int, ...] = (0, 1),
    steps: int = 6,
) -> list[str]:
    """What robots decide by things that they cannot know, with everybody hearing everybody.

    Args:
        make: makes the selector for a mission.
        sizes: makes the policy for desired team sizes; None for the paper's.
        seeds: of worlds and missions.
        steps: how many steps with decisions are tried in each.

    Returns:
        One line for each thing that changed in a robot's mind; none if all are blind.
    """
    found = []
    for seed in seeds:
        whole = run_to(100, make, seed, None, sizes)
        tried = whole.decided.steps  # type: ignore[attr-defined]
        for step in tried[:: max(1, len(tried) // steps)]:
            before = run_to(step - 1, make, seed, None, sizes)
            teams_before = before.minds.team.copy()
            after = run_to(step, make, seed, None, sizes)
            for team in sorted(set(after.minds.team.tolist())):
                mine = np.flatnonzero(after.minds.team == team)
                # Members share what their leader decides; so do those that left or joined now.
                near = np.isin(teams_before, teams_before[mine]) | (after.minds.team == team)
                blind = run_to(step - 1, make, seed, None, sizes)
                change_truth(blind)
                change_private_state(
                    blind, np.flatnonzero(~near).tolist(), np.random.default_rng(step)
                )
                blind.step()
                found += differences(after, blind, mine.tolist())
    return found


def peeks_alone(
    make: MakeSelector, sizes: MakePolicy | None = None, *, seed: int = 0, steps: int = 5
) -> list[str]:
    """What a robot that hears nobody in a step decides by things that it cannot know."""

    def cut(step_of_silence: int, i: int) -> Callable[[int], np.ndarray]:
        def links(step: int) -> np.ndarray:
            heard = np.ones((ROBOTS, ROBOTS), dtype=np.bool_)
            if step == step_of_silence:
                heard[i, :] = heard[:, i] = False
            return heard

        return links

    found = []
    whole = run_to(100, make, seed, None, sizes)
    tried = whole.decided.steps  # type: ignore[attr-defined]
    for step in tried[:: max(1, len(tried) // steps)]:
        for i in range(ROBOTS):
            missions = [run_to(step - 1, make, seed, cut(step, i), sizes) for _ in range(2)]
            others = [j for j in range(ROBOTS) if j != i]
            change_truth(missions[1])
            scramble(missions[1], others, np.random.default_rng(step + i))
            for mission in missions:
                mission.step()
            found += differences(missions[0], missions[1], [i])
    return found


def random_links(seed: int, share: float) -> Callable[[int], np.ndarray]:
    """Links of random pairs, others every few steps, so that teams form and part."""

    def links(step: int) -> np.ndarray:
        rng = np.random.default_rng((seed, step // 4))
        heard = rng.random((ROBOTS, ROBOTS)) < share
        return heard | heard.T | np.eye(ROBOTS, dtype=np.bool_)

    return links


def garble_unheard(
    mission: Mission, after: Mission, i: int, unheard: list[int], listeners: list[int]
) -> None:
    """Replace what `unheard` robots say and know, and evidence that reaches no listener.

    Args:
        mission: one step before; changed.
        after: the same mission after the step.
        i: the robot that must not notice; every second unheard one claims to be in its team.
        unheard: robots that no listener hears in the step.
        listeners: robots whose knowledge stays.
    """
    rng = np.random.default_rng(after.step_number)
    scramble(mission, unheard, rng)
    for name in ("team", "leader", "destination"):
        mission.minds.own[name][unheard[::2]] = mission.minds.own[name][i]
    log = mission.log
    log.allow_writing(True)
    reached = after.knowledge.versions[after.knowledge.ear[listeners]].max(axis=0)
    for j in range(ROBOTS):
        first, length = max(0, int(reached[j] - log.dropped[j])), int(log.length[j])
        if first < length:
            log.cells[j, first:length] = rng.integers(0, mission.frame.size, length - first)
            log.increments[j, first:length] = rng.integers(-900, 900, length - first)
    knowledge = mission.knowledge
    spared = set(knowledge.ear[[j for j in range(ROBOTS) if j not in unheard]].tolist())
    for row in set(knowledge.ear.tolist()) - spared:
        old = knowledge.heard[row]
        old["x_m"] += 1.0
        old["destination"] = rng.integers(-1, mission.frame.size, ROBOTS)
        knowledge.still[row] += 100


def peeks_partly(
    make: MakeSelector,
    sizes: MakePolicy | None = None,
    *,
    seed: int = 0,
    share: float = 0.08,
    steps: int = 6,
) -> list[str]:
    """What robots decide by messages that they did not hear, under random partial links.

    A robot that i hears may decide by what it hears itself and tell i in the same step. So
    everything of robots that neither i nor such a robot hears is changed, and of the others outside
    the team what no message carries.
    """
    links = random_links(seed, share)
    whole = run_to(100, make, seed, links, sizes)
    tried = whole.decided.steps  # type: ignore[attr-defined]
    found, changed = [], 0
    for step in tried[:: max(1, len(tried) // steps)]:
        before = run_to(step - 1, make, seed, links, sizes)
        after = run_to(step, make, seed, links, sizes)
        hears = links(step)
        for i in range(ROBOTS):
            team = np.isin(before.minds.team, before.minds.team[[i]])
            team |= after.minds.team == after.minds.team[i]
            team |= np.isin(before.minds.team, before.minds.team[team])
            listeners = np.flatnonzero(hears[i])
            unheard = np.flatnonzero(~hears[listeners].any(axis=0))
            changed += len(unheard)
            blind = run_to(step - 1, make, seed, links, sizes)
            change_truth(blind)
            rng = np.random.default_rng(step)
            change_private_state(blind, np.flatnonzero(~team).tolist(), rng)
            garble_unheard(blind, after, i, unheard.tolist(), listeners.tolist())
            blind.step()
            found += differences(after, blind, [i])
    assert changed > 10 * steps, "links are so dense that nothing was hidden"
    return found


class ToldAll:
    """Chooses by everything that its view shows, and says so: a change in the view shows."""

    def choose(self, view: LeaderView, memory: Any) -> Choice:
        public = [name for name in dir(LeaderView) if not name.startswith("_")]
        seen = [getattr(view, name) for name in (*public, *vars(view)) if not name.startswith("_")]
        seen = [value for value in seen if not callable(value)]
        seen += [view.route_costs(), view.unknown_m2(1.0), *vars(view.others).values(), memory]
        told = hash(repr([fingerprint(value) for value in seen])) % 10**9
        row, col = view.frontiers[told % len(view.frontiers)].tolist()
        return Choice((row, col), memory=told, details={"told": told})


class SizedByAll:
    """Desires sizes by everything that each row of its view shows: a change in a row shows."""

    def desired(self, view: RobotsView) -> Any:
        names = [name for name in dir(RobotsView) if not name.startswith("_")]
        seen = [value for name in names if not callable(value := getattr(view, name))]
        for reach_m in (0.7, 2.0, 5.0):
            seen += [view.frontiers_within(reach_m), view.robots_within(reach_m)]
            seen += [view.strangers_within(reach_m)]
        rows = [value for value in seen if isinstance(value, np.ndarray)]
        told = [repr([row[i].tolist() for row in rows]) for i in range(len(view))]
        return np.array([1 + sum(map(ord, text)) % 6 for text in told])


class SizesByOthersCharge:
    """A mutant: reads the charge of robots that it does not hear."""

    def desired(self, view: RobotsView) -> Any:
        return np.full(len(view), 1 + int(1000 * view.charge.sum()) % 6)


class SizesByTruth:
    """A mutant: desires small teams where the world is wide, in truth."""

    def __init__(self, mission: Mission) -> None:
        self.mission = mission

    def desired(self, view: RobotsView) -> Any:
        return np.full(len(view), 1 + int(self.mission.world.free.sum()) % 6)


class SizesByMinds:
    """A mutant: counts whose destinations are overdue."""

    def __init__(self, mission: Mission) -> None:
        self.mission = mission

    def desired(self, view: RobotsView) -> Any:
        overdue = int((self.mission.minds.own["due_at"] > view.step).sum())
        return np.full(len(view), 1 + overdue % 6)


class PeeksAtTruth:
    """A mutant: heads for the frontier with most unexplored area behind it, in truth."""

    def __init__(self, mission: Mission) -> None:
        self.mission = mission

    def choose(self, view: LeaderView, memory: Any) -> Choice:
        world = self.mission.world
        rows, columns = np.nonzero(world.free)
        points = np.column_stack([columns, rows]) * world.resolution_m + 0.05
        cells = view.frame.cells_of(points + np.array(world.origin_m))
        area = np.zeros(view.frame.shape)
        np.add.at(area, (cells[:, 0], cells[:, 1]), 1.0)
        area[view.labels == FREE] = 0.0
        near = ndimage.uniform_filter(area, 9)
        row, col = max(view.frontiers.tolist(), key=lambda cell: near[cell[0], cell[1]])
        return Choice((row, col))


class PeeksAtMinds:
    """A mutant: keeps away from where others' destinations are overdue."""

    def __init__(self, mission: Mission) -> None:
        self.mission = mission

    def choose(self, view: LeaderView, memory: Any) -> Choice:
        overdue = int((self.mission.minds.own["due_at"] > view.step).sum())
        row, col = view.frontiers[overdue % len(view.frontiers)].tolist()
        return Choice((row, col))


class PeeksAtMemories:
    """A mutant: reads what other robots remember."""

    def __init__(self, mission: Mission) -> None:
        self.mission = mission

    def choose(self, view: LeaderView, memory: Any) -> Choice:
        theirs = sum(m is not None for m in self.mission.destinations.memories)
        row, col = view.frontiers[theirs % len(view.frontiers)].tolist()
        return Choice((row, col), memory=0.5)


class PeeksAtNotices:
    """A mutant: counts the destinations in all team notices, heard or not."""

    def __init__(self, mission: Mission) -> None:
        self.mission = mission

    def choose(self, view: LeaderView, memory: Any) -> Choice:
        said = int(self.mission.knowledge.notices["destination"].sum())
        row, col = view.frontiers[said % len(view.frontiers)].tolist()
        return Choice((row, col))


class PeeksAtMaps:
    """A mutant: reads the maps of all robots, not its own."""

    def __init__(self, mission: Mission) -> None:
        self.mission = mission

    def choose(self, view: LeaderView, memory: Any) -> Choice:
        knowledge = self.mission.knowledge
        seen = int(knowledge.grids.evidence[knowledge.rows].sum())
        row, col = view.frontiers[seen % len(view.frontiers)].tolist()
        return Choice((row, col))


class SizesByAllHeard:
    """A mutant: reads beacons that others have heard."""

    def __init__(self, mission: Mission) -> None:
        self.mission = mission

    def desired(self, view: RobotsView) -> Any:
        heard = self.mission.knowledge.heard[self.mission.knowledge.ear]
        return np.full(len(view), 1 + int(heard["destination"].sum()) % 6)
