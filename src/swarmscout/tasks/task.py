"""The interface of a task."""

from __future__ import annotations

from abc import abstractmethod
from typing import Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from swarmscout.mapping.occupancy import BeliefView

__all__ = ["Task"]


@runtime_checkable
class Task(Protocol):
    """What the swarm is to do: which places are worth heading for, and when the mission is done.

    A team's leader chooses its destination among the candidates of its own map. The destination
    stays valid as long as it is a candidate (unless ``renewal.rule`` is "reached"), and a member
    that comes within `reach_m` of its cell's centre has reached it. All answers depend on the
    arguments and on the task's own parameters alone: one task serves all robots.
    ``swarmscout.testing.check_task`` checks all this.

    Derive a task from this class to inherit what it does not define itself.

    Attributes:
        reach_m: a destination is reached within this distance of its cell's centre; None: within
            the scenario's ``renewal.reach_m``.

    Example:
        >>> class ThereAndBack(Task):
        ...     '''Explore for 150 steps, then return to the map's cell (20, 30).'''
        ...     def candidates(self, map, step):
        ...         cells = np.zeros(map.frame.shape, dtype=bool)
        ...         there = map.frontiers() if step <= 150 else np.array([(20, 30)])
        ...         cells[there[:, 0], there[:, 1]] = True
        ...         return cells
    """

    reach_m: float | None = None

    @abstractmethod
    def candidates(self, map: BeliefView, step: int) -> NDArray[np.bool_]:
        """Which cells are worth heading for, as far as a robot knows.

        Args:
            map: the robot's occupancy grid: ``labels`` uint8[rows, columns], ``frontiers()``
                int64[n, 2], ``frame`` with positions in metres; read-only.
            step: the current step, from 1.

        Returns:
            bool[rows, columns]. Without any candidate a team has no destination and stands still.
        """
        ...

    def done(self, map: BeliefView, explored_m2: float, reachable_m2: float) -> str | None:
        """Whether the mission is over, asked by the mission after each step.

        Args:
            map: the swarm's occupancy grid, of all evidence together.
            explored_m2: area explored so far.
            reachable_m2: area that can be explored.

        Returns:
            The reason in words, which the summary reports as ``end_reason``; None to go on. By
            default the mission goes on until its steps are used up.
        """
        return None

    def score(self, map: BeliefView, explored_m2: float) -> float:
        """What has been achieved, the more the better; the summary reports it as ``score``.

        Args:
            map: the swarm's occupancy grid, of all evidence together.
            explored_m2: area explored so far.

        Returns:
            By default the explored area.
        """
        return explored_m2
