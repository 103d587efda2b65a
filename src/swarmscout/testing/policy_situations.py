"""Views as policies for the desired team size meet them, the rare ones too."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.typing import NDArray

from swarmscout.comms.knowledge import Knowledge
from swarmscout.core.enums import CHARGE
from swarmscout.minds.minds import blank_minds
from swarmscout.mission import build
from swarmscout.mission.mission import Mission
from swarmscout.mission.scenario import Scenario
from swarmscout.teams.policy import DesiredSizePolicy
from swarmscout.teams.robots_view import RobotsView
from swarmscout.testing.small_worlds import small_world

__all__ = ["PolicySituation", "policy_situations", "short_mission"]

DESIRED_SIZE = 5
_cave = cache(small_world)


@dataclass(frozen=True, slots=True)
class PolicySituation:
    """What robots may meet.

    Attributes:
        words: what is special about it.
        view: what they know.
        other: what as many robots know elsewhere, in the same step.
    """

    words: str
    view: RobotsView
    other: RobotsView


def short_mission(
    seed: int = 0,
    *,
    robots: int = 8,
    own_maps: bool = False,
    policy: DesiredSizePolicy | None = None,
) -> Mission:
    """A mission of 80 steps in a small cave, with little charge, so that teams lose members.

    Args:
        seed: of the cave and the mission.
        robots: N.
        own_maps: links come and go, and each robot has a map of its own.
        policy: sets desired team sizes; by default the paper's.
    """
    scenario = Scenario.model_validate(
        {
            "robots": robots,
            "steps": 80,
            "seed": seed,
            "destinations": "nearest",
            "battery": {"capacity_steps": 120, "start_min": 0.3},
            "teams": {"leave_rule": "general", "desired_size": DESIRED_SIZE},
        }
    )

    def links(step: int) -> NDArray[np.bool_]:
        i, j = np.indices((robots, robots))
        heard: NDArray[np.bool_] = (i + j + step) % 3 != 0
        return heard

    world = _cave(seed)
    return Mission(scenario, world=world, links=links if own_maps else None, policy=policy)


def policy_situations(seed: int = 0) -> Iterator[PolicySituation]:
    """What a policy should cope with, from the plain to the rare.

    Args:
        seed: makes the caves.
    """
    yield _after("robots that leave their start", 2, seed)
    yield _after("teams that explore, and robots that charge", 40, seed)
    yield _after("a map and other beacons for each robot", 30, seed, own_maps=True)
    yield _after("one robot", 20, seed, robots=1)
    yield _after("robots that all charge", 25, seed, charging=True)
    yield PolicySituation("maps without a frontier, and nobody heard", _blank(seed), _blank(seed))


def _after(
    words: str,
    step: int,
    seed: int,
    *,
    robots: int = 8,
    own_maps: bool = False,
    charging: bool = False,
) -> PolicySituation:
    views = []
    for k in range(2):
        mission = short_mission(seed + k, robots=robots, own_maps=own_maps)
        for _ in range(step):
            mission.step()
        if charging:
            mission.minds.own["mode"] = CHARGE
        views.append(RobotsView(mission.minds, mission.knowledge, step, DESIRED_SIZE))
    return PolicySituation(words, *views)


def _blank(seed: int) -> RobotsView:
    robots, scenario = 4, Scenario()
    frame = build.make_frame(small_world(seed), scenario)
    knowledge = Knowledge(robots, build.make_grids(scenario, frame))
    return RobotsView(blank_minds(robots), knowledge, 1, DESIRED_SIZE)
