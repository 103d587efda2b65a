"""The view of a policy for the desired team size: what each robot knows, in arrays.

One view serves all robots, because a call for each would cost more than a step. Row i of each array
belongs to robot i and holds what i knows of itself, from its own map, and from what it heard.
"""

from __future__ import annotations

import math
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from swarmscout.core.enums import CHARGE
from swarmscout.core.jit import kernel
from swarmscout.mapping.occupancy import FRONTIER, OccupancyGrids
from swarmscout.minds.minds import DESIRED, LEADER, MODE, SIZE, STEP, TEAM, Minds

__all__ = ["RobotsView"]

_Around = tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.float64]]
T = TypeVar("T", bound=np.generic)


@kernel
def look_around(  # type: ignore[no-untyped-def]
    reading, heard_state, heard_reading, step, reach_m, counts, nearest_m
):
    """Count the other robots near each robot, as heard in this step.

    Args:
        reading: float64[N, 4], each robot's own; heard_state: int64[K, N, BEACON];
            heard_reading: float64[K, N, 4], see ``Minds``.
        step: the current step; reach_m: distance within which robots count.
        counts: int64[N, 2], written: other robots within reach, and those of other teams.
        nearest_m: float64[N], written: distance to the nearest robot of another team; inf: none.
    """
    for i in range(reading.shape[0]):
        k = i if heard_state.shape[0] > 1 else 0
        counts[i, 0] = 0
        counts[i, 1] = 0
        nearest2 = np.inf
        for j in range(reading.shape[0]):
            if j == i or heard_state[k, j, STEP] != step:
                continue
            dx = heard_reading[k, j, 0] - reading[i, 0]
            dy = heard_reading[k, j, 1] - reading[i, 1]
            distance2 = dx * dx + dy * dy
            # The own beacon of this step is in the table, too.
            stranger = heard_state[k, j, TEAM] != heard_state[k, i, TEAM]
            if stranger:
                nearest2 = min(nearest2, distance2)
            if distance2 <= reach_m * reach_m:
                counts[i, 0] += 1
                counts[i, 1] += stranger
        nearest_m[i] = nearest2**0.5


@kernel
def count_near_frontiers(  # type: ignore[no-untyped-def]
    reading, status, origin_x_m, origin_y_m, cell_m, rows, columns, reach_m, counts
):
    """Count the frontier cells of each robot's own map within reach of it.

    Args:
        reading: float64[N, 4]; status: uint8[K, C'], see ``OccupancyGrids``.
        origin_x_m, origin_y_m, cell_m, rows, columns: the grid's frame.
        reach_m: from the robot to a cell's centre.
        counts: int64[N], written.
    """
    for i in range(reading.shape[0]):
        m = i if status.shape[0] > 1 else 0
        # In cells, from the centre of cell (0, 0).
        x = (reading[i, 0] - origin_x_m) / cell_m - 0.5
        y = (reading[i, 1] - origin_y_m) / cell_m - 0.5
        reach = reach_m / cell_m
        n = 0
        for row in range(max(0, math.ceil(y - reach)), min(rows - 1, math.floor(y + reach)) + 1):
            half = math.sqrt(max(0.0, reach * reach - (row - y) * (row - y)))
            first = max(0, math.ceil(x - half))
            last = min(columns - 1, math.floor(x + half))
            for col in range(first, last + 1):
                n += status[m, row * columns + col] & FRONTIER != 0
        counts[i] = n


class RobotsView:
    """What N robots know, each for itself; row i of each array belongs to robot i.

    All arrays are read-only. Element i of an answer may depend on row i alone, and row i holds what
    robot i knows of itself, from its own map, and from the beacons that it heard.

    Args:
        minds: what robots believe. grids: their maps.
        step: the current step.
        desired_size: the scenario's ``teams.desired_size``.
    """

    __slots__ = ("_desired_size", "_found", "_grids", "_minds", "_step")

    def __init__(self, minds: Minds, grids: OccupancyGrids, step: int, desired_size: int) -> None:
        self._minds = minds
        self._grids = grids
        self._step = step
        self._desired_size = desired_size
        self._found: dict[Any, Any] = {}

    def __len__(self) -> int:
        """N, the number of robots."""
        return len(self._minds.state)

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
        return _frozen(self._minds.state[:, MODE] != CHARGE)

    @property
    def charge(self) -> NDArray[np.float64]:
        """float64[N], own charge as a share of the capacity."""
        return _frozen(self._minds.reading[:, 3])

    @property
    def position_m(self) -> NDArray[np.float64]:
        """float64[N, 2], the believed position."""
        return _frozen(self._minds.reading[:, :2])

    @property
    def leads(self) -> NDArray[np.bool_]:
        """bool[N], whether the robot leads its team; a single robot does."""
        return _frozen(self._minds.state[:, LEADER] == np.arange(len(self)))

    @property
    def team_size(self) -> NDArray[np.int64]:
        """int64[N], number of members of the own team, as known in the last step."""
        return _frozen(self._minds.state[:, SIZE])

    @property
    def previous(self) -> NDArray[np.int64]:
        """int64[N], the previous desired size: the last answer for the robot."""
        return _frozen(self._minds.state[:, DESIRED])

    @property
    def frontiers(self) -> NDArray[np.int64]:
        """int64[N], number of frontier cells in the own map."""
        maps = range(len(self._grids.counts))
        counts = np.array([self._grids.frontier_count(m) for m in maps])
        return _frozen(counts if len(counts) == len(self) else np.repeat(counts, len(self)))

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
            frame = self._grids.frame
            count_near_frontiers(
                self._minds.reading, self._grids.status, frame.origin_x_m, frame.origin_y_m,
                frame.cell_m, frame.rows, frame.columns, float(reach_m), counts,
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
        """int64[N], number of exploring teams as last heard from leaders, the own one included."""
        if "teams" not in self._found:
            heard = self._minds.heard_state
            leads = heard[:, :, LEADER] == np.arange(len(self))
            leads &= (heard[:, :, STEP] >= 0) & (heard[:, :, MODE] != CHARGE)
            counts = np.count_nonzero(leads, axis=1).astype(np.int64)
            if len(counts) != len(self):
                counts = np.repeat(counts, len(self))
            self._found["teams"] = _frozen(counts)
        return self._found["teams"]  # type: ignore[no-any-return]

    def _around(self, reach_m: float) -> _Around:
        key = "around", reach_m
        if key not in self._found:
            minds = self._minds
            counts = np.empty((len(self), 2), dtype=np.int64)
            nearest_m = np.empty(len(self))
            look_around(
                minds.reading, minds.heard_state, minds.heard_reading, self._step, float(reach_m),
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
