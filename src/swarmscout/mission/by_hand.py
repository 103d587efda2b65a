"""What a user's hand may put into a mission: checked before compiled code, which checks nothing."""

from __future__ import annotations

from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from swarmscout.core.errors import ScenarioError
from swarmscout.robots.bodies import TICKS, Bodies
from swarmscout.worlds.world import World

__all__ = ["BodyCheck", "checked_function", "checked_links"]

F = TypeVar("F")


class BodyCheck:
    """Whether all bodies are still somewhere, after a user may have moved them between two steps.

    Comparing bytes with those that the last step left costs less than a thousandth of a step;
    what was written is looked at only if they differ.

    Args:
        world: where bodies must be.
    """

    def __init__(self, world: World) -> None:
        self._world = world
        self._known: tuple[bytes, bytes] = (b"", b"")

    def before(self, bodies: Bodies) -> None:
        """Check what was written since the last step.

        Raises:
            ScenarioError: a position or heading is impossible; put right, the mission goes on.
        """
        if (bodies.position.tobytes(), bodies.heading.tobytes()) != self._known:
            self._look(bodies)

    def after(self, bodies: Bodies) -> None:
        """Remember what the step left: its own moves keep to the rules."""
        self._known = bodies.position.tobytes(), bodies.heading.tobytes()

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
        wrong = np.flatnonzero((bodies.heading < 0) | (bodies.heading >= TICKS))
        if len(wrong):
            raise ScenarioError(
                f"mission.bodies.heading[{wrong[0]}] = {bodies.heading[wrong[0]]}: headings are "
                f"counted in tenths of a degree, 0 to {TICKS - 1}"
            )


def _expect(name: str, array: Any, shape: tuple[int, ...], dtype: type) -> None:
    if array.shape != shape or array.dtype != dtype or not array.flags.c_contiguous:
        raise ScenarioError(
            f"mission.bodies.{name} is {array.dtype}{list(array.shape)}, expected "
            f"{np.dtype(dtype)}{list(shape)}: write into it as mission.bodies.{name}[0] = …"
        )


def checked_function(links: F) -> F:
    """The function that says who hears whom, or None.

    Raises:
        ScenarioError: it is something else.
    """
    if links is not None and not callable(links):
        raise ScenarioError(
            f"links is a {type(links).__name__}, expected a function of the step that returns "
            "bool[N, N]: for the same links in every step, links=lambda step: matrix"
        )
    return links


def checked_links(given: Any, robots: int, step: int) -> NDArray[np.bool_]:
    """Who hears whom in a step, as a user's function says.

    Args:
        given: what it returned.
        robots: N. step: the current step.

    Returns:
        bool[N, N], C-contiguous.

    Raises:
        ScenarioError: it is no such matrix.
    """
    try:
        links = np.asarray(given)
    except ValueError:  # Rows of different lengths.
        links = np.asarray(None)
    if links.shape != (robots, robots) or links.dtype.kind not in "bui":
        what = "None" if given is None else f"{links.dtype}{list(links.shape)}"
        raise ScenarioError(
            f"links({step}) returned {what}, expected bool[{robots}, {robots}]: "
            "links[i, j] says whether robot i hears robot j"
        )
    return np.ascontiguousarray(links, dtype=np.bool_)
