"""Several criteria weighed: near, open, off others' destinations, ahead."""

from __future__ import annotations

from typing import Annotated, Any

import numpy as np
from pydantic import Field
from pydantic.dataclasses import dataclass

from swarmscout.core.jit import kernel
from swarmscout.core.parameters import STRICT, Metres
from swarmscout.destinations.path_lengths import ways_m
from swarmscout.destinations.selector import Choice
from swarmscout.destinations.view import LeaderView

__all__ = ["MultiCriteria", "weigh"]


@kernel
def weigh(  # type: ignore[no-untyped-def]
    frontiers, ways, unknown, open_area, members, looks, destinations, kept, place, weights, score
):
    """Score every frontier.

    Args:
        frontiers: float64[F, 2] in metres; ways: float64[F] in metres.
        unknown, open_area: float64[F] in m².
        members: float64[n, 2] in metres; looks: float64[2, n], where they look (cos, sin).
        destinations: float64[T, 2] of other teams, NaN for none.
        kept: float64[2], the direction that the team has kept to.
        place: float64[2] in metres, where the leader is.
        weights: float64[8], see ``MultiCriteria``: way, front, turn, near gain, open gain, apart,
            apart_m, ahead.
        score: float64[F], written.
    """
    x, y = place[0], place[1]
    for f in range(frontiers.shape[0]):
        fx, fy = frontiers[f, 0], frontiers[f, 1]
        total = weights[3] * unknown[f] + weights[4] * open_area[f] - weights[0] * ways[f]
        # The member that is soonest there counts, not the leader: whoever is in front maps.
        soonest = np.inf
        for i in range(members.shape[0]):
            dx = fx - members[i, 0]
            dy = fy - members[i, 1]
            length = np.sqrt(dx * dx + dy * dy)
            # The chord of the angle: as long as the angle where it is small, 2 for about-turns.
            along = (dx * looks[0, i] + dy * looks[1, i]) / length if length > 0.0 else 1.0
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


@dataclass(frozen=True, slots=True, config=STRICT)
class MultiCriteria:
    """A weighted sum: near the front member, open ground, off others' targets, straight on.

    Per frontier, in metres: the way from the leader and the distance from the member that is
    soonest there (turning counted in) cost; unknown area close by and open ground round it gain,
    where ground is open if it is unknown and no wall is known near; nearness to other teams'
    destinations costs; the direction that the team has kept to so far gains.

    Attributes:
        way: what a metre of the leader's way costs.
        front: what a metre between the soonest member and the frontier costs.
        turn_m: what a member's turn by a radian costs, in metres.
        near_gain: what a square metre of unknown within 1 m is worth.
        open_gain: what a square metre of open ground within `open_m` is worth.
        open_m: how far round a frontier ground counts.
        wall: so many square metres of unknown does one of wall cancel.
        apart: what a destination of another team in the same place costs.
        apart_m: destinations of others matter up to here.
        ahead: what it is worth to go on in the direction kept to so far.
        keep: how much of that direction stays at each decision, in [0, 1).

    Source: this package. Multi-criteria decisions in exploration: Basilico, Amigoni (2011),
        "Exploration strategies based on multi-criteria decision making for searching environments
        in rescue operations", Autonomous Robots. Decentralized as it stands: each leader weighs
        what it knows and has heard.
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

        Remembers the direction kept to so far.
        """
        x, y, _ = view.pose
        # None at first; what another rule remembered, as a fallback's, says nothing here either.
        kept_x, kept_y = memory if isinstance(memory, tuple) else (0.0, 0.0)
        ways = ways_m(view)
        looks = np.stack([np.cos(view.members_heading_rad), np.sin(view.members_heading_rad)])
        walls = view.area_m2("occupied", self.open_m)
        score = np.empty(len(ways))
        weigh(
            view.frontiers_m, ways, view.unknown_m2(1.0),
            view.unknown_m2(self.open_m) - self.wall * walls, view.members_m, looks,
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
        to_x, to_y = view.frontiers_m[chosen].tolist()
        length = float(np.hypot(to_x - x, to_y - y)) or 1.0
        share = (1.0 - self.keep) / length
        row, col = view.frontiers[chosen].tolist()
        return Choice(
            (row, col),
            reason=f"score {score[chosen]:.1f} m, way {ways[chosen]:.1f} m",
            memory=(
                self.keep * kept_x + share * (to_x - x),
                self.keep * kept_y + share * (to_y - y),
            ),
        )
