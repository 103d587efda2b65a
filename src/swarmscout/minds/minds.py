"""All robots' minds as arrays of records; record i belongs to robot i.

A rule for robot i reads its own record and the messages it has heard
(:mod:`swarmscout.comms`), and nothing else.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from swarmscout.core.enums import EXPLORE
from swarmscout.minds.given_up import nothing_given_up

__all__ = ["MIND", "Minds", "blank_minds"]

MIND = np.dtype(
    [
        ("x_m", "f8"),  # believed position
        ("y_m", "f8"),
        ("charge", "f8"),  # as a share of the capacity
        ("heading", "i8"),  # believed, in ticks of 0.1°
        ("team", "i8"),  # the team's id
        ("leader", "i8"),  # the robot that leads it
        ("mode", "i8"),  # EXPLORE or CHARGE
        ("size", "i8"),  # members of the team, as the robot knows
        ("desired", "i8"),  # desired team size
        ("partner", "i8"),  # a leader's choice for joining: a robot of another team, or -1
        ("destination", "i8"),  # the team's destination: flat cell of the map, or -1
        ("target", "i8"),  # the cell that the robot itself drives to, or -1
        ("aim", "i8"),  # the heading in which it means to drive, in ticks; -1: it stands
        ("still", "i8"),  # for how many steps it has stayed about where it is
        ("cause", "i8"),  # why its team needs a destination, a code of CAUSES
        ("due_at", "i8"),  # the step after which the destination is overdue
        ("station", "i8"),  # in CHARGE mode, the station that it has chosen, or -1
        ("place", "i8"),  # its place there: a flat cell, NO_PLACE or WAITS
        ("way_m", "f8"),  # no more than this far from a station, along a way that it knows
        ("look_at", "i8"),  # without a destination: the step in which to look for one again
        ("thinks", "?"),  # False: it decides nothing
        ("sends", "?"),  # False: no other robot hears it
        ("hears", "?"),  # False: it hears no other robot
        ("doubts", "?"),  # some candidate has no route: it looks whether others have
        ("hopeless", "?"),  # when it last looked, no candidate was left that a route reaches
        ("unused", "u1", (3,)),  # no padding, whose bytes copies do not keep
    ],
    align=True,
)
"""What one robot believes and has decided."""


@dataclass(slots=True)
class Minds:
    """What N robots believe.

    Attributes:
        own: MIND[N].
        avoided: int64[N, 32, 2], cells that the robot's team gave up, and until which step.
        avoided_next: int64[N], the place in `avoided` to be written next.
        given_up: GIVEN_UP[N, 256], see :mod:`swarmscout.minds.given_up`.
    """

    own: NDArray[np.void]
    avoided: NDArray[np.int64]
    avoided_next: NDArray[np.int64]
    given_up: NDArray[np.void]

    def __len__(self) -> int:
        """N."""
        return len(self.own)

    @property
    def position_m(self) -> NDArray[np.float64]:
        """float64[N, 2], where robots believe to be (a copy)."""
        return np.column_stack((self.own["x_m"], self.own["y_m"]))

    @property
    def team(self) -> NDArray[np.int64]:
        """int64[N], team ids."""
        return self.own["team"]

    @property
    def leader(self) -> NDArray[np.int64]:
        """int64[N], each robot's leader."""
        return self.own["leader"]

    @property
    def mode(self) -> NDArray[np.int64]:
        """int64[N], EXPLORE or CHARGE."""
        return self.own["mode"]

    @property
    def desired(self) -> NDArray[np.int64]:
        """int64[N], desired team sizes."""
        return self.own["desired"]

    @property
    def destination(self) -> NDArray[np.int64]:
        """int64[N], flat cells or -1."""
        return self.own["destination"]

    @property
    def target(self) -> NDArray[np.int64]:
        """int64[N], flat cells that robots drive to themselves, or -1."""
        return self.own["target"]

    @property
    def thinking(self) -> NDArray[np.bool_]:
        """bool[N], False for a robot that decides nothing."""
        return self.own["thinks"]


def blank_minds(robots: int) -> Minds:
    """N robots that are alone and explore.

    Args:
        robots: N.
    """
    own = np.zeros(robots, dtype=MIND)
    own["team"] = own["leader"] = np.arange(robots)
    own["mode"] = EXPLORE
    own["size"] = own["desired"] = 1
    own["partner"] = own["destination"] = own["target"] = own["aim"] = -1
    own["station"] = own["place"] = -1
    own["way_m"] = np.inf
    own["thinks"] = own["sends"] = own["hears"] = True
    return Minds(
        own=own,
        avoided=np.full((robots, 32, 2), -1, dtype=np.int64),
        avoided_next=np.zeros(robots, dtype=np.int64),
        given_up=nothing_given_up(robots),
    )
