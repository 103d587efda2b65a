"""Phase 6 of a step: leaders that need a destination choose one.

All leaders that need one see the same snapshot; their answers are applied in the order of robots,
so the order in which they are asked does not matter.
"""

from __future__ import annotations

import math
import operator
from dataclasses import dataclass, replace
from functools import partial
from time import perf_counter
from typing import Any

import numpy as np
from numpy.typing import NDArray

from swarmscout.comms.knowledge import Knowledge
from swarmscout.core.enums import CAUSES
from swarmscout.core.errors import SelectorError
from swarmscout.core.events import EventLog
from swarmscout.core.grid import GridFrame
from swarmscout.core.recorder import Decision
from swarmscout.core.tracebacks import describe_error
from swarmscout.destinations.asking import Ask, AskingSelector, TalkCounts, settle
from swarmscout.destinations.batch import BatchSelector
from swarmscout.destinations.batching import Batching
from swarmscout.destinations.candidates import Candidates
from swarmscout.destinations.dispersal import FAN, fan_out
from swarmscout.destinations.features import Scratch
from swarmscout.destinations.latency import Waiting
from swarmscout.destinations.leader_views import LeaderViews, ViewSettings
from swarmscout.destinations.parameters import DispersalParameters, RenewalParameters
from swarmscout.destinations.renewal import (
    RENEWAL,
    avoid_given_up,
    due_step,
    find_stale,
    report_reached,
    share_destinations,
)
from swarmscout.destinations.selector import Choice, Selector
from swarmscout.destinations.view import LeaderView
from swarmscout.mapping.occupancy import BeliefView
from swarmscout.minds.given_up import PLACE_M
from swarmscout.minds.minds import Minds
from swarmscout.minds.modes import on_task
from swarmscout.planning.routes import Planner
from swarmscout.tasks.checked_task import CheckedTask

__all__ = ["Destinations", "Setting"]


@dataclass(frozen=True)
class Setting:
    """What choosing depends on besides its own parameters.

    Attributes:
        seed: the mission's.
        robots: N.
        frame: the occupancy grids'.
        headings: float64[ticks, 2], (cos, sin).
        forward_m: length of a robot's move.
        latency_steps: how long a language model's answer takes.
        centre: whether a team's position is the mean of its members', else its leader's.
        silence_steps: a robot that was not heard for more steps than this counts no more.
        range_m: longest range of the robots' sensors.
        stop_m: a robot's route ends this near to its goal.
    """

    seed: int
    robots: int
    frame: GridFrame
    headings: NDArray[np.float64]
    forward_m: float
    latency_steps: int
    centre: bool
    silence_steps: int
    range_m: float
    stop_m: float


@dataclass(frozen=True)
class Asked:
    """A leader that was asked.

    Attributes:
        robot: the leader. position_m: where its team is.
        candidates: how many it could choose from.
    """

    robot: int
    position_m: tuple[float, float]
    candidates: int


