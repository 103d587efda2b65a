"""Several criteria weighed: open ground for the effort, off others' destinations, outward."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from swarmscout.core.jit import kernel
from swarmscout.destinations.selector import Choice
from swarmscout.destinations.ways import choice_of, ways_m
from swarmscout.minds.view import LeaderView

__all__ = ["MultiCriteria", "weigh"]


@kernel
def weigh(  # type: ignore[no-untyped-def]
    frontiers, ways, gain, members, looks, destinations, points, weights, score
):
    """Score every frontier.

    Args:
        frontiers: float64[F, 2] in metres.
        ways: float64[F], the leader's, in metres.
        gain: float64[F] in m², above 0.
        members: float64[n, 2] in metres; looks: float64[2, n], where they look (cos, sin).
        destinations: float64[T, 2] of other teams, NaN for none.
        points: float64[3, 2]: where the leader is; where it began; and the direction kept to.
        weights: float64[8], see ``MultiCriteria``: turn_m, leader, start_m, hurry, apart, apart_m,
            ahead, outward.
        score: float64[F], written.
    """
    turn_m, leader, start_m, hurry = weights[0], weights[1], weights[2], weights[3]
    apart, apart_m, ahead, outward = weights[4], weights[5], weights[6], weights[7]
    for f in range(frontiers.shape[0]):
        x, y = frontiers[f, 0], frontiers[f, 1]
        # The member that is soonest there counts for most: whoever is in front maps.
        soonest = np.inf
        for i in range(members.shape[0]):
            dx = x - members[i, 0]
            dy = y - members[i, 1]
            length = np.sqrt(dx * dx + dy * dy)
            # The chord of the angle: as long as the angle where it is small, 2 for about-turns.
            along = (dx * looks[0, i] + dy * looks[1, i]) / length if length > 0.0 else 1.0
            soonest = min(soonest, length + turn_m * np.sqrt(max(0.0, 2.0 - 2.0 * along)))
        effort = leader * ways[f] + (1.0 - leader) * soonest
        total = np.log(gain[f]) - hurry * np.log(start_m + effort)
        for t in range(destinations.shape[0]):
            dx = x - destinations[t, 0]
            dy = y - destinations[t, 1]
            distance = np.sqrt(dx * dx + dy * dy)
            if distance < apart_m:
                total -= apart * (1.0 - distance / apart_m)
        dx = x - points[1, 0]
        dy = y - points[1, 1]
        total += outward * np.sqrt(dx * dx + dy * dy)
        dx = x - points[0, 0]
        dy = y - points[0, 1]
        length = np.sqrt(dx * dx + dy * dy)
        if length > 0.0:
            total += ahead * (dx * points[2, 0] + dy * points[2, 1]) / length
        score[f] = total


@dataclass(frozen=True, slots=True)
class MultiCriteria:
    """Most open ground for the time it takes, off others' targets, straight on and outward.

    The score of a frontier is a logarithm, so far ones with much behind them stay in the race:
    ``log(gain) - hurry · log(start_m + effort) - crowding + ahead + outward``. The gain is unknown
    area close by and open ground round it, where ground is open if it is unknown and no wall is
    known near. The effort is the straight distance of the member that is soonest there, turning
    counted in, and to a smaller part the leader's way. Other teams' destinations nearby cost; the
    direction that the team has kept to and distance from where the leader began gain.

    Attributes:
        near_gain: what a square metre of unknown within 1 m is worth beside one of open ground.
        open_m: how far round a frontier ground counts.
        wall: so many square metres of unknown does one of wall cancel.
        least_m2: gain of a frontier with nothing open round it.
        turn_m: what a turn by a radian costs, in metres.
        leader: the share of the leader's way in the effort, in [0, 1].
        start_m: added to every effort; so much does a new destination cost in itself.
        hurry: how much effort counts beside gain; 1 is gain per effort.
        apart: what a destination of another team in the same place costs.
        apart_m: destinations of others matter up to here.
        ahead: what it is worth to go on in the direction kept to so far.
        keep: how much of that direction stays at each decision, in [0, 1).
        outward_per_m: what a metre away from where the leader began is worth.

    Source: this package. Multi-criteria decisions in exploration: Basilico, Amigoni (2011),
        "Exploration strategies based on multi-criteria decision making for searching environments
        in rescue operations", Autonomous Robots. Decentralized as it stands: each leader weighs
        what it knows and has heard. Tuned by ``benchmarks/tune_selectors.py``.
    """

    near_gain: float = 0.5
    open_m: float = 2.2
    wall: float = 2.5
    least_m2: float = 0.15
    turn_m: float = 0.5
    leader: float = 0.12
    start_m: float = 2.4
    hurry: float = 1.6
    apart: float = 1.2
    apart_m: float = 4.5
    ahead: float = 0.4
    keep: float = 0.5
    outward_per_m: float = 0.1

    def __post_init__(self) -> None:
        if not 0.0 <= self.keep < 1.0:
            raise ValueError(f"keep = {self.keep:g} must be at least 0 and below 1")
        if not 0.0 <= self.leader <= 1.0:
            raise ValueError(f"leader = {self.leader:g} must be from 0 to 1")
        for name in ("apart_m", "least_m2", "start_m"):
            if not getattr(self, name) > 0.0:
                raise ValueError(f"{name} = {getattr(self, name):g} must be above 0")
        if not self.near_gain >= 0.0:
            raise ValueError(f"near_gain = {self.near_gain:g} must be at least 0")
        if not self.turn_m >= 0.0:
            raise ValueError(f"turn_m = {self.turn_m:g} must be at least 0")

    def choose(self, view: LeaderView, memory: Any) -> Choice:
        """See :class:`swarmscout.destinations.selector.Selector`.

        Remembers the direction kept to so far, and where the leader chose for the first time.
        """
        x, y, _ = view.pose
        # None at first; what another rule remembered, as a fallback's, says nothing here either.
        known = isinstance(memory, tuple) and len(memory) == 4
        kept_x, kept_y, home_x, home_y = memory if known else (0.0, 0.0, x, y)
        ways = ways_m(view)
        looks = np.stack([np.cos(view.members_heading_rad), np.sin(view.members_heading_rad)])
        is_open = view.unknown_m2(self.open_m) - self.wall * view.area_m2("occupied", self.open_m)
        gain = np.maximum(is_open, 0.0) + self.near_gain * view.unknown_m2(1.0) + self.least_m2
        score = np.empty(len(ways))
        weigh(
            view.frontiers_m, ways, gain, view.members_m, looks,
            view.others.destinations_m,
            np.array([[x, y], [home_x, home_y], [kept_x, kept_y]]),
            np.array(
                [
                    self.turn_m, self.leader, self.start_m, self.hurry, self.apart, self.apart_m,
                    self.ahead, self.outward_per_m,
                ]
            ),
            score,
        )  # fmt: skip
        chosen = int(np.argmax(score))
        to_x, to_y = view.frontiers_m[chosen].tolist()
        length = float(np.hypot(to_x - x, to_y - y)) or 1.0
        share = (1.0 - self.keep) / length
        return choice_of(
            view,
            chosen,
            f"score {score[chosen]:.2f}: gain {gain[chosen]:.1f} m², way {ways[chosen]:.1f} m",
            (
                self.keep * kept_x + share * (to_x - x),
                self.keep * kept_y + share * (to_y - y),
                home_x,
                home_y,
            ),
        )
