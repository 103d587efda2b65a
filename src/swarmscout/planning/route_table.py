"""All robots' routes as a structure of arrays; row i belongs to robot i."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

__all__ = ["NOWHERE", "STATION", "RouteTable", "blank_routes"]

# Columns of a robot's route state.
GOAL = 0  # flat cell, STATION or NOWHERE: where the route leads
LENGTH = 1  # cells on it
AT = 2  # the next one to drive to
NEED = 3  # 1: a route has to be planned in this step
WANTED = 4  # where the robot wants to go now
FAILED_UNTIL = 5  # there was no route: do not try again before this step
STUCK = 6  # forward moves that failed since the last few that did not
CLEAR = 7  # forward moves made since the last contact
AHEAD = 8  # moves forward to be made after a turn aside
ROUTE_COLUMNS = 9

NOWHERE = -1
STATION = -2
"""As a goal: whichever charging station is nearest by route."""

LONGEST = 256
"""A route keeps so many cells at most; what lies behind is planned when they are used up."""


@dataclass(slots=True)
class RouteTable:
    """Where N robots are going.

    Attributes:
        state: int64[N, 9], columns above.
        cells: int32[N, 256], flat cells from the one after the start to the goal.
        cost: int64[N], cost of the whole route when it was planned, in the units of
            :class:`swarmscout.planning.costs.RouteCosts`; -1: there is none.
    """

    state: NDArray[np.int64]
    cells: NDArray[np.int32]
    cost: NDArray[np.int64]

    def ahead(self, robot: int) -> NDArray[np.int32]:
        """int32[n]: the flat cells that a robot still has to drive through."""
        at, length = self.state[robot, AT], self.state[robot, LENGTH]
        return self.cells[robot, at : min(length, LONGEST)]


def blank_routes(robots: int) -> RouteTable:
    """N robots that go nowhere."""
    state = np.zeros((robots, ROUTE_COLUMNS), dtype=np.int64)
    state[:, GOAL] = NOWHERE
    state[:, WANTED] = NOWHERE
    return RouteTable(
        state=state,
        cells=np.zeros((robots, LONGEST), dtype=np.int32),
        cost=np.full(robots, -1, dtype=np.int64),
    )
