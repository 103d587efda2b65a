"""What a user's hand may put into a mission: checked before compiled code, which checks nothing."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from swarmscout.comms.knowledge import Knowledge
from swarmscout.core.enums import CAUSES, MODES, ROBOT_CONTACT
from swarmscout.core.errors import ScenarioError
from swarmscout.mapping.evidence import EvidenceLog
from swarmscout.minds.minds import Minds
from swarmscout.planning.route_table import WAITS
from swarmscout.robots.bodies import TICKS, Bodies
from swarmscout.worlds.world import World

__all__ = ["HandCheck"]

_BODIES = ("position", "heading", "charge", "alive", "can", "touch")
_MINDS = ("own", "avoided", "avoided_next", "given_up")
"""The arrays that a hand may write into …"""

_POINTING = ("bodies.position", "bodies.heading", "bodies.touch", "minds.own")
"""… and those of them by which compiled code finds something."""


class HandCheck:
    """Whether a mission is still possible, after a user may have written into it.

    Comparing bytes with those that the last step left costs less than a hundredth of a step;
    what was written is looked at only if they differ. Bodies and minds may be changed within
    limits; the numbers by which robots find what they know may not be changed at all.

    Args:
        world: where bodies must be. cells: how many cells a map has.
        stations: how many charging stations there are.
        bodies, minds: as they begin.
    """

    def __init__(
        self, world: World, cells: int, stations: int, bodies: Bodies, minds: Minds
    ) -> None:
        self._world = world
        self._cells = cells
        robots = len(minds)
        self._ranges = {
            "leader": (0, robots - 1, "a robot"),
            "partner": (-1, robots - 1, "a robot"),
            "destination": (-1, cells - 1, "a cell"),
            "target": (-1, cells - 1, "a cell"),
            "place": (WAITS, cells - 1, "a cell"),
            "station": (-1, stations - 1, "a station"),
            "mode": (0, len(MODES) - 1, "a mode"),
            "cause": (0, len(CAUSES) - 1, "a cause"),
            "heading": (0, TICKS - 1, "tenths of a degree"),
            "aim": (-1, TICKS - 1, "tenths of a degree"),
        }
        self._forms = {
            name: (array.dtype, array.shape) for name, array in _open(bodies, minds).items()
        }
        self._left: dict[str, bytes] = {}

    def before(self, bodies: Bodies, minds: Minds, knowledge: Knowledge, log: EvidenceLog) -> None:
        """Check what was written since the last step.

        Raises:
            ScenarioError: something is impossible; put right, the mission goes on.
        """
        opened = _open(bodies, minds)
        for name, array in opened.items():
            _expect(name, array, *self._forms[name])
        if any(opened[name].tobytes() != self._left.get(name) for name in _POINTING):
            self._look_at_bodies(bodies)
            for name, (low, high, what) in self._ranges.items():
                shown = name if hasattr(minds, name) else f"own['{name}']"
                _in_range(f"minds.{shown}", minds.own[name], low, high, what)
        for name, array in _kept(knowledge, log).items():
            if self._left.get(name, b"") not in (b"", array.tobytes()):
                raise ScenarioError(
                    f"mission.{name} was changed by hand: it says where robots find what they "
                    "know; put it right"
                )
        grids = knowledge.grids
        for name, numbers, low, high in (
            ("bounds", grids.bounds, -1, grids.frame.rows),
            ("counts", grids.counts, 0, self._cells),
        ):
            used = numbers[knowledge.rows]
            if used.min() < low or used.max() > high:
                raise ScenarioError(
                    f"mission.knowledge.grids.{name} holds {used.min()} to {used.max()}: "
                    f"expected {low} to {high}"
                )

    def after(self, bodies: Bodies, minds: Minds, knowledge: Knowledge, log: EvidenceLog) -> None:
        """Remember what the step left: its own changes keep to the rules."""
        opened = _open(bodies, minds)
        self._left = {name: opened[name].tobytes() for name in _POINTING}
        self._left |= {name: array.tobytes() for name, array in _kept(knowledge, log).items()}

    def _look_at_bodies(self, bodies: Bodies) -> None:
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
        robots = len(bodies.alive)
        _in_range("bodies.heading", bodies.heading, 0, TICKS - 1, "tenths of a degree")
        _in_range("bodies.touch['kind']", bodies.touch["kind"], 0, ROBOT_CONTACT, "a contact")
        _in_range("bodies.touch['robot']", bodies.touch["robot"], -1, robots - 1, "a robot")


def _open(bodies: Bodies, minds: Minds) -> dict[str, NDArray[Any]]:
    """The arrays that a hand may write into, by name."""
    return {f"bodies.{name}": getattr(bodies, name) for name in _BODIES} | {
        f"minds.{name}": getattr(minds, name) for name in _MINDS
    }


def _kept(knowledge: Knowledge, log: EvidenceLog) -> dict[str, NDArray[np.int64]]:
    """The arrays by which robots find what they know, by name: for the mission alone to write."""
    names = ("ear", "rows", "listeners", "groups", "versions")
    return {f"knowledge.{name}": getattr(knowledge, name) for name in names} | {
        "log.length": log.length,
        "log.dropped": log.dropped,
    }


def _in_range(name: str, values: NDArray[np.int64], low: int, high: int, what: str) -> None:
    wrong = np.flatnonzero((values < low) | (values > high))
    if len(wrong):
        raise ScenarioError(
            f"mission.{name}[{wrong[0]}] = {values[wrong[0]]}: expected {what}, {low} to {high}"
        )


def _expect(name: str, array: Any, dtype: np.dtype[Any], shape: tuple[int, ...]) -> None:
    if array.shape != shape or array.dtype != dtype or not array.flags.c_contiguous:
        kind = "records" if array.dtype.names else array.dtype
        expected = "records" if dtype.names else dtype
        raise ScenarioError(
            f"mission.{name} is {kind}{list(array.shape)}, expected {expected}{list(shape)}: "
            f"write into it as mission.{name}[0] = …"
        )
