"""Building the views of leaders that choose in a step, from what each of them knows."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from swarmscout.comms.knowledge import Knowledge
from swarmscout.core.enums import CAUSES
from swarmscout.destinations.candidates import Candidates
from swarmscout.destinations.features import Features
from swarmscout.destinations.view import LeaderView, OtherTeams
from swarmscout.minds.minds import Minds
from swarmscout.minds.modes import on_task
from swarmscout.planning.routes import Planner

__all__ = ["LeaderViews", "ViewSettings"]


@dataclass(frozen=True)
class ViewSettings:
    """What views depend on besides a robot's knowledge.

    Attributes:
        seed: the mission's.
        centre: whether a team's position is the mean of its members', else its leader's.
        ticks: heading ticks of a full circle.
        silence_steps: a robot that was not heard for more steps than this counts no more.
    """

    seed: int
    centre: bool
    ticks: int
    silence_steps: int


class LeaderViews:
    """Views of one step; what leaders share is computed once for each map.

    Args:
        minds: what robots believe.
        knowledge: what they have heard.
        planner: plans routes.
        settings: see above.
        candidates: of the task, of this step.
        step: the current step.
    """

    def __init__(
        self,
        minds: Minds,
        knowledge: Knowledge,
        planner: Planner,
        settings: ViewSettings,
        candidates: Candidates,
        step: int,
    ) -> None:
        self._minds = minds
        self._knowledge = knowledge
        self._planner = planner
        self._settings = settings
        self._candidates = candidates
        self._step = step

    def of(self, leader: int, previous: int) -> LeaderView | None:
        """What a leader knows; None if it may choose no candidate now.

        Args:
            leader: the robot.
            previous: the flat cell of its team's last destination, or -1.
        """
        grids, row = self._knowledge.grids, int(self._knowledge.ear[leader])
        offered = self._candidates.offered(leader)
        if offered is None:
            return None
        frontiers = self._candidates.of_map(row)
        me, unit_rad = self._minds.own[leader], 2.0 * math.pi / self._settings.ticks
        place_m = (float(me["x_m"]), float(me["y_m"]))
        members, members_m, headings = self._members(leader, row)
        position_m = place_m
        if self._settings.centre:
            position_m = (float(members_m[:, 0].mean()), float(members_m[:, 1].mean()))
        keep = None if offered.all() else offered.nonzero()[0]
        cells, centres_m = frontiers.cells, frontiers.centres_m
        if keep is not None:
            cells, centres_m = cells.take(keep, axis=0), centres_m.take(keep, axis=0)
        for array in (cells, centres_m, members, members_m):
            array.flags.writeable = False
        headings_rad = headings * np.float64(unit_rad)
        headings_rad.flags.writeable = False
        return LeaderView(
            step=self._step,
            robot=leader,
            pose=(*place_m, int(me["heading"]) * unit_rad),
            position_m=position_m,
            charge=float(me["charge"]),
            frame=grids.frame,
            frontiers=cells,
            frontiers_m=centres_m,
            members=members,
            members_m=members_m,
            members_heading_rad=headings_rad,
            previous=None if previous < 0 else grids.frame.unflat(previous),
            cause=CAUSES[me["cause"]],
            _seed=self._settings.seed,
            _map=grids.view(row),
            _others=lambda: self._other_teams(leader, row),
            _route_costs=self._route_costs(row, place_m),
            _features=Features(frontiers, keep, place_m),
        )

    def _members(
        self, leader: int, row: int
    ) -> tuple[NDArray[np.int64], NDArray[np.float64], NDArray[np.int64]]:
        """Robots of a leader's team that it hears, itself too; where, and how they look."""
        knowledge = self._knowledge
        in_team = knowledge.noticed(leader, self._step)
        in_team &= knowledge.notices["team"] == self._minds.team[leader]
        in_team[leader] = True
        members = in_team.nonzero()[0]
        heard = knowledge.heard[row].take(members)
        return members, _points(heard), heard["heading"]

    def _other_teams(self, leader: int, row: int) -> OtherTeams:
        """What beacons say of other teams: each robot's last, unless it has been silent since."""
        heard = self._knowledge.heard[row]
        recent = (heard["step"] >= 0) & (heard["step"] >= self._step - self._settings.silence_steps)
        speaks = recent & (heard["leader"] == np.arange(len(heard)))
        speaks &= on_task(heard["mode"]) & (heard["team"] != self._minds.team[leader])
        speaks[leader] = False
        leaders = speaks.nonzero()[0]
        told = heard.take(leaders)
        frame, flat = self._knowledge.grids.frame, told["destination"]
        destinations_m = frame.centres_of(frame.unflat_many(flat))
        destinations_m[flat < 0] = np.nan
        positions_m = _points(told)
        if self._settings.centre:
            places_m = _points(heard)
            positions_m = np.array(
                [places_m[recent & (heard["leader"] == other)].mean(axis=0) for other in leaders]
            ).reshape(-1, 2)
        sizes = told["size"].copy()
        for array in (leaders, sizes, positions_m, destinations_m):
            array.flags.writeable = False
        return OtherTeams(leaders, sizes, positions_m, destinations_m)

    def _route_costs(
        self, row: int, place_m: tuple[float, float]
    ) -> Callable[[NDArray[np.int64], int | None], NDArray[np.float64]]:
        grids, planner = self._knowledge.grids, self._planner

        def costs(cells: NDArray[np.int64], nearest: int | None) -> NDArray[np.float64]:
            frame = grids.frame
            at_row, at_col = frame.cell_of(*place_m)
            start = frame.flat(
                min(max(at_row, 0), frame.rows - 1), min(max(at_col, 0), frame.columns - 1)
            )
            targets = cells[:, 0] * frame.columns + cells[:, 1]
            return planner.costs_from(grids, row, start, targets, nearest)

        return costs


def _points(beacons: NDArray[np.void]) -> NDArray[np.float64]:
    """float64[n, 2], where robots were when they sent their beacons."""
    points = np.empty((len(beacons), 2))
    points[:, 0], points[:, 1] = beacons["x_m"], beacons["y_m"]
    return points
