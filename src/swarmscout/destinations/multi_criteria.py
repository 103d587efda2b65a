"""A weighted sum of criteria: near, open, away from other teams' destinations, straight on."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict
from typing import Annotated, Any

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from swarmscout.core.jit import kernel
from swarmscout.core.parameters import Metres, checked_dataclass
from swarmscout.destinations.batch import Batch, Outcome
from swarmscout.destinations.criteria_batch import BY_CRITERIA, choose_by_criteria
from swarmscout.destinations.criteria_blocks import NEAR_M, prepare
from swarmscout.destinations.path_lengths import choice_of, ways_m
from swarmscout.destinations.selector import Choice
from swarmscout.destinations.view import LeaderView

__all__ = ["MultiCriteria", "weigh"]

WRITTEN = ("at", "offered", "doubts", "score", "way_m")


@kernel
def weigh(  # type: ignore[no-untyped-def]
    frontiers,
    ways,
    unknown,
    open_area,
    members,
    headings,
    destinations,
    kept,
    place,
    weights,
    score,
):
    """Score every frontier.

    Args:
        frontiers: float64[F, 2] in metres; ways: float64[F] in metres.
        unknown, open_area: float64[F] in m².
        members: float64[n, 2] in metres; headings: float64[2, n], (cos, sin) of theirs.
        destinations: float64[T, 2] of other teams, NaN for none.
        kept: float64[2], the team's direction so far.
        place: float64[2] in metres, the leader's position.
        weights: float64[8], see ``MultiCriteria``: way, front, turn, near gain, open gain, apart,
            apart_m, ahead.
        score: float64[F], written.
    """
    x, y = place[0], place[1]
    for f in range(frontiers.shape[0]):
        fx, fy = frontiers[f, 0], frontiers[f, 1]
        total = weights[3] * unknown[f] + weights[4] * open_area[f] - weights[0] * ways[f]
        # The member that arrives first counts, not the leader: the one in front maps.
        soonest = np.inf
        for i in range(members.shape[0]):
            dx = fx - members[i, 0]
            dy = fy - members[i, 1]
            length = np.sqrt(dx * dx + dy * dy)
            # The chord of the angle: as long as the angle where it is small, 2 for about-turns.
            along = (dx * headings[0, i] + dy * headings[1, i]) / length if length > 0.0 else 1.0
            soonest = min(soonest, length + weights[2] * np.sqrt(max(0.0, 2.0 - 2.0 * along)))
        total -= weights[1] * soonest
        for t in range(destinations.shape[0]):
            dx = fx - destinations[t, 0]
            dy = fy - destinations[t, 1]
            apart = np.sqrt(dx * dx + dy * dy)
            if apart < weights[6]:
                total -= weights[5] * (1.0 - apart / weights[6])
        dx = fx - x
        dy = fy - y
        length = np.sqrt(dx * dx + dy * dy)
        if length > 0.0:
            total += weights[7] * (dx * kept[0] + dy * kept[1]) / length
        score[f] = total


@checked_dataclass
class MultiCriteria:
    """A weighted sum: near the front member, open ground, away from other teams, straight on.

    The score of a frontier, in metres, falls with the length of the leader's path, with the
    distance and turn of the member that arrives first, and with nearness to other teams'
    destinations. It rises with the unknown area close by, with open ground (unknown area minus a
    multiple of known wall) around it, and if it lies in the team's direction so far.

    Attributes:
        way: cost per metre of the leader's path.
        front: cost per metre between the frontier and the member that arrives first.
        turn_m: cost of that member's turn by one radian, in metres.
        near_gain: gain per square metre of unknown within 1 m.
        open_gain: gain per square metre of open ground within `open_m`.
        open_m: radius around a frontier in which ground counts as open.
        wall: area of unknown that one square metre of known wall cancels, in m².
        apart: cost of a destination of another team in the same place.
        apart_m: distance beyond which other teams' destinations cost nothing, in metres.
        ahead: gain for continuing in the direction so far.
        keep: share of the direction so far that is kept at each decision, in [0, 1).

    Source: this package. Multi-criteria decisions in exploration: Basilico, Amigoni (2011),
        "Exploration strategies based on multi-criteria decision making for searching environments
        in rescue operations", Autonomous Robots. Decentralized: each leader uses what it knows and
        has heard.
    """

    way: float = 0.165
    front: float = 0.87
    turn_m: Metres = 1.77
    near_gain: float = 0.56
    open_gain: float = 0.48
    open_m: Metres = 2.63
    wall: float = 5.2
    apart: float = 3.6
    apart_m: Annotated[Metres, Field(gt=0.0)] = 5.2
    ahead: float = 1.95
    keep: Annotated[float, Field(ge=0.0, lt=1.0)] = 0.63

    def choose(self, view: LeaderView, memory: Any) -> Choice:
        """See :class:`swarmscout.destinations.selector.Selector`.

        The memory is the team's direction so far.
        """
        x, y, _ = view.pose
        # None at first; the memory of another selector, such as a fallback, is ignored.
        kept_x, kept_y = memory if isinstance(memory, tuple) else (0.0, 0.0)
        ways = ways_m(view)
        headings = np.stack([np.cos(view.members_heading_rad), np.sin(view.members_heading_rad)])
        walls = view.area_m2("occupied", self.open_m)
        score = np.empty(len(ways))
        weigh(
            view.frontiers_m, ways, view.unknown_m2(NEAR_M),
            view.unknown_m2(self.open_m) - self.wall * walls, view.members_m, headings,
            view.others.destinations_m, np.array([kept_x, kept_y]),
            np.array([x, y]),
            np.array(
                [
                    self.way, self.front, self.turn_m, self.near_gain, self.open_gain, self.apart,
                    self.apart_m, self.ahead,
                ]
            ),
            score,
        )  # fmt: skip
        chosen = int(np.argmax(score))
        to_m = view.frontiers_m[chosen]
        ahead = self._ahead(np.array([kept_x]), np.array([kept_y]), to_m - np.array([[x, y]]))
        return choice_of(
            view, chosen, _reason(score[chosen], ways[chosen]), memory=tuple(ahead[0].tolist())
        )

    def chooses_in_batches(self) -> bool:
        """See :class:`swarmscout.destinations.batch.BatchSelector`.

        With negative weights a score has no bound that distance lowers.
        """
        weights = self.way, self.front, self.near_gain, self.open_gain, self.wall, self.apart
        return type(self) is MultiCriteria and min(weights) >= 0.0

    def choose_batch(self, batch: Batch, memories: Sequence[Any]) -> list[Outcome]:
        """See :class:`swarmscout.destinations.batch.BatchSelector`."""
        fixed, rules = batch.once(self, lambda: prepare(batch, asdict(self)))
        asked = batch.asked(BY_CRITERIA)
        for k, memory in enumerate(memories):
            if isinstance(memory, tuple):
                asked["kept_x"][k], asked["kept_y"][k] = memory
        own = batch.minds.own
        choose_by_criteria(
            own, batch.heard, batch.teams, batch.land, batch.memory, fixed, rules, batch.step, asked
        )
        frontiers = batch.frontiers
        from_m = np.column_stack((own["x_m"][batch.leaders], own["y_m"][batch.leaders]))
        offset_m = frontiers.centres_m[asked["at"]] - from_m
        ahead = self._ahead(asked["kept_x"], asked["kept_y"], offset_m)
        written = zip(ahead.tolist(), *(asked[name].tolist() for name in WRITTEN), strict=True)
        return [
            Outcome(
                Choice(batch.cell(at), _reason(score, way_m), memory=tuple(kept))
                if at >= 0
                else None,
                offered,
                doubts,
            )
            for kept, at, offered, doubts, score, way_m in written
        ]

    def _ahead(
        self, kept_x: NDArray[np.float64], kept_y: NDArray[np.float64], to_m: NDArray[np.float64]
    ) -> NDArray[np.float64]:
        """float64[n, 2], directions after a choice, from those before and the offset to it."""
        length = np.hypot(to_m[:, 0], to_m[:, 1])
        share = (1.0 - self.keep) / np.where(length > 0.0, length, 1.0)
        return np.column_stack(
            (self.keep * kept_x + share * to_m[:, 0], self.keep * kept_y + share * to_m[:, 1])
        )


def _reason(score: float, way_m: float) -> str:
    return f"score {score:.1f} m, way {way_m:.1f} m"
