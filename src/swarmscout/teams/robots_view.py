"""The view of a policy for the desired team size: what each robot knows, in arrays.

One view serves all robots, because a call for each would cost more than a step. Row i of each array
belongs to robot i and holds what i knows of itself, from its own map, and from what it heard.
"""

from __future__ import annotations

import math
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from swarmscout.comms.knowledge import Knowledge
from swarmscout.core.jit import kernel
from swarmscout.mapping.occupancy import FRONTIER, FRONTIERS
from swarmscout.minds.minds import Minds
from swarmscout.minds.modes import on_task

__all__ = ["RobotsView"]

_Around = tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.float64]]
T = TypeVar("T", bound=np.generic)


@kernel
def look_around(own, ear, heard, step, reach_m, counts, nearest_m):  # type: ignore[no-untyped-def]
    """Count the other robots near each robot, as heard in this step.

    Args:
        own: MIND[N]; ear: int64[N] and heard: BEACON[R, N], see ``Knowledge``.
        step: the current step; reach_m: distance within which robots count.
        counts: int64[N, 2], written: other robots within reach, and those of other teams.
        nearest_m: float64[N], written: distance to the nearest robot of another team; inf: none.
    """
    for i in range(own.shape[0]):
        row = heard[ear[i]]
        counts[i, 0] = 0
        counts[i, 1] = 0
        nearest2 = np.inf
        for j in range(row.shape[0]):
            if j == i or row[j].step != step:
                continue
            dx = row[j].x_m - own[i].x_m
            dy = row[j].y_m - own[i].y_m
            distance2 = dx * dx + dy * dy
            # The own beacon of this step is in the table, too.
            stranger = row[j].team != row[i].team
            if stranger:
                nearest2 = min(nearest2, distance2)
            if distance2 <= reach_m * reach_m:
                counts[i, 0] += 1
                counts[i, 1] += stranger
        nearest_m[i] = nearest2**0.5


@kernel
def count_near_frontiers(own, ear, status, grid, reach_m, counts):  # type: ignore[no-untyped-def]
    """Count the frontier cells of each robot's own map within reach of it.

    Args:
        own: MIND[N]; ear: int64[N], see ``Knowledge``.
        status: uint8[R, C'], see ``OccupancyGrids``.
        grid: GRID[1], the grid's frame.
        reach_m: from the robot to a cell's centre.
        counts: int64[N], written.
    """
    grid = grid[0]
    for i in range(own.shape[0]):
        m = ear[i]
        # In cells, from the centre of cell (0, 0).
        x = (own[i].x_m - grid.origin_x_m) / grid.cell_m - 0.5
        y = (own[i].y_m - grid.origin_y_m) / grid.cell_m - 0.5
        reach = reach_m / grid.cell_m
        n = 0
        for row in range(
            max(0, math.ceil(y - reach)), min(grid.rows - 1, math.floor(y + reach)) + 1
        ):
            half = math.sqrt(max(0.0, reach * reach - (row - y) * (row - y)))
            first = max(0, math.ceil(x - half))
            last = min(grid.columns - 1, math.floor(x + half))
            for col in range(first, last + 1):
                n += status[m, row * grid.columns + col] & FRONTIER != 0
        counts[i] = n


