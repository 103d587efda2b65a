"""Leaders' views on made-up maps, with real routes but without a mission, rare ones included."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from swarmscout.comms.knowledge import Knowledge
from swarmscout.core.enums import FREE, OCCUPIED, UNKNOWN
from swarmscout.core.events import EventLog
from swarmscout.core.grid import GridFrame
from swarmscout.core.links import Links
from swarmscout.core.streams import stream
from swarmscout.destinations.selector import Choice
from swarmscout.destinations.view import LeaderView
from swarmscout.mapping.evidence import EvidenceLog
from swarmscout.minds.minds import Minds, blank_minds
from swarmscout.mission import build
from swarmscout.mission.scenario import Scenario

__all__ = ["Situation", "leader_view", "made_up_swarm", "patchy_map", "situations"]

Cell = tuple[int, int]


@dataclass(frozen=True, slots=True)
class Situation:
    """One situation of a leader.

    Attributes:
        words: what is special about it.
        view: what the leader knows.
    """

    words: str
    view: LeaderView


def leader_view(
    labels: NDArray[np.uint8],
    leader: Cell,
    *,
    members: tuple[Cell, ...] = (),
    others: tuple[tuple[Cell, Cell | None], ...] = (),
    previous: Cell | None = None,
    step: int = 1,
    seed: int = 0,
) -> LeaderView:
    """The view of a leader on a made-up map.

    Args:
        labels: uint8[rows, columns], UNKNOWN, FREE or OCCUPIED; cells of 0.5 m.
        leader: the cell that robot 0 stands in, which leads the team.
        members: the cells of the other robots in its team, numbers 1, 2, ….
        others: other teams, of one robot each: its cell and its destination.
        previous: the team's last destination; None: it had none yet.
        step: the current step.
        seed: of the leader's random streams, and of what the map's evidence is in detail.

    Returns:
        What :class:`swarmscout.destinations.selection.Destinations` shows in a mission.
    """
    places = [leader, *members, *(place for place, _ in others)]
    team = 1 + len(members)
    scenario, knowledge, minds = made_up_swarm(labels, places, seed=seed)
    frame, own = knowledge.grids.frame, minds.own
    own["team"][:team] = own["leader"][:team] = 0
    own["size"][:team] = team
    own["due_at"] = step + 100
    if previous is not None:
        own["destination"][:team] = frame.flat(*previous)
    for robot, (_, destination) in enumerate(others, start=team):
        if destination is not None:
            own["destination"][robot] = frame.flat(*destination)
    hear_all(knowledge, minds, step)

    planner = build.make_planner(scenario, frame, minds.position_m[:1])
    witness = _Witness()
    destinations = build.make_destinations(scenario, frame, None, witness)
    destinations.decide(minds, knowledge, planner, step, EventLog(len(places)))
    return witness.views[0]


def hear_all(knowledge: Knowledge, minds: Minds, step: int) -> None:
    """Robots hear each other's beacons of a step; there is no evidence to exchange."""
    log = EvidenceLog(len(minds), 1, 1.0, 0.5)
    knowledge.send(minds, step)
    knowledge.receive(minds, log, Links.full(len(minds)), step)


def made_up_swarm(
    labels: NDArray[np.uint8], places: Sequence[Cell], *, seed: int
) -> tuple[Scenario, Knowledge, Minds]:
    """Robots that share a map that is made up, each in a team of its own.

    Args:
        labels: uint8[rows, columns], UNKNOWN, FREE or OCCUPIED; cells of 0.5 m.
        places: the cell that each robot stands in.
        seed: of the scenario, and of what the map's evidence is in detail.
    """
    scenario = Scenario(robots=len(places), seed=seed)
    frame = GridFrame(-2.0, 3.0, scenario.map.cell_m, *labels.shape)
    knowledge = Knowledge(len(places), build.make_grids(scenario, frame))
    known = np.flatnonzero(labels != UNKNOWN)
    amounts = stream(seed, "evidence").integers(900, 4000, len(known))
    signed = np.where(labels.ravel()[known] == FREE, -amounts, amounts)
    everything = np.array([len(known)], dtype=np.int64)
    knowledge.grids.apply(0, known[None, :], signed[None, :], 0 * everything, everything)

    minds = blank_minds(len(places))
    minds.own["x_m"], minds.own["y_m"] = frame.centres_of(np.array(places)).T
    minds.own["charge"] = 0.8
    return scenario, knowledge, minds


