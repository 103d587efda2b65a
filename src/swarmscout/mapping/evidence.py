"""Each robot's log of its own evidence.

Increments are merged per scan and cell: one log entry says how much one scan changes one cell.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

__all__ = ["EvidenceLog"]


class EvidenceLog:
    """Append-only logs of evidence; row k belongs to robot k.

    Attributes:
        cells: int64[N, capacity], flat cells.
        increments: int64[N, capacity], in 1/1000 nat.
        length: int64[N], how many entries of each row are written.
        dropped: int64[N], how many entries of each log are no longer kept; they came before.
        reach: how many cells from a robot's own one a scan or a contact can say anything.
        per_scan: most entries that a scan can add.
    """

    def __init__(self, robots: int, rays: int, reach_m: float, cell_m: float) -> None:
        """Empty logs.

        Args:
            robots: N.
            rays: rays of a scan; a cone counts as the rays that it is made of.
            reach_m: how far from a robot's centre a scan or a contact can say anything.
            cell_m: edge of a map cell.
        """
        self.reach = math.ceil(reach_m / cell_m) + 1
        # A ray passes at most 2 · reach + 1 cells; a contact adds one.
        self.per_scan = min((2 * self.reach + 1) ** 2, rays * (2 * self.reach + 2) + 1)
        self.cells: NDArray[np.int64] = np.zeros((robots, self.per_scan), dtype=np.int64)
        self.increments: NDArray[np.int64] = np.zeros((robots, self.per_scan), dtype=np.int64)
        self.length: NDArray[np.int64] = np.zeros(robots, dtype=np.int64)
        self.dropped: NDArray[np.int64] = np.zeros(robots, dtype=np.int64)

    def end(self) -> NDArray[np.int64]:
        """int64[N], how many entries each robot has ever written."""
        end: NDArray[np.int64] = self.dropped + self.length
        return end

    def allow_writing(self, allowed: bool) -> None:
        """Whether entries may be written; between steps they may not, see ``HandCheck``."""
        self.cells.flags.writeable = self.increments.flags.writeable = allowed

    def make_room(self, oldest: NDArray[np.int64]) -> None:
        """Before a scan: drop what all robots have, and make room for one more scan of each.

        Args:
            oldest: int64[N], how many entries of each log (see :meth:`end`) every robot has.
        """
        if (oldest == self.end()).all():
            self.dropped[:] = oldest
            self.length[:] = 0
        elif int(self.length.max()) + self.per_scan > self.cells.shape[1]:
            keep = self.end() - oldest
            room = 2 * max(int(keep.max()), self.per_scan)
            cells, increments = (np.zeros((len(keep), room), dtype=np.int64) for _ in range(2))
            for robot, (count, length) in enumerate(zip(keep, self.length, strict=True)):
                cells[robot, :count] = self.cells[robot, length - count : length]
                increments[robot, :count] = self.increments[robot, length - count : length]
            self.cells, self.increments = cells, increments
            self.dropped, self.length = oldest.copy(), keep

    def entries_from(self, since: NDArray[np.int64]) -> NDArray[np.int64]:
        """int64[m, 3]: rows (robot, cell, increment) of what each log gained, by robot.

        Args:
            since: int64[N], the first entry of each that is new.
        """
        counts = self.length - since
        robot = np.repeat(np.arange(len(counts)), counts)
        # The n-th new entry of a robot stands n places behind its first one.
        at = np.arange(len(robot)) - np.repeat(np.cumsum(counts) - counts, counts) + since[robot]
        return np.column_stack((robot, self.cells[robot, at], self.increments[robot, at]))
