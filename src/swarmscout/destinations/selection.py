"""Phase 6 of a step: leaders that need a destination choose one.

All leaders that need one see the same snapshot; their answers are applied in the order of robots,
so nothing depends on who was asked first.
"""

from __future__ import annotations

import math
import operator
from collections.abc import Callable
from functools import partial
from time import perf_counter
from typing import Any

import numpy as np
from numpy.typing import NDArray

from swarmscout.core.enums import CAUSES, CHARGE
from swarmscout.core.errors import SelectorError
from swarmscout.core.recorder import Decision
from swarmscout.core.tracebacks import describe_error
from swarmscout.destinations.asking import Ask, AskingSelector, TalkCounts, settle
from swarmscout.destinations.dispersal import fan_out
from swarmscout.destinations.features import Features, Frontiers, Scratch
from swarmscout.destinations.latency import Waiting
from swarmscout.destinations.renewal import due_step, find_stale, share_destinations
from swarmscout.destinations.selector import Choice, Selector
from swarmscout.destinations.view import LeaderView, OtherTeams
from swarmscout.mapping.occupancy import FRONTIER, OccupancyGrids
from swarmscout.minds.minds import (
    DESTINATION,
    DUE_AT,
    LEADER,
    MODE,
    NEEDS,
    SIZE,
    STEP,
    TARGET,
    TEAM,
    Minds,
)
from swarmscout.planning.route_table import FAILED_UNTIL
from swarmscout.planning.routes import Planner

__all__ = ["Destinations"]


