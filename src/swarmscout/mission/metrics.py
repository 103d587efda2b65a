"""Judging: what a mission has achieved, measured against the truth. No mind reads this.

*Explored* is defined once, here: the area that is truly free and reachable inside those cells of
the occupancy grid that the swarm's map has ever called free. It never decreases and never exceeds
what is reachable. *Reachable* is what a robot's body can cover when it starts at the world's start.
*Sensable* is the part of it in map cells at least half of which is free: what is mostly wall is
called occupied from wherever a robot looks.
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
    NO_CONTACT,
    OCCUPIED,
)
from swarmscout.core.enums import CONTACT as CONTACT_EVENT
from swarmscout.core.enums import MODE as MODE_EVENT
from swarmscout.core.events import EventLog, note
from swarmscout.core.grid import GridFrame
from swarmscout.core.jit import inlined, kernel
from swarmscout.mapping.evidence import EvidenceLog
from swarmscout.mapping.occupancy import (
    FRONTIERS,
    KNOWN_FREE,
    KNOWN_OCCUPIED,
    LABEL_BITS,
    OccupancyGrids,
)
from swarmscout.minds.minds import Minds
from swarmscout.robots.bodies import Bodies
from swarmscout.worlds.reachability import reachable
from swarmscout.worlds.world import World

__all__ = ["Judge", "MapTruth", "map_truth"]

TALLY = np.dtype(
    [
        ("explored", "i8"),  # raster cells
        ("sensed", "i8"),  # those of them that are sensable
        ("seen", "i8"),  # map cells that any robot's sensor has covered
        ("overlap", "i8"),  # those that more than one robot's has
        ("forward_moves", "i8"),
        ("turns", "i8"),
        ("blocked", "i8"),
        ("robot_steps", "i8"),  # of robots that could act
        ("teams", "i8"),  # teams now
        ("charging", "i8"),  # robots in CHR mode now
        ("mobile", "i8"),  # robots that can drive now
        ("alive", "i8"),  # robots with charge now
        ("joins", "i8"),  # of two teams: robots that only take themselves for joined do not count
        ("leaves", "i8"),
        ("charges", "i8"),  # robots that left CHR mode
    ]
)
"""What a judge counts."""

GROUND = np.dtype(
    [("first_seen", "i8"), ("reachable", "i8"), ("sensable", "?"), ("ever_free", "?")], align=True
)
"""A map cell: which robot saw it first (-1: none, -2: several), its raster cells, whether they are
sensable, and ever called free."""


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

    @property
    def sensable(self) -> NDArray[np.bool_]:
        """bool[C], at least half of the cell is free."""
        return 2 * self.free >= self.total

    @property
    def sensable_m2(self) -> float:
        """The part of it that is sensable."""
        return float(self.reachable[self.sensable].sum()) * self.raster_cell_m2


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
def judge_map(cells, low, high, ground, touched, before, evidence, status, limits, tally, changed):  # type: ignore[no-untyped-def]
    """Count what a step added to the swarm's map.

    Args:
        cells: int64[N, capacity]; low, high: int64[N]: this step's entries of each robot's log.
        ground: GROUND[C].
        touched, before: int64[n], cells of the swarm's map that were named, and their evidence.
        evidence: int64[C], status: uint8[C']: the swarm's map.
        limits: int64[2], saturation of log-odds when read.
        tally: TALLY[1], written.
        changed: int64[2, C], written: cells that changed as read, and their log-odds.

    Returns:
        How many cells changed as read.
    """
    count = tally[0]
    for k in range(cells.shape[0]):
        for e in range(low[k], high[k]):
            cell = ground[cells[k, e]]
            if cell.first_seen == -1:
                cell.first_seen = k
                count.seen += 1
            elif cell.first_seen >= 0 and cell.first_seen != k:
                cell.first_seen = -2
                count.overlap += 1
    changes = 0
    for t in range(touched.shape[0]):
        at = touched[t]
        now = min(limits[1], max(limits[0], evidence[at]))
        if now != min(limits[1], max(limits[0], before[t])):
            changed[0, changes] = at
            changed[1, changes] = now
            changes += 1
        if status[at] & LABEL_BITS == FREE and not ground[at].ever_free:
            ground[at].ever_free = True
            count.explored += ground[at].reachable
            if ground[at].sensable:
                count.sensed += ground[at].reachable
    return changes


@inlined
def _completes_join(events, e, before):  # type: ignore[no-untyped-def]
    """Whether event e is the first of a new team's by which robots of two former teams are in it.

    Every member has an event. Where links fail, one team may take itself for joined and the other
    not: that is no join.
    """
    first = e
    for earlier in range(1, e):
        if events[earlier].kind != JOIN or events[earlier].value != events[e].value:
            continue
        if first == e:
            first = earlier
        elif before[events[earlier].robot, 3] != before[events[first].robot, 3]:
            return False
    return before[events[first].robot, 3] != before[events[e].robot, 3]


@kernel
def judge_robots(own, can, alive, action, touch, position, heading, before, tally, events):  # type: ignore[no-untyped-def]
    """Count what robots did in a step: by how they moved, not by what they meant to do.

    Args:
        own: MIND[N]; can: CAPABILITIES[N]; alive: bool[N]; action: int64[N]; touch: TOUCH[N].
        position: float64[N, 2], heading: int64[N]: after the step.
        before: float64[N, 4], position, heading and team before it; written: after it.
        tally: TALLY[1], written; events: see ``EventLog``; contacts are appended.
    """
    count = tally[0]
    for e in range(1, min(events[0].value + 1, events.shape[0])):
        kind = events[e].kind
        if kind == LEAVE:
            count.leaves += 1
        elif kind == MODE_EVENT:
            count.charges += events[e].other != CHARGE
        elif kind == JOIN:
            count.joins += _completes_join(events, e, before)
    count.teams = 0
    count.charging = 0
    count.mobile = 0
    count.alive = 0
    for i in range(own.shape[0]):
        if position[i, 0] != before[i, 0] or position[i, 1] != before[i, 1]:
            count.forward_moves += 1
        elif heading[i] != before[i, 2]:
            count.turns += 1
        elif own[i].thinks and action[i] == FORWARD and touch[i].kind != NO_CONTACT:
            count.blocked += 1
            note(events, CONTACT_EVENT, i, touch[i].kind, touch[i].robot)
        before[i, 0] = position[i, 0]
        before[i, 1] = position[i, 1]
        before[i, 2] = heading[i]
        before[i, 3] = own[i].team
        count.alive += alive[i]
        if own[i].thinks:
            count.robot_steps += 1
            count.mobile += can[i].drive
            count.charging += own[i].mode == CHARGE
            count.teams += own[i].leader == i and own[i].mode != CHARGE


class Judge:
    """Keeps count of what a mission achieves.

    Attributes:
        truth: what lies behind each cell of the map.
        area_m2, sensed_m2: lists of explored areas, of all and of those that are sensable, one per
            step; [0] is before the first step.
        reachable_m2, sensable_m2: what they can be at most.

    Args:
        truth: see above.
        bodies: where robots start.
        forward_m: length of a move.
        limits: saturation of log-odds when read, in 1/1000 nat.
    """

    def __init__(
        self, truth: MapTruth, bodies: Bodies, forward_m: float, limits: tuple[int, int]
    ) -> None:
        size = len(truth.reachable)
        self.truth = truth
        self.area_m2: list[float] = [0.0]
        self.sensed_m2: list[float] = [0.0]
        self.reachable_m2 = truth.reachable_m2
        self.sensable_m2 = truth.sensable_m2
        self._forward_m = forward_m
        self._robots = len(bodies.alive)
        self._limits = np.array(limits, dtype=np.int64)
        self._ground = np.zeros(size, dtype=GROUND)
        self._ground["first_seen"] = -1
        self._ground["reachable"] = truth.reachable
        self._ground["sensable"] = truth.sensable
        # Before the first step every robot is a team.
        teams = np.arange(self._robots)
        self._before = np.column_stack((bodies.position, bodies.heading, teams)).astype(np.float64)
        self._tally = np.zeros(1, dtype=TALLY)
        self._tally["mobile"] = self._tally["alive"] = self._robots
        self._changed = np.zeros((2, size), dtype=np.int64)

    def judge_map(
        self, log: EvidenceLog, since: NDArray[np.int64], swarm: OccupancyGrids
    ) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
        """Count what a step added to the swarm's map.

        Args:
            log: every robot's evidence.
            since: int64[N], the first entry of each that is new.
            swarm: the map that all logs together make, just updated.

        Returns:
            Flat cells of the swarm's map that changed as read, and their log-odds (views that the
            next step overwrites).
        """
        n = swarm.touched_count
        changes = judge_map(
            log.cells, since, log.length, self._ground, swarm.touched[:n], swarm.before[:n],
            swarm.evidence[0], swarm.status[0], self._limits, self._tally, self._changed,
        )  # fmt: skip
        self.area_m2.append(int(self._tally[0]["explored"]) * self.truth.raster_cell_m2)
        self.sensed_m2.append(int(self._tally[0]["sensed"]) * self.truth.raster_cell_m2)
        return self._changed[0, :changes], self._changed[1, :changes]

    def judge_robots(
        self, bodies: Bodies, minds: Minds, action: NDArray[np.int64], events: EventLog
    ) -> None:
        """Count what robots did in a step."""
        judge_robots(
            minds.own, bodies.can, bodies.alive, action, bodies.touch, bodies.position,
            bodies.heading, self._before, self._tally, events.rows,
        )  # fmt: skip

    @property
    def explored_m2(self) -> float:
        """Explored area."""
        return self.area_m2[-1]

    @property
    def mobile(self) -> int:
        """Robots that can drive."""
        return int(self._tally[0]["mobile"])

    @property
    def stranded(self) -> int:
        """Robots without charge."""
        return self._robots - int(self._tally[0]["alive"])

    def coverage(self, swarm: OccupancyGrids) -> dict[str, float | int]:
        """One row of the table ``coverage``."""
        counts = swarm.counts[0].tolist()
        tally = self._tally[0]
        return {
            "explored_m2": self.area_m2[-1],
            "explored_fraction": self.area_m2[-1] / self.reachable_m2,
            "known_cells": counts[KNOWN_FREE] + counts[KNOWN_OCCUPIED],
            "frontier_cells": counts[FRONTIERS],
            "teams": int(tally["teams"]),
            "charging": int(tally["charging"]),
            "stranded": self.stranded,
        }

    def summary(self, minds: Minds, swarm: OccupancyGrids) -> dict[str, Any]:
        """The judged part of a mission's summary, see docs/recordings.md."""
        tally = self._tally[0]
        area = np.array(self.area_m2)
        fraction = area / self.reachable_m2
        sensed = np.array(self.sensed_m2) / max(self.sensable_m2, self.truth.raster_cell_m2)
        steps = len(area) - 1
        robot_steps = max(1, int(tally["robot_steps"]))
        leaders = minds.leader[minds.thinking & (minds.mode != CHARGE)]
        sizes = np.unique(leaders, return_counts=True)[1]
        return {
            "explored_m2": float(area[-1]),
            "explored_fraction": float(fraction[-1]),
            "reachable_m2": self.reachable_m2,
            "sensable_m2": self.sensable_m2,
            "sensable_fraction": float(sensed[-1]),
            "area_at_step": {str(s): float(area[s]) for s in range(50, steps + 1, 50)},
            "time_to": _times(fraction),
            "time_to_sensable": _times(sensed),
            "overlap_ratio": float(tally["overlap"] / max(1, tally["seen"])),
            "distance_m": float(tally["forward_moves"] * self._forward_m),
            "forward_share": float(tally["forward_moves"] / robot_steps),
            "turn_share": float(tally["turns"] / robot_steps),
            "blocked_share": float(tally["blocked"] / robot_steps),
            "joins": int(tally["joins"]),
            "leaves": int(tally["leaves"]),
            "teams": sorted((int(size) for size in sizes), reverse=True),
            "charges": int(tally["charges"]),
            "stranded": self.stranded,
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


def _times(fraction: NDArray[np.float64]) -> dict[str, int | None]:
    """The first step at which each share was reached; None: never."""
    times: dict[str, int | None] = {}
    for share in (50, 75, 90, 95, 99):
        reached = fraction >= share / 100 - 1e-12
        times[f"{share}%"] = int(np.argmax(reached)) if reached.any() else None
    return times