def situations(seed: int = 0) -> Iterator[Situation]:
    """Situations that a selector has to cope with, from plain to rare.

    Args:
        seed: of the maps.
    """
    rng = stream(seed, "situations")
    plain = patchy_map(rng, 30, 40)
    free = [(int(r), int(c)) for r, c in np.argwhere(plain == FREE)]
    spots = [free[k] for k in rng.permutation(len(free))[:8]]
    rest: dict[str, Any] = {"step": 21, "seed": seed}
    walls = np.argwhere(plain == OCCUPIED).tolist()
    yield Situation(
        "a team among others",
        leader_view(
            plain,
            spots[0],
            members=(spots[1], spots[2]),
            others=((spots[3], spots[4]), (spots[5], spots[6])),
            **rest,
        ),
    )
    yield Situation("no other teams", leader_view(plain, spots[0], members=(spots[1],), **rest))
    yield Situation(
        "a team of one", leader_view(plain, spots[3], others=((spots[1], None),), **rest)
    )
    yield Situation(
        "other teams without destinations (NaN)",
        leader_view(plain, spots[2], others=((spots[3], None), (spots[4], None)), **rest),
    )
    yield Situation(
        "a team with a destination before",
        leader_view(plain, spots[0], previous=(walls[0][0], walls[0][1]), **rest),
    )

    single = np.full((9, 9), OCCUPIED, dtype=np.uint8)
    single[3:6, 1:7] = FREE
    single[4, 7] = UNKNOWN
    single[3, 6] = single[5, 6] = OCCUPIED
    yield Situation("a single frontier", leader_view(single, (4, 2), others=(((3, 1), None),)))

    prison = plain.copy()
    prison[10:15, 10:15] = OCCUPIED
    prison[11:14, 11:14] = FREE
    yield Situation("frontiers to which no route leads", leader_view(prison, (12, 12), **rest))
    prison[20:25, 10:15] = OCCUPIED
    prison[21:24, 11:14] = FREE
    prison[22, 12] = UNKNOWN
    yield Situation("some frontiers to which no route leads", leader_view(prison, (25, 30), **rest))

    many = patchy_map(rng, 60, 60, unknown=0.12)
    yield Situation("hundreds of frontiers", leader_view(many, (30, 30), **rest))

    edge = np.full((12, 12), UNKNOWN, dtype=np.uint8)
    edge[0:4, 0:5] = FREE
    edge[8:12, 9:12] = FREE
    yield Situation(
        "frontiers and the leader at the map's edge",
        leader_view(edge, (0, 0), members=((11, 11),), others=(((0, 4), (11, 9)),), **rest),
    )


def patchy_map(
    rng: np.random.Generator, rows: int, columns: int, unknown: float = 0.01
) -> NDArray[np.uint8]:
    """A round known region with occupied and unknown cells here and there."""
    y, x = np.mgrid[0:rows, 0:columns]
    inside = np.hypot(y - 0.5 * rows, x - 0.5 * columns) < 0.4 * min(rows, columns)
    labels = np.where(inside, FREE, UNKNOWN).astype(np.uint8)
    drawn = rng.random((rows, columns))
    labels[inside & (drawn < unknown)] = UNKNOWN
    labels[inside & (drawn > 0.93)] = OCCUPIED
    return labels


class _Witness:
    """Keeps each leader's view."""

    def __init__(self) -> None:
        self.views: dict[int, LeaderView] = {}

    def choose(self, view: LeaderView, memory: Any) -> Choice:
        self.views[view.robot] = view
        row, col = view.frontiers[0].tolist()
        return Choice((row, col))
