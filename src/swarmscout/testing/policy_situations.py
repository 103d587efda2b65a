"""Views for policies of the desired team size: of short missions, and made up."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from swarmscout.comms.knowledge import Knowledge
from swarmscout.core.enums import CHARGE
from swarmscout.minds.minds import blank_minds
from swarmscout.mission import build
from swarmscout.mission.scenario import Scenario
from swarmscout.teams.robots_view import RobotsView
from swarmscout.testing.situations import hear_all, made_up_swarm
from swarmscout.testing.small_worlds import (
    DESIRED_SIZE,
    SILENCE_STEPS,
    short_mission,
    small_world,
)

__all__ = ["PolicySituation", "policy_situations", "robots_view"]

Cell = tuple[int, int]


@dataclass(frozen=True, slots=True)
class PolicySituation:
    """One situation of a swarm.

    Attributes:
        words: what is special about it.
        view: what the robots know.
        other: what the same number of robots know in another cave, in the same step.
    """

    words: str
    view: RobotsView
    other: RobotsView


def robots_view(
    labels: NDArray[np.uint8],
    places: Sequence[Cell],
    *,
    teams: Sequence[int] | None = None,
    charging: Sequence[int] = (),
    desired_size: int = DESIRED_SIZE,
    step: int = 1,
    seed: int = 0,
) -> RobotsView:
    """The view of robots that share a made-up map and hear each other.

    Args:
        labels: uint8[rows, columns], UNKNOWN, FREE or OCCUPIED; cells of 0.5 m.
        places: the cell that each robot stands in.
        teams: the leader of each robot's team; by default each robot is a team.
        charging: robots in CHR mode.
        desired_size: the scenario's ``teams.desired_size``.
        step: the current step.
        seed: of what the map's evidence is in detail.

    Returns:
        What :class:`swarmscout.teams.desired_size.DesiredSizes` shows in a mission.
    """
    _, knowledge, minds = made_up_swarm(labels, places, seed=seed)
    leaders = np.arange(len(places)) if teams is None else np.array(teams)
    minds.own["team"] = minds.own["leader"] = leaders
    minds.own["size"] = (leaders[:, None] == leaders).sum(axis=1)
    minds.own["mode"][list(charging)] = CHARGE
    hear_all(knowledge, minds, step)
    return RobotsView(minds, knowledge, step, desired_size, SILENCE_STEPS)


def policy_situations(seed: int = 0) -> Iterator[PolicySituation]:
    """Situations that a policy has to cope with, from plain to rare.

    Args:
        seed: of the caves.
    """
    yield _after("robots that leave their start", 2, seed)
    yield _after("teams that explore, and robots that charge", 40, seed)
    yield _after("a map and other beacons for each robot", 30, seed, own_maps=True)
    yield _after("one robot", 20, seed, robots=1)
    yield _after("robots that all charge", 25, seed, charging=True)
    yield PolicySituation("maps without a frontier, and no robot heard", _blank(seed), _blank(seed))


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
        view = RobotsView(mission.minds, mission.knowledge, step, DESIRED_SIZE, SILENCE_STEPS)
        views.append(view)
    return PolicySituation(words, *views)


def _blank(seed: int) -> RobotsView:
    robots, scenario = 4, Scenario()
    frame = build.make_frame(small_world(seed), scenario)
    knowledge = Knowledge(robots, build.make_grids(scenario, frame))
    return RobotsView(blank_minds(robots), knowledge, 1, DESIRED_SIZE, SILENCE_STEPS)
