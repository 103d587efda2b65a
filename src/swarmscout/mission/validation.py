"""What a user's hand may put into a mission: checked before compiled code, which checks nothing."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from swarmscout.core.errors import ScenarioError
from swarmscout.minds.minds import Minds
from swarmscout.robots.bodies import TICKS, Bodies
from swarmscout.worlds.world import World

__all__ = ["HandCheck"]


class HandCheck:
    """Whether bodies and minds are still possible, after a user may have written into them.

    Comparing bytes with those that the last step left costs less than a hundredth of a step;
    what was written is looked at only if they differ.

    Args:
        world: where bodies must be. cells: how many cells a map has.
    """

    def __init__(self, world: World, cells: int) -> None:
        self._world = world
        self._cells = cells
        self._position = self._heading = self._own = b""

    def before(self, bodies: Bodies, minds: Minds) -> None:
        """Check what was written since the last step.

        Raises:
            ScenarioError: something is impossible; put right, the mission goes on.
        """
        if (
            bodies.position.tobytes() != self._position
            or minds.own.tobytes() != self._own
            or bodies.heading.tobytes() != self._heading
        ):
            self._look(bodies)
            robots, cells = len(minds), self._cells
            _in_range("minds.leader", minds.leader, 0, robots - 1, "a robot")
            _in_range("minds.own['partner']", minds.own["partner"], -1, robots - 1, "a robot")
            _in_range("minds.destination", minds.destination, -1, cells - 1, "a cell")
            _in_range("minds.target", minds.target, -1, cells - 1, "a cell")

    def after(self, bodies: Bodies, minds: Minds) -> None:
        """Remember what the step left: its own changes keep to the rules."""
        self._position = bodies.position.tobytes()
        self._own = minds.own.tobytes()
        self._heading = bodies.heading.tobytes()

    def _look(self, bodies: Bodies) -> None:
        robots = len(bodies.alive)
        _expect("position", bodies.position, (robots, 2), np.float64)
        _expect("heading", bodies.heading, (robots,), np.int64)
        frame = self._world.frame
        left, right, bottom, top = frame.extent
        for robot, (x, y) in enumerate(bodies.position.tolist()):
            where = f"mission.bodies.position[{robot}] = ({x:g}, {y:g}) m"
            if not (left < x < right and bottom < y < top):
                raise ScenarioError(
                    f"{where} lies outside the world: x from {left:g} to {right:g} m, "
                    f"y from {bottom:g} to {top:g} m"
                )
            row, col = frame.cell_of(x, y)
            if not frame.contains(row, col) or not self._world.free[row, col]:
                raise ScenarioError(f"{where} is in a wall: put the robot where the world is free")
        _in_range("bodies.heading", bodies.heading, 0, TICKS - 1, "tenths of a degree")


def _in_range(name: str, values: NDArray[np.int64], low: int, high: int, what: str) -> None:
    wrong = np.flatnonzero((values < low) | (values > high))
    if len(wrong):
        raise ScenarioError(
            f"mission.{name}[{wrong[0]}] = {values[wrong[0]]}: expected {what}, {low} to {high}"
        )


def _expect(name: str, array: Any, shape: tuple[int, ...], dtype: type) -> None:
    if array.shape != shape or array.dtype != dtype or not array.flags.c_contiguous:
        raise ScenarioError(
            f"mission.bodies.{name} is {array.dtype}{list(array.shape)}, expected "
            f"{np.dtype(dtype)}{list(shape)}: write into it as mission.bodies.{name}[0] = …"
        )