class RobotsView:
    """What N robots know, each for itself; row i of each array belongs to robot i.

    All arrays are read-only. Element i of an answer may depend on row i alone, and row i holds what
    robot i knows of itself, from its own map, and from the beacons that it heard.

    Args:
        minds: what robots believe. knowledge: what they have heard, and their maps.
        step: the current step.
        desired_size, silence_steps: the scenario's, of its section ``teams``.
    """

    __slots__ = ("_desired_size", "_found", "_knowledge", "_minds", "_silence_steps", "_step")

    def __init__(
        self, minds: Minds, knowledge: Knowledge, step: int, desired_size: int, silence_steps: int
    ) -> None:
        self._minds = minds
        self._knowledge = knowledge
        self._step = step
        self._desired_size = desired_size
        self._silence_steps = silence_steps
        self._found: dict[Any, Any] = {}

    def __len__(self) -> int:
        """N, the number of robots."""
        return len(self._minds)

    @property
    def step(self) -> int:
        """The current step."""
        return self._step

    @property
    def desired_size(self) -> int:
        """The scenario's ``teams.desired_size``."""
        return self._desired_size

    @property
    def robot(self) -> NDArray[np.int64]:
        """int64[N], the robots' own numbers."""
        return _frozen(np.arange(len(self)))

    @property
    def exploring(self) -> NDArray[np.bool_]:
        """bool[N], whether the robot is in EXP mode; otherwise it charges or is on the way to."""
        return _frozen(on_task(self._minds.mode))

    @property
    def charge(self) -> NDArray[np.float64]:
        """float64[N], own charge as a share of the capacity."""
        return _frozen(self._minds.own["charge"])

    @property
    def position_m(self) -> NDArray[np.float64]:
        """float64[N, 2], the believed position."""
        return _frozen(self._minds.position_m)

    @property
    def leads(self) -> NDArray[np.bool_]:
        """bool[N], whether the robot leads its team; a single robot does."""
        return _frozen(self._minds.leader == np.arange(len(self)))

    @property
    def team_size(self) -> NDArray[np.int64]:
        """int64[N], number of members of the own team, as known in the last step."""
        return _frozen(self._minds.own["size"])

    @property
    def previous(self) -> NDArray[np.int64]:
        """int64[N], the previous desired size: the last answer for the robot."""
        return _frozen(self._minds.desired)

    @property
    def frontiers(self) -> NDArray[np.int64]:
        """int64[N], number of frontier cells in the own map."""
        return _frozen(self._knowledge.grids.counts[self._knowledge.ear, FRONTIERS])

    def frontiers_within(self, reach_m: float) -> NDArray[np.int64]:
        """Number of frontier cells of the own map near the robot, visible or not.

        Args:
            reach_m: from the robot to a cell's centre.

        Returns:
            int64[N].
        """
        key = "frontiers", reach_m
        if key not in self._found:
            counts = np.empty(len(self), dtype=np.int64)
            knowledge = self._knowledge
            count_near_frontiers(
                self._minds.own, knowledge.ear, knowledge.grids.status,
                knowledge.grids.frame.record, float(reach_m), counts,
            )  # fmt: skip
            self._found[key] = _frozen(counts)
        return self._found[key]  # type: ignore[no-any-return]

    def robots_within(self, reach_m: float) -> NDArray[np.int64]:
        """Number of other robots near the robot, own team included, as heard in this step.

        Args:
            reach_m: in a straight line.

        Returns:
            int64[N].
        """
        return self._around(reach_m)[0]

    def strangers_within(self, reach_m: float) -> NDArray[np.int64]:
        """Number of robots of other teams near the robot, as heard in this step.

        Args:
            reach_m: in a straight line.

        Returns:
            int64[N].
        """
        return self._around(reach_m)[1]

    @property
    def nearest_stranger_m(self) -> NDArray[np.float64]:
        """float64[N], distance to the nearest robot of another team; inf where none was heard."""
        known = next((key for key in self._found if key[0] == "around"), None)
        return self._around(0.0 if known is None else known[1])[2]

    @property
    def teams(self) -> NDArray[np.int64]:
        """int64[N], number of exploring teams whose leaders were heard lately, the own one too."""
        if "teams" not in self._found:
            heard = self._knowledge.heard
            leads = heard["leader"] == np.arange(len(self))
            leads &= (heard["step"] >= 0) & on_task(heard["mode"])
            leads &= heard["step"] >= self._step - self._silence_steps
            counts = np.count_nonzero(leads, axis=1).astype(np.int64)
            self._found["teams"] = _frozen(counts[self._knowledge.ear])
        return self._found["teams"]  # type: ignore[no-any-return]

    def _around(self, reach_m: float) -> _Around:
        key = "around", reach_m
        if key not in self._found:
            knowledge = self._knowledge
            counts = np.empty((len(self), 2), dtype=np.int64)
            nearest_m = np.empty(len(self))
            look_around(
                self._minds.own, knowledge.ear, knowledge.heard, self._step, float(reach_m),
                counts, nearest_m,
            )  # fmt: skip
            found = _frozen(counts[:, 0]), _frozen(counts[:, 1]), _frozen(nearest_m)
            self._found[key] = found
        return self._found[key]  # type: ignore[no-any-return]


def _frozen(array: NDArray[T]) -> NDArray[T]:
    """A read-only view of an array, which stays writable for its owner."""
    look = array.view()
    look.flags.writeable = False
    return look
