"""All robots' minds as a structure of arrays; row i belongs to robot i.

A rule for robot i reads row i of its own state and what i has heard, and nothing else. What it has
heard stands in tables with a row per *listener*. Under full communication all listeners hear the
same, so one shared row serves everybody (`listeners == 1`); otherwise each robot has its own.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from swarmscout.core.enums import EXPLORE

__all__ = [
    "BEACON",
    "DESIRED",
    "DESTINATION",
    "DUE_AT",
    "LEADER",
    "MODE",
    "NEEDS",
    "PICK",
    "SIZE",
    "STEP",
    "TARGET",
    "TEAM",
    "Minds",
    "blank_minds",
]

# Columns of a mind's state. The first BEACON columns are what a beacon carries.
STEP = 0  # when the beacon was sent; -1: never heard
TEAM = 1  # the team's id
LEADER = 2  # the robot that leads it
MODE = 3  # EXPLORE or CHARGE
SIZE = 4  # members of the team, as the robot knows
DESIRED = 5  # desired team size
PICK = 6  # a leader's partner for joining: a robot of the other team, or -1
DESTINATION = 7  # flat cell of the map, or -1
BEACON = 8
TARGET = 8  # private: flat cell that it drives to itself: the destination, or one near it; or -1
NEEDS = 9  # private: why a new destination is needed, a code of CAUSES
DUE_AT = 10  # private: the step after which the destination is overdue
COLUMNS = 11


@dataclass(slots=True)
class Minds:
    """What N robots believe.

    Attributes:
        state: int64[N, 11], columns above.
        reading: float64[N, 4], own believed x_m, y_m, heading in ticks, and charge as a share.
        sending: bool[N], False for a robot whose charge is gone: it says and decides nothing.
        heard_state: int64[K, N, 8], the last beacon heard of each robot, for each listener.
        heard_reading: float64[K, N, 4], the reading in it.
        still: int64[K, N], for how many steps a robot has not moved, as far as is known.
        avoided: int64[N, 32, 2], cells that the robot's team gave up, and until which step.
        avoided_next: int64[N], the place in `avoided` to be written next.
    """

    state: NDArray[np.int64]
    reading: NDArray[np.float64]
    sending: NDArray[np.bool_]
    heard_state: NDArray[np.int64]
    heard_reading: NDArray[np.float64]
    still: NDArray[np.int64]
    avoided: NDArray[np.int64]
    avoided_next: NDArray[np.int64]

    @property
    def robots(self) -> int:
        """N."""
        return len(self.state)

    @property
    def listeners(self) -> int:
        """K: 1 if all hear the same, N if each has its own row."""
        return len(self.heard_state)

    def row(self, robot: int) -> int:
        """The row of the heard tables (and of the maps) that belongs to a robot."""
        return robot if self.listeners > 1 else 0

    @property
    def team(self) -> NDArray[np.int64]:
        """int64[N], team ids."""
        return self.state[:, TEAM]

    @property
    def leader(self) -> NDArray[np.int64]:
        """int64[N], each robot's leader."""
        return self.state[:, LEADER]

    @property
    def mode(self) -> NDArray[np.int64]:
        """int64[N], EXPLORE or CHARGE."""
        return self.state[:, MODE]

    @property
    def desired(self) -> NDArray[np.int64]:
        """int64[N], desired team sizes."""
        return self.state[:, DESIRED]

    @property
    def destination(self) -> NDArray[np.int64]:
        """int64[N], flat cells or -1."""
        return self.state[:, DESTINATION]

    @property
    def target(self) -> NDArray[np.int64]:
        """int64[N], flat cells that robots drive to themselves, or -1."""
        return self.state[:, TARGET]


def blank_minds(robots: int, *, shared: bool) -> Minds:
    """N robots that are alone, explore, and have heard nothing.

    Args:
        robots: N.
        shared: True under full communication: all listeners share one row.
    """
    listeners = 1 if shared else robots
    state = np.zeros((robots, COLUMNS), dtype=np.int64)
    state[:, TEAM] = np.arange(robots)
    state[:, LEADER] = np.arange(robots)
    state[:, MODE] = EXPLORE
    state[:, SIZE] = 1
    state[:, DESIRED] = 1
    state[:, PICK] = -1
    state[:, DESTINATION] = -1
    state[:, TARGET] = -1
    heard = np.full((listeners, robots, BEACON), -1, dtype=np.int64)
    return Minds(
        state=state,
        reading=np.zeros((robots, 4)),
        sending=np.ones(robots, dtype=np.bool_),
        heard_state=heard,
        heard_reading=np.zeros((listeners, robots, 4)),
        still=np.zeros((listeners, robots), dtype=np.int64),
        avoided=np.full((robots, 32, 2), -1, dtype=np.int64),
        avoided_next=np.zeros(robots, dtype=np.int64),
    )