class Destinations:
    """Asks the selector for the leaders that need a destination.

    Attributes:
        selector: the rule.
        name: what it is called in records.
        memories: per robot, what the selector wants to remember.
        seconds: how long the last step's decisions took.
        ask: who answers a selector that asks a language model; None: it decides alone.
        waiting: how long a model's answers take.
    """

    def __init__(
        self,
        selector: Selector,
        name: str,
        *,
        seed: int,
        robots: int,
        headings: NDArray[np.float64],
        forward_m: float,
        reach_m: float,
        stale_rule: bool,
        overdue: tuple[float, int],
        avoid_steps: int,
        latency_steps: int,
        team_position: str,
        fan: tuple[float, float, float] | None,
    ) -> None:
        self.selector = selector
        self.name = name
        self.memories: list[Any] = [None] * robots
        self.seconds = 0.0
        self.ask: Ask | None = None
        self.waiting = Waiting(latency_steps)
        self._counts = TalkCounts()
        self._seed = seed
        self._headings = headings
        self._heading_unit_rad = 2.0 * math.pi / len(headings)
        self._forward_m = forward_m
        self._reach_m = reach_m
        self._stale_rule = stale_rule
        self._overdue = overdue
        self._avoid_steps = avoid_steps
        self._centre = team_position == "center"
        self._fan = fan
        self._fan_scratch = np.zeros((2, robots), dtype=np.int64)
        self._scratch: Scratch | None = None

    def decide(
        self,
        minds: Minds,
        grids: OccupancyGrids,
        planner: Planner,
        links: NDArray[np.bool_],
        step: int,
        events: NDArray[np.int64],
        count: NDArray[np.int64],
    ) -> list[Decision]:
        """Find who needs a destination, ask, apply, and let members know.

        Returns:
            The step's decisions, in robot order.

        Raises:
            SelectorError: the selector failed, or chose a cell that is no frontier of its view.
        """
        started = perf_counter()
        frame = grids.frame
        previous = minds.state[:, DESTINATION].copy()
        no_route = planner.table.state[:, FAILED_UNTIL] > 0
        asking = find_stale(
            minds.state, minds.sending, links, minds.heard_state, minds.heard_reading,
            grids.status, FRONTIER, no_route, minds.avoided, minds.avoided_next,
            frame.origin_x_m, frame.origin_y_m, frame.cell_m, frame.columns,
            self._reach_m, self._stale_rule, self._avoid_steps, step, events, count,
        )  # fmt: skip
        decisions: list[Decision] = []
        leaders = minds.state[:, NEEDS].nonzero()[0].tolist() if asking else []
        leaders += self._answered(minds, step, leaders)
        if leaders:
            if self._scratch is None:
                self._scratch = Scratch(frame)
            frontiers: dict[int, Frontiers] = {}
            views = []
            for leader in sorted(leaders):
                m = minds.row(leader)
                if m not in frontiers:
                    frontiers[m] = Frontiers(grids, m, self._scratch)
                if len(frontiers[m].flat):
                    views.append(
                        self._view(
                            minds, grids, planner, links, frontiers[m], leader, previous, step
                        )
                    )
            for view, choice in zip(views, self._choices(views, step), strict=True):
                if choice is not None:
                    decisions.append(self._apply(view, choice, minds))
        share_destinations(minds.state, minds.sending, links, minds.listeners == 1)
        minds.state[:, TARGET] = minds.state[:, DESTINATION]
        if self._fan is not None:
            self._fan_out(minds, grids, links, *self._fan)
        self.seconds = perf_counter() - started
        return decisions

    def _fan_out(
        self,
        minds: Minds,
        grids: OccupancyGrids,
        links: NDArray[np.bool_],
        fan_m: float,
        apart_m: float,
        turn_m: float,
    ) -> None:
        frame = grids.frame
        disc = (2 * int(fan_m / frame.cell_m) + 1) ** 2
        members, targets = self._fan_scratch
        fan_out(
            minds.state, minds.sending, links, minds.heard_reading, grids.status, FRONTIER,
            self._headings, np.empty(disc, dtype=np.int64), np.empty((minds.robots, disc)), members,
            targets, frame.origin_x_m, frame.origin_y_m, frame.cell_m, frame.rows, frame.columns,
            self._reach_m, fan_m, apart_m, turn_m,
        )  # fmt: skip

    def summary(self) -> dict[str, Any]:
        """What conversations with a language model came to; empty for any other selector."""
        return {} if self.ask is None else self._counts.figures()

    def _answered(self, minds: Minds, step: int, asking: list[int]) -> list[int]:
        """Leaders that need no destination, but whose model's answer arrives now."""
        found = []
        for robot in self.waiting.arriving(step):
            state = minds.state[robot]
            if not minds.sending[robot] or state[LEADER] != robot or state[MODE] == CHARGE:
                self.waiting.drop(robot)
            elif robot not in asking:
                found.append(robot)
        return found

    def _choices(self, views: list[LeaderView], step: int) -> list[Choice | None]:
        """Everybody's choice, None for who keeps what it has; a model is asked once for all."""
        selector = self.selector
        if self.ask is None or not isinstance(selector, AskingSelector):
            return [self._ask(view) for view in views]
        choices = [self.waiting.take(view) for view in views]
        talks = {
            k: (view.robot, selector.converse(view, self.memories[view.robot]))
            for k, view in enumerate(views)
            if choices[k] is None and view.cause and not self.waiting.holds(view.robot)
        }
        told = dict(zip(talks, settle(list(talks.values()), self.ask, step), strict=True))
        for k, view in enumerate(views):
            if k in told:
                self._counts.add(told[k])
                # The view's generator has gone on: the rule looks at a fresh one.
                everything = np.ones(len(view.frontiers), dtype=np.bool_)
                rule = partial(self._ask, view.among(everything))
                choices[k] = self.waiting.put(view, told[k], rule)
            elif choices[k] is None and view.cause:
                choices[k] = self._ask(view)
        return choices

    def _ask(self, view: LeaderView) -> Choice:
        try:
            choice = self.selector.choose(view, self.memories[view.robot])
        except (Exception, SystemExit) as error:
            raise SelectorError(
                f"selector '{self.name}' failed in step {view.step} for robot {view.robot}: "
                f"{describe_error(error)}"
            ) from error
        if not isinstance(choice, Choice):
            raise SelectorError(
                f"selector '{self.name}' returned {type(choice).__name__}, not a Choice "
                f"(step {view.step}, robot {view.robot})"
            )
        return choice

    def _apply(self, view: LeaderView, choice: Choice, minds: Minds) -> Decision:
        robot, frame = view.robot, view.frame
        try:
            row, col = (operator.index(part) for part in choice.cell)
        except (TypeError, ValueError):
            row, col = -1, -1
        if not view.is_frontier((row, col)):
            raise SelectorError(
                f"selector '{self.name}' chose cell {choice.cell!r}, which is no frontier of "
                f"robot {robot}'s view in step {view.step}; choose one of view.frontiers"
            )
        x_m, y_m = frame.centre_of(row, col)
        distance_m = math.hypot(x_m - view.position_m[0], y_m - view.position_m[1])
        state = minds.state[robot]
        state[DESTINATION] = frame.flat(row, col)
        state[DUE_AT] = due_step(view.step, distance_m, self._forward_m, *self._overdue)
        self.memories[robot] = choice.memory
        near_frontiers, near_obstacles = view.neighbour_counts((row, col))
        return Decision(
            step=view.step,
            team=int(state[TEAM]),
            leader=robot,
            cause=view.cause,
            selector=self.name,
            cell=(row, col),
            x_m=x_m,
            y_m=y_m,
            distance_m=distance_m,
            frontiers=len(view.frontiers),
            frontier_neighbours=near_frontiers,
            obstacle_neighbours=near_obstacles,
            reason=choice.reason,
            details=choice.details,
            attempts=choice.attempts,
        )

    def _view(
        self,
        minds: Minds,
        grids: OccupancyGrids,
        planner: Planner,
        links: NDArray[np.bool_],
        frontiers: Frontiers,
        leader: int,
        previous: NDArray[np.int64],
        step: int,
    ) -> LeaderView:
        m = minds.row(leader)
        x_m, y_m, heading, charge = minds.reading[leader].tolist()
        # Who belongs to the team is known through the second exchange of phase 5.
        hears = minds.sending if minds.listeners == 1 else minds.sending & links[leader]
        in_team = hears & (minds.team == minds.team[leader])
        in_team[leader] = True
        members = in_team.nonzero()[0]
        heard = minds.heard_reading[m].take(members, axis=0)
        members_m = heard[:, :2].copy()
        members_heading_rad = heard[:, 2] * self._heading_unit_rad
        position_m = (x_m, y_m)
        if self._centre:
            position_m = (float(members_m[:, 0].mean()), float(members_m[:, 1].mean()))
        cells, centres_m = frontiers.cells, frontiers.centres_m
        keep = frontiers.kept(minds.avoided[leader], step)
        if keep is not None:
            cells, centres_m = cells.take(keep, axis=0), centres_m.take(keep, axis=0)
            cells.flags.writeable = False
            centres_m.flags.writeable = False
        last = int(previous[leader])
        members.flags.writeable = False
        members_m.flags.writeable = False
        members_heading_rad.flags.writeable = False
        return LeaderView(
            step=step,
            robot=leader,
            pose=(x_m, y_m, heading * self._heading_unit_rad),
            position_m=position_m,
            charge=charge,
            frame=grids.frame,
            frontiers=cells,
            frontiers_m=centres_m,
            members=members,
            members_m=members_m,
            previous=None if last < 0 else grids.frame.unflat(last),
            cause=CAUSES[minds.state[leader, NEEDS]],
            _seed=self._seed,
            _map=grids.view(m),
            _others=lambda: self._other_teams(minds, grids, m, leader),
            _route_costs=_route_costs(planner, grids, m, (x_m, y_m)),
            _features=Features(frontiers, keep, (x_m, y_m)),
            members_heading_rad=members_heading_rad,
        )

    def _other_teams(self, minds: Minds, grids: OccupancyGrids, m: int, leader: int) -> OtherTeams:
        """What the beacons of this step (or the last that were heard) say of other teams."""
        heard, reading = minds.heard_state[m], minds.heard_reading[m]
        speaks = (heard[:, STEP] >= 0) & (heard[:, LEADER] == np.arange(len(heard)))
        speaks &= (heard[:, MODE] != CHARGE) & (heard[:, TEAM] != minds.team[leader])
        speaks[leader] = False
        leaders = speaks.nonzero()[0]
        flat = heard[leaders, DESTINATION]
        destinations_m = grids.frame.centres_of(grids.frame.unflat_many(flat))
        destinations_m[flat < 0] = np.nan
        positions_m = reading[leaders, :2]
        if self._centre:
            positions_m = np.array(
                [reading[heard[:, LEADER] == other, :2].mean(axis=0) for other in leaders]
            ).reshape(-1, 2)
        sizes = heard[leaders, SIZE]
        for array in (leaders, sizes, positions_m, destinations_m):
            array.flags.writeable = False
        return OtherTeams(leaders, sizes, positions_m, destinations_m)


def _route_costs(
    planner: Planner, grids: OccupancyGrids, m: int, from_m: tuple[float, float]
) -> Callable[[NDArray[np.int64], int | None], NDArray[np.float64]]:
    def costs(cells: NDArray[np.int64], nearest: int | None) -> NDArray[np.float64]:
        row, col = grids.frame.cell_of(*from_m)
        start = grids.frame.flat(
            min(max(row, 0), grids.frame.rows - 1), min(max(col, 0), grids.frame.columns - 1)
        )
        targets = cells[:, 0] * grids.frame.columns + cells[:, 1]
        return planner.costs_from(grids, m, start, targets, nearest)

    return costs
