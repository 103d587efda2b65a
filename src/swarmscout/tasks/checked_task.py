"""A task in a mission: its answers are checked before other rooms use them."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from swarmscout.core.errors import TaskError, kind_in_words
from swarmscout.core.tracebacks import describe_error
from swarmscout.mapping.occupancy import FRONTIER, BeliefView, OccupancyGrids
from swarmscout.tasks.exploration import Exploration
from swarmscout.tasks.task import Task

__all__ = ["CheckedTask", "wrong_candidates", "wrong_reason", "wrong_score"]


class CheckedTask:
    """A task, asked for all maps of the swarm.

    Attributes:
        task: the task.
        name: what it is called in records and errors.
        bit: of :meth:`marks`, set for candidates.
        reach_m: see :class:`~swarmscout.tasks.task.Task`.
        explores: whether its candidates are the frontiers that occupancy grids keep.
        closes: whether a candidate that a robot stood within reach of should be none any more, as
            a frontier; other tasks may have candidates that stay.
        ends: whether the mission is over when nobody has a candidate left; not if the task's own
            `done` says when it is.

    Args:
        task, name: see above.

    Raises:
        TaskError: the task's `reach_m` is not a distance.
    """

    def __init__(self, task: Task, name: str) -> None:
        self.task = task
        self.name = name
        self.explores = type(task) is Exploration
        self.bit = FRONTIER if self.explores else 1
        self.reach_m = task.reach_m
        self.closes = isinstance(task, Exploration)
        self.ends = self.closes and type(task).done is Exploration.done
        if self.reach_m is not None and not _is_finite(self.reach_m, above=0.0):
            raise TaskError(
                f"task '{name}': reach_m = {self.reach_m!r}, expected metres above 0, or None"
            )

    def marks(self, grids: OccupancyGrids, rows: NDArray[np.int64], step: int) -> NDArray[np.uint8]:
        """Which cells of each map are candidates now.

        Args:
            grids: the maps of all groups.
            rows: int64[N], the maps that robots use; others are left out.
            step: the current step.

        Returns:
            uint8[R, C'], `bit` is set where a cell is a candidate.

        Raises:
            TaskError: the task failed, or answered something else.
        """
        if self.explores:
            return grids.status
        marks = np.zeros(grids.status.shape, dtype=np.uint8)
        for row in np.unique(rows).tolist():
            marks[row, : grids.frame.size] = self.candidates(grids.view(row), step).ravel()
        return marks

    def cells(self, grids: OccupancyGrids, marks: NDArray[np.uint8], row: int) -> NDArray[np.int64]:
        """int64[n], flat candidates of one map, ascending.

        Args:
            grids: the maps of all groups. marks: of this step. row: which map.
        """
        return grids.frontiers(row) if self.explores else marks[row].nonzero()[0]

    def candidates(self, map: BeliefView, step: int) -> NDArray[np.bool_]:
        """The task's candidates in one map, see :class:`~swarmscout.tasks.task.Task`.

        Raises:
            TaskError: the task failed, or answered something else than bool[rows, columns].
        """
        when = f"in step {step}"
        found = self._ask(lambda: self.task.candidates(map, step), when)
        self._refuse(wrong_candidates(found, map), when)
        return found  # type: ignore[no-any-return]

    def done(self, map: BeliefView, explored_m2: float, reachable_m2: float) -> str | None:
        """Why the mission is over, or None.

        Raises:
            TaskError: the task failed, or answered something else.
        """
        if self.explores:  # Asked after each step, and known to keep to its contract.
            return self.task.done(map, explored_m2, reachable_m2)
        reason = self._ask(lambda: self.task.done(map, explored_m2, reachable_m2), "in done")
        self._refuse(wrong_reason(reason), "")
        return reason  # type: ignore[no-any-return]

    def score(self, map: BeliefView, explored_m2: float) -> float:
        """What has been achieved.

        Raises:
            TaskError: the task failed, or answered something else than a number.
        """
        score = self._ask(lambda: self.task.score(map, explored_m2), "in score")
        self._refuse(wrong_score(score), "")
        return float(score)

    def _ask(self, question: Callable[[], Any], when: str) -> Any:
        try:
            return question()
        except (Exception, SystemExit) as error:
            raise TaskError(f"task '{self.name}' failed {when}: {describe_error(error)}") from error

    def _refuse(self, wrong: str | None, when: str) -> None:
        if wrong is not None:
            raise TaskError(f"task '{self.name}' {wrong}{when and f' ({when})'}")


def wrong_candidates(found: object, map: BeliefView) -> str | None:
    """What is wrong with a task's candidates in a map, or None."""
    if not isinstance(found, np.ndarray) or found.dtype != np.bool_:
        return f"returned {kind_in_words(found)} as candidates, expected bool[rows, columns]"
    if found.shape != map.frame.shape:
        return (
            f"returned candidates of shape {found.shape}, expected map.frame.shape = "
            f"{map.frame.shape}"
        )
    return None


def wrong_reason(reason: object) -> str | None:
    """What is wrong with the answer of a task's `done`, or None."""
    if reason is None or (isinstance(reason, str) and reason):
        return None
    return f"returned {reason!r} in done, expected the reason in words, or None to go on"


def wrong_score(score: object) -> str | None:
    """What is wrong with a task's score, or None."""
    return None if _is_finite(score) else f"returned {score!r} in score, expected a number"


def _is_finite(value: Any, above: float = -math.inf) -> bool:
    number = isinstance(value, int | float | np.number) and not isinstance(value, bool)
    return number and math.isfinite(value) and bool(value > above)
