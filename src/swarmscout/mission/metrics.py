"""Judging: what a mission has achieved, measured against the truth. No mind reads this.

*Explored* is defined once, here: the area that is truly free and reachable inside those cells of
the occupancy grid that the swarm's map has ever called free. It never decreases and never exceeds
what is reachable. *Reachable* is what a robot's body can cover when it starts at the world's start.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from swarmscout.core.enums import (
    CHARGE,
    FORWARD,
    FREE,
    JOIN,
    LEAVE,
    LEFT,
    NO_CONTACT,
    OCCUPIED,
    RIGHT,
)
from swarmscout.core.enums import CONTACT as CONTACT_EVENT
from swarmscout.core.enums import MODE as MODE_EVENT
from swarmscout.core.grid import GridFrame
from swarmscout.core.jit import kernel
from swarmscout.mapping.evidence import EvidenceLog
from swarmscout.mapping.occupancy import LABEL_BITS, OccupancyGrids
from swarmscout.minds.minds import LEADER, MODE, Minds
from swarmscout.robots.bodies import Bodies
from swarmscout.worlds.reachability import reachable
from swarmscout.worlds.world import World

__all__ = ["Judge", "MapTruth", "judge_step", "map_truth"]

# Columns of a judge's tally.
EXPLORED = 0  # raster cells
SEEN = 1  # map cells that any robot's sensor has covered
OVERLAP = 2  # those that more than one robot's has
FORWARD_MOVES = 3
TURNS = 4
BLOCKED = 5
ALIVE_STEPS = 6
TEAMS = 7  # teams now
CHARGING = 8  # robots in CHR mode now
MOVING = 9  # robots that are not stranded now
JOINS = 10
LEAVES = 11
CHARGES = 12  # robots that left CHR mode
TALLY = 13


@dataclass(frozen=True)
class MapTruth:
    """The truth behind each cell of the occupancy grid.

    Attributes:
        reachable: int64[C], raster cells that are free and reachable, by their centre.
        free: int64[C], raster cells that are free.
        total: int64[C], raster cells.
        raster_cell_m2: area of one raster cell.
    """

    reachable: NDArray[np.int64]
    free: NDArray[np.int64]
    total: NDArray[np.int64]
    raster_cell_m2: float

    @property
    def reachable_m2(self) -> float:
        """Area that a robot can cover at all."""
        return float(self.reachable.sum()) * self.raster_cell_m2


@kernel
def _count_raster(free, reach, map_row, map_col, columns, counts):  # type: ignore[no-untyped-def]
    for row in range(free.shape[0]):
        for col in range(free.shape[1]):
            cell = map_row[row] * columns + map_col[col]
            counts[0, cell] += reach[row, col] != 0
            counts[1, cell] += free[row, col] != 0
            counts[2, cell] += 1


def map_truth(world: World, frame: GridFrame, radius_m: float) -> MapTruth:
    """Count what lies in each cell of the occupancy grid.

    Args:
        world: the truth.
        frame: the occupancy grid's.
        radius_m: a robot's radius.
    """
    raster = world.frame
    centre_y = raster.origin_y_m + (np.arange(raster.rows) + 0.5) * raster.cell_m
    centre_x = raster.origin_x_m + (np.arange(raster.columns) + 0.5) * raster.cell_m
    map_row = np.floor((centre_y - frame.origin_y_m) / frame.cell_m).astype(np.int64)
    map_col = np.floor((centre_x - frame.origin_x_m) / frame.cell_m).astype(np.int64)
    counts = np.zeros((3, frame.size), dtype=np.int64)
    reach = np.ascontiguousarray(reachable(world, radius_m), dtype=np.uint8)
    _count_raster(world.free, reach, map_row, map_col, frame.columns, counts)
    return MapTruth(counts[0], counts[1], counts[2], raster.cell_m**2)


@kernel
def judge_step(  # type: ignore[no-untyped-def]
    cells, low, high, first_seen, touched, before, n_touched, evidence, status, ever_free,
    reachable_cells, lowest, highest, action, contact, touched_robot, acting, sending, state,
    tally, change_cells, change_log_odds, events, count,
):  # fmt: skip
    """Count one step.

    Args:
        cells: int64[N, capacity]; low, high: int64[N]: this step's entries of each robot's log.
        first_seen: int64[C], -1: nobody; -2: more than one; else who saw a cell.
        touched: int64[C] and before: int64[C]: of the swarm's map, the first n_touched count.
        evidence: int64[C], status: uint8[C']: the swarm's map.
        ever_free: bool[C]; reachable_cells: int64[C].
        lowest, highest: saturation of log-odds when read.
        action, contact, touched_robot: int64[N]; acting: bool[N], alive when it acted;
            sending: bool[N]; state: int64[N, columns].
        tally: int64[TALLY], written.
        change_cells, change_log_odds: int64[C], written: what changed as read.
        events, count: see ``core.codes``; contacts are appended.

    Returns:
        How many cells changed as read.
    """
    for e in range(count[0]):
        kind = events[e, 0]
        if kind == LEAVE:
            tally[LEAVES] += 1
        elif kind == MODE_EVENT:
            tally[CHARGES] += events[e, 2] != CHARGE
        elif kind == JOIN:
            # Every member has an event; the new team is one.
            new = 1
            for earlier in range(e):
                if events[earlier, 0] == JOIN and events[earlier, 3] == events[e, 3]:
                    new = 0
                    break
            tally[JOINS] += new
    for k in range(cells.shape[0]):
        for e in range(low[k], high[k]):
            cell = cells[k, e]
            if first_seen[cell] == -1:
                first_seen[cell] = k
                tally[SEEN] += 1
            elif first_seen[cell] >= 0 and first_seen[cell] != k:
                first_seen[cell] = -2
                tally[OVERLAP] += 1
    changes = 0
    for t in range(n_touched):
        cell = touched[t]
        now = min(highest, max(lowest, evidence[cell]))
        if now != min(highest, max(lowest, before[t])):
            change_cells[changes] = cell
            change_log_odds[changes] = now
            changes += 1
        if status[cell] & LABEL_BITS == FREE and not ever_free[cell]:
            ever_free[cell] = True
            tally[EXPLORED] += reachable_cells[cell]
    tally[TEAMS] = 0
    tally[CHARGING] = 0
    tally[MOVING] = 0
    for i in range(state.shape[0]):
        if acting[i]:
            tally[ALIVE_STEPS] += 1
            if action[i] == LEFT or action[i] == RIGHT:
                tally[TURNS] += 1
            elif action[i] == FORWARD:
                if contact[i] == NO_CONTACT:
                    tally[FORWARD_MOVES] += 1
                else:
                    tally[BLOCKED] += 1
                    events[count[0], 0] = CONTACT_EVENT
                    events[count[0], 1] = i
                    events[count[0], 2] = contact[i]
                    events[count[0], 3] = touched_robot[i]
                    count[0] += 1
        if sending[i]:
            tally[MOVING] += 1
            tally[CHARGING] += state[i, MODE] == CHARGE
            tally[TEAMS] += state[i, LEADER] == i and state[i, MODE] != CHARGE
    return changes


class Judge:
    """Keeps count of what a mission achieves.

    Attributes:
        truth: what lies behind each cell of the map.
        area_m2: list of explored areas, one per step; [0] is before the first step.
    """

    def __init__(self, truth: MapTruth, robots: int, forward_m: float) -> None:
        size = len(truth.reachable)
        self.truth = truth
        self.area_m2: list[float] = [0.0]
        self.reachable_m2 = truth.reachable_m2
        self._forward_m = forward_m
        self._robots = robots
        self._first_seen = np.full(size, -1, dtype=np.int64)
        self._ever_free = np.zeros(size, dtype=np.bool_)
        self._tally = np.zeros(TALLY, dtype=np.int64)
        self._tally[MOVING] = robots
        self._change_cells = np.zeros(size, dtype=np.int64)
        self._change_log_odds = np.zeros(size, dtype=np.int64)

    def judge(
        self,
        bodies: Bodies,
        minds: Minds,
        action: NDArray[np.int64],
        acting: NDArray[np.bool_],
        log: EvidenceLog,
        since: NDArray[np.int64],
        swarm: OccupancyGrids,
        n_touched: int,
        events: NDArray[np.int64],
        count: NDArray[np.int64],
    ) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
        """Count one step.

        Returns:
            Flat cells of the swarm's map that changed as read, and their log-odds (views that the
            next step overwrites).
        """
        changes = judge_step(
            log.cells, since, log.length, self._first_seen, swarm.touched, swarm.before, n_touched,
            swarm.evidence[0], swarm.status[0], self._ever_free, self.truth.reachable,
            swarm.model.lowest, swarm.model.highest, action, bodies.contact, bodies.touched, acting,
            minds.sending, minds.state, self._tally, self._change_cells, self._change_log_odds,
            events, count,
        )  # fmt: skip
        self.area_m2.append(int(self._tally[EXPLORED]) * self.truth.raster_cell_m2)
        return self._change_cells[:changes], self._change_log_odds[:changes]

    @property
    def explored_m2(self) -> float:
        """Explored area."""
        return self.area_m2[-1]

    @property
    def moving(self) -> int:
        """Robots that are not stranded."""
        return int(self._tally[MOVING])

    def coverage(self, swarm: OccupancyGrids) -> dict[str, float | int]:
        """One row of the table ``coverage``."""
        counts = swarm.counts[0].tolist()
        tally = self._tally.tolist()
        return {
            "explored_m2": self.area_m2[-1],
            "explored_fraction": self.area_m2[-1] / self.reachable_m2,
            "known_cells": counts[1] + counts[2],
            "frontier_cells": counts[3],
            "teams": tally[TEAMS],
            "charging": tally[CHARGING],
            "stranded": self._robots - tally[MOVING],
        }

    def summary(self, minds: Minds, swarm: OccupancyGrids) -> dict[str, Any]:
        """The judged part of a mission's summary, see docs/recordings.md."""
        tally = self._tally
        area = np.array(self.area_m2)
        fraction = area / self.reachable_m2
        steps = len(area) - 1
        robot_steps = max(1, int(tally[ALIVE_STEPS]))
        leaders = minds.leader[minds.sending & (minds.mode != CHARGE)]
        sizes = np.unique(leaders, return_counts=True)[1]
        return {
            "explored_m2": float(area[-1]),
            "explored_fraction": float(fraction[-1]),
            "reachable_m2": self.reachable_m2,
            "area_at_step": {str(s): float(area[s]) for s in range(50, steps + 1, 50)},
            "time_to": {
                f"{share}%": _first(fraction >= share / 100 - 1e-12)
                for share in (50, 75, 90, 95, 99)
            },
            "overlap_ratio": float(tally[OVERLAP] / max(1, tally[SEEN])),
            "distance_m": float(tally[FORWARD_MOVES] * self._forward_m),
            "forward_share": float(tally[FORWARD_MOVES] / robot_steps),
            "turn_share": float(tally[TURNS] / robot_steps),
            "blocked_share": float(tally[BLOCKED] / robot_steps),
            "joins": int(tally[JOINS]),
            "leaves": int(tally[LEAVES]),
            "teams": sorted((int(size) for size in sizes), reverse=True),
            "charges": int(tally[CHARGES]),
            "stranded": self._robots - self.moving,
            **self._map_accuracy(swarm),
        }

    def _map_accuracy(self, swarm: OccupancyGrids) -> dict[str, float | None]:
        """Known cells that agree with the truth; cells of both kinds are counted apart."""
        truth = self.truth
        labels = swarm.status[0, : len(truth.free)] & LABEL_BITS
        all_free = (truth.free == truth.total) & (truth.total > 0)
        all_wall = truth.free == 0
        known = (labels == FREE) | (labels == OCCUPIED)
        pure = known & (all_free | all_wall)
        right = (all_free & (labels == FREE)) | (all_wall & (labels == OCCUPIED))
        n_known, n_pure = int(known.sum()), int(pure.sum())
        return {
            "map_accuracy": int((right & pure).sum()) / n_pure if n_pure else None,
            "map_mixed_share": (n_known - n_pure) / n_known if n_known else None,
        }


def _first(reached: NDArray[np.bool_]) -> int | None:
    return int(np.argmax(reached)) if reached.any() else None
