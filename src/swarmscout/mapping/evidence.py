"""Scans become evidence: the inverse sensor model, and each robot's log of what it has seen.

Increments are summed per ray and merged per scan and cell: one log entry says how much one scan
changes one cell.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from swarmscout.core.enums import WALL_CONTACT
from swarmscout.core.grid import GridFrame
from swarmscout.core.jit import kernel

__all__ = ["EvidenceLog", "observe", "scan_evidence"]


class EvidenceLog:
    """Append-only logs of evidence; row k belongs to robot k.

    Attributes:
        cells: int64[N, capacity], flat cells.
        increments: int64[N, capacity], in 1/1000 nat.
        length: int64[N], how many entries of each row are written.
        dropped: int64[N], how many entries of each log are no longer kept; they came before.
        window: int64[w, w], scratch for one scan.
    """

    def __init__(self, robots: int, rays: int, reach_m: float, cell_m: float) -> None:
        """Empty logs.

        Args:
            robots: N.
            rays: rays of a scan.
            reach_m: how far from a robot's centre a scan or a contact can say anything.
            cell_m: edge of a map cell.
        """
        reach = math.ceil(reach_m / cell_m) + 1
        self.window: NDArray[np.int64] = np.zeros((2 * reach + 1, 2 * reach + 1), dtype=np.int64)
        # A ray passes at most 2 · reach + 1 cells; a contact adds one.
        self.per_scan = min(self.window.size, rays * (2 * reach + 2) + 1)
        self.cells: NDArray[np.int64] = np.zeros((robots, self.per_scan), dtype=np.int64)
        self.increments: NDArray[np.int64] = np.zeros((robots, self.per_scan), dtype=np.int64)
        self.length: NDArray[np.int64] = np.zeros(robots, dtype=np.int64)
        self.dropped: NDArray[np.int64] = np.zeros(robots, dtype=np.int64)

    def end(self) -> NDArray[np.int64]:
        """int64[N], how many entries each robot has ever written."""
        end: NDArray[np.int64] = self.dropped + self.length
        return end

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


@kernel
def scan_evidence(  # type: ignore[no-untyped-def]
    own, can, ranges, offsets, table, range_m, touch,
    ox, oy, cell_m, rows, columns, free, occupied, depth_m, window, cells, increments, length,
):  # fmt: skip
    """Append each robot's scan, seen from where it believes to be, to its own log.

    Args:
        own: MIND[N]; can: CAPABILITIES[N].
        ranges: float64[N, rays] measured ranges, inf where nothing was met.
        offsets: int64[rays]; table: float64[3600, 2] (cos, sin); range_m: longest range.
        touch: TOUCH[N]: a wall that was touched in the last step, seen from the robot's centre.
        ox, oy, cell_m, rows, columns: the occupancy grid's frame.
        free, occupied: increments; depth_m: how far behind its surface an obstacle lies.
        window: int64[w, w], scratch: the scan's sum per cell round the robot; all 0 between calls.
        cells, increments: int64[N, capacity]; length: int64[N]: the logs.
    """
    ticks = table.shape[0]
    edge = window.shape[0]
    for i in range(own.shape[0]):
        if not (own[i].thinks and can[i].sense):
            continue
        x = (own[i].x_m - ox) / cell_m
        y = (own[i].y_m - oy) / cell_m
        left = int(math.floor(x)) - edge // 2
        low = int(math.floor(y)) - edge // 2
        for r in range(offsets.shape[0]):
            tick = (own[i].heading + offsets[r]) % ticks
            dx = table[tick, 0]
            dy = table[tick, 1]
            met = ranges[i, r] <= range_m
            longest = min(ranges[i, r], range_m) / cell_m
            hit_row = -1
            hit_col = -1
            if met:
                hit_row = int(math.floor(y + dy * (longest + depth_m / cell_m)))
                hit_col = int(math.floor(x + dx * (longest + depth_m / cell_m)))
                window[hit_row - low, hit_col - left] += occupied
            # Every cell on the way is free, but for the one in which the ray ended.
            col = int(math.floor(x))
            row = int(math.floor(y))
            step_col = 1 if dx > 0.0 else -1
            step_row = 1 if dy > 0.0 else -1
            per_col = abs(1.0 / dx) if dx != 0.0 else np.inf
            per_row = abs(1.0 / dy) if dy != 0.0 else np.inf
            next_col = ((col + 1 - x) if dx > 0.0 else (x - col)) * per_col if dx != 0.0 else np.inf
            next_row = ((row + 1 - y) if dy > 0.0 else (y - row)) * per_row if dy != 0.0 else np.inf
            while True:
                if not met or row != hit_row or col != hit_col:
                    window[row - low, col - left] += free
                distance = min(next_col, next_row)
                if distance > longest:
                    break
                if next_col < next_row:
                    next_col += per_col
                    col += step_col
                else:
                    next_row += per_row
                    row += step_row
        if touch[i].kind == WALL_CONTACT:
            # Deviation: a bump is a measurement too; the paper does not speak of contacts.
            row = int(math.floor(y + touch[i].dy_m / cell_m))
            col = int(math.floor(x + touch[i].dx_m / cell_m))
            window[row - low, col - left] += occupied
        end = length[i]
        for row in range(edge):
            for col in range(edge):
                increment = window[row, col]
                if increment == 0:
                    continue
                window[row, col] = 0
                if 0 <= row + low < rows and 0 <= col + left < columns:
                    cells[i, end] = (row + low) * columns + col + left
                    increments[i, end] = increment
                    end += 1
        length[i] = end


def observe(
    log: EvidenceLog,
    own: NDArray[np.void],
    can: NDArray[np.void],
    ranges: NDArray[np.float64],
    offsets: NDArray[np.int64],
    table: NDArray[np.float64],
    range_m: float,
    touch: NDArray[np.void],
    frame: GridFrame,
    increments: tuple[int, int],
    hit_depth_m: float,
) -> None:
    """Phase 2 of a step: every robot logs what its scan says; see :func:`scan_evidence`.

    Call :meth:`EvidenceLog.make_room` before.

    Args:
        increments: for a passed cell (< 0) and for the cell in which a ray ended (> 0).
    """
    scan_evidence(
        own, can, ranges, offsets, table, range_m, touch,
        frame.origin_x_m, frame.origin_y_m, frame.cell_m, frame.rows, frame.columns,
        increments[0], increments[1], hit_depth_m, log.window,
        log.cells, log.increments, log.length,
    )  # fmt: skip