class Destinations:
    """Asks the selector for the leaders that need a destination.

    Attributes:
        selector: the rule.
        name: what it is called in records.
        memories: per robot, what the selector wants to remember.
        seconds: how long the last step's decisions took.
        ask: who answers a selector that asks a language model; None: it decides alone.
        waiting: how long a model's answers take.

    Args:
        selector, name: see above.
        renewal: when a destination is renewed.
        dispersal: how members fan out.
        setting: see above.
        task: says which cells are worth heading for.
    """

    def __init__(
        self,
        selector: Selector,
        name: str,
        renewal: RenewalParameters,
        dispersal: DispersalParameters,
        setting: Setting,
        task: CheckedTask,
    ) -> None:
        self.selector = selector
        self.name = name
        self.memories: list[Any] = [None] * setting.robots
        self.seconds = 0.0
        self.ask: Ask | None = None
        self.waiting = Waiting(setting.latency_steps)
        self._task = task
        self._counts = TalkCounts()
        self._headings = setting.headings
        self._forward_m = setting.forward_m
        self._renewal = renewal
        self._views = ViewSettings(
            setting.seed, setting.centre, len(setting.headings), setting.silence_steps
        )
        self._scratch = Scratch(setting.frame)
        self._rules = _record(RENEWAL, setting, renewal, task)
        self._batching = Batching(
            self._views, self._rules, needs_views=not task.explores or setting.centre
        )
        self._fan = None
        if dispersal.members == "fan":
            self._fan = _record(FAN, setting, renewal, task)
            self._fan["fan_m"], self._fan["turn_m"] = dispersal.fan_m, dispersal.fan_turn_m
            self._fan["apart_m"] = dispersal.fan_apart_m
            # A change of mind costs as much as a turn by a radian, so swapping does not pay.
            self._fan["keep_m"] = dispersal.fan_turn_m + setting.forward_m

    def decide(
        self, minds: Minds, knowledge: Knowledge, planner: Planner, step: int, events: EventLog
    ) -> list[Decision]:
        """Find who needs a destination, ask, apply, and let members know.

        Returns:
            The step's decisions, in robot order.

        Raises:
            SelectorError: the selector failed, or chose a cell that is not a frontier of its view.
            TaskError: the task failed.
        """
        started = perf_counter()
        own, ear, heard, notices = minds.own, knowledge.ear, knowledge.heard, knowledge.notices
        previous = minds.destination.copy()
        marks = self._task.marks(knowledge.grids, ear, step)
        knowledge.tell(minds, step)
        report_reached(own, notices, planner.table.state, self._rules)
        asking = find_stale(
            own, ear, heard, notices, marks, minds.given_up, planner.table.state, self._rules, step,
            events.rows,
        )  # fmt: skip
        decisions: list[Decision] = []
        leaders = own["cause"].nonzero()[0].tolist() if asking else []
        if asking:
            avoid_given_up(
                own, ear, heard, notices, minds.avoided, minds.avoided_next, minds.given_up,
                self._rules, step,
            )  # fmt: skip
        leaders += self._answered(minds, step, leaders)
        if leaders:
            candidates = self._candidates(minds, knowledge, planner, marks, step)
            rule = self._batching.rule(self.selector)
            if rule is not None:
                decisions = self._decide_in_batches(
                    rule, leaders, minds, knowledge, candidates, step
                )
            else:
                views = LeaderViews(minds, knowledge, planner, self._views, candidates, step)
                asked = [views.of(leader, int(previous[leader])) for leader in sorted(leaders)]
                able = [view for view in asked if view is not None]
                for view, choice in zip(able, self._choices(able, step), strict=True):
                    if choice is not None:
                        decisions.append(self._decide_for(view, choice, minds))
            knowledge.tell(minds, step)
        share_destinations(own, ear, heard, notices, step)
        if self._fan is not None:
            fan_out(own, ear, heard, notices, marks, self._headings, self._fan, step)
        self.seconds = perf_counter() - started
        return decisions

    def exhausted(
        self,
        minds: Minds,
        knowledge: Knowledge,
        planner: Planner,
        mobile: NDArray[np.bool_],
        step: int,
    ) -> bool:
        """Whether no team will find a candidate to head for any more.

        That is so if no robot has a destination, and on each leader's own map no route reaches a
        candidate whose place is not closed. Robots that charge are included, as they will explore
        again; while all robots charge, the answer is False. It is False, too, while a member has
        lost its leader, for it will soon lead or follow another one.

        Args:
            minds: what robots believe. knowledge: what they have heard. planner: plans routes.
            mobile: bool[N], who can drive. step: the current step.
        """
        own = minds.own
        able = own["thinks"] & mobile
        heads = able & (own["leader"] == np.arange(len(own)))
        leads = heads & on_task(own["mode"])
        if (
            not self._task.ends
            or (own["destination"][able] >= 0).any()
            or not leads.any()
            or not own["hopeless"][leads].all()
            or not heads[own["leader"][able]].all()
        ):
            return False
        marks = self._task.marks(knowledge.grids, knowledge.ear, step)
        candidates = self._candidates(minds, knowledge, planner, marks, step)
        return all(candidates.is_hopeless(robot) for robot in heads.nonzero()[0].tolist())

    def summary(self) -> dict[str, Any]:
        """What conversations with a language model came to; empty for any other selector."""
        return {} if self.ask is None else self._counts.figures()

    def _decide_in_batches(
        self,
        rule: BatchSelector,
        leaders: list[int],
        minds: Minds,
        knowledge: Knowledge,
        candidates: Candidates,
        step: int,
    ) -> list[Decision]:
        """Let the rule choose for all leaders of a map in one call."""
        outcomes = self._batching.outcomes(
            rule, leaders, self.memories, minds, knowledge, candidates, step
        )
        decisions = []
        for robot in leaders:
            outcome = outcomes.get(robot)
            if outcome is None or outcome.choice is None:
                candidates.offered(robot)  # It notes when to look again.
                continue
            me = minds.own[robot]
            candidates.take(me, doubts=outcome.doubts)
            asked = Asked(robot, (me["x_m"].item(), me["y_m"].item()), outcome.offered)
            grids = knowledge.grids.view(int(knowledge.ear[robot]))
            decisions.append(self._apply(asked, outcome.choice, me, grids, step))
        return decisions

    def _candidates(
        self,
        minds: Minds,
        knowledge: Knowledge,
        planner: Planner,
        marks: NDArray[np.uint8],
        step: int,
    ) -> Candidates:
        cells = partial(self._task.cells, knowledge.grids, marks)
        return Candidates(minds, knowledge, planner, self._scratch, cells, self._rules, step)

    def _answered(self, minds: Minds, step: int, asking: list[int]) -> list[int]:
        """Leaders that need no destination, but whose model's answer arrives now."""
        found = []
        for robot in self.waiting.arriving(step):
            me = minds.own[robot]
            if not me["thinks"] or me["leader"] != robot or not on_task(me["mode"]):
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

    def _decide_for(self, view: LeaderView, choice: Choice, minds: Minds) -> Decision:
        try:
            row, col = (operator.index(part) for part in choice.cell)
        except (TypeError, ValueError):
            row, col = -1, -1
        if not view.is_frontier((row, col)):
            raise SelectorError(
                f"selector '{self.name}' chose cell {choice.cell!r}, which is no frontier of "
                f"robot {view.robot}'s view in step {view.step}; choose one of view.frontiers"
            )
        asked = Asked(view.robot, view.position_m, len(view.frontiers))
        choice = replace(choice, cell=(row, col))
        return self._apply(asked, choice, minds.own[view.robot], view._map, view.step)

    def _apply(
        self, asked: Asked, choice: Choice, me: np.void, grids: BeliefView, step: int
    ) -> Decision:
        """Write a choice into the leader's own record, and make the decision to be recorded."""
        frame, cell = grids.frame, choice.cell
        x_m, y_m = frame.centre_of(*cell)
        distance_m = math.hypot(x_m - asked.position_m[0], y_m - asked.position_m[1])
        me["destination"] = frame.flat(*cell)
        overdue = self._renewal.overdue_factor, self._renewal.overdue_steps
        me["due_at"] = due_step(step, distance_m, self._forward_m, *overdue)
        self.memories[asked.robot] = choice.memory
        near_frontiers, near_obstacles = grids.neighbour_counts(cell)
        return Decision(
            step=step,
            team=int(me["team"]),
            leader=asked.robot,
            cause=CAUSES[me["cause"]],
            selector=self.name,
            cell=cell,
            x_m=x_m,
            y_m=y_m,
            distance_m=distance_m,
            frontiers=asked.candidates,
            frontier_neighbours=near_frontiers,
            obstacle_neighbours=near_obstacles,
            reason=choice.reason,
            details=choice.details,
            attempts=choice.attempts,
        )


def _record(
    dtype: np.dtype[np.void], setting: Setting, renewal: RenewalParameters, task: CheckedTask
) -> NDArray[np.void]:
    """Rules as an argument of kernels: one record, in an array, which costs the least per call."""
    record, frame = np.zeros(1, dtype=dtype), setting.frame
    frame.write_into(record[0])
    record["candidate_bit"] = task.bit
    reach_m = task.reach_m
    if reach_m is None:
        # Where a destination counts as reached, the sensor has to see past its cell; but robots
        # stop at the end of their routes, which lies before the goal.
        reach_m = min(renewal.reach_m, max(setting.range_m - frame.cell_m, setting.stop_m))
    record["reach_m"] = reach_m
    if dtype is RENEWAL:
        record["stale_rule"] = renewal.rule == "stale"
        record["avoid_steps"] = renewal.avoid_steps
        record["closes"] = task.closes
        record["place_cells"] = max(1, round(PLACE_M / frame.cell_m))
    return record
