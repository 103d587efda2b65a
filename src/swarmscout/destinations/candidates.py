"""Which of the task's candidates a robot may choose now, by its own map and what it has heard."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from swarmscout.comms.knowledge import Knowledge
from swarmscout.core.jit import kernel
from swarmscout.destinations.features import Frontiers, Scratch
from swarmscout.mapping.occupancy import KNOWN_FREE
from swarmscout.minds.given_up import FOR_GOOD, avoided_until, place_of
from swarmscout.minds.minds import Minds
from swarmscout.planning.routes import Planner

__all__ = ["LOOK_STEPS", "Candidates"]

LOOK_STEPS = 5
"""Number of steps after which a leader without a candidate looks again; sooner if the time for
which a place is avoided ends. What routes lead to is found once for robots that share a map."""


@kernel
def mark_open(flat, cells, given_up, rules, step, now, later):  # type: ignore[no-untyped-def]
    """Mark the candidates that a robot does not avoid now, and those that it does not for good.

    Args:
        flat: int64[F], flat cells, ascending.
        cells: int64[32, 2], `avoided`, and given_up: GIVEN_UP[256]: the robot's own, see ``Minds``.
        rules: RENEWAL[1]; step: the current step.
        now, later: bool[F], written.

    Returns:
        The first step in which a place is not avoided any more.
    """
    rules = rules[0]
    soonest = FOR_GOOD
    for f in range(flat.shape[0]):
        until = avoided_until(given_up, place_of(flat[f], rules))
        now[f] = until < step
        later[f] = until < FOR_GOOD
        if step <= until < soonest:
            soonest = until
    for a in range(cells.shape[0]):
        if cells[a, 1] < step:
            continue
        f = np.searchsorted(flat, cells[a, 0])
        if f < flat.shape[0] and flat[f] == cells[a, 0]:
            now[f] = False
            if later[f]:
                soonest = min(soonest, cells[a, 1])
    return soonest + 1


class Candidates:
    """The candidates of one step; what robots share is computed once for each map.

    Args:
        minds: what robots believe. knowledge: what they have heard. planner: plans routes.
        scratch: memory of the features' kernels.
        cells: the task's candidates in a map, flat and ascending.
        rules: RENEWAL[1]; step: the current step.
    """

    def __init__(
        self,
        minds: Minds,
        knowledge: Knowledge,
        planner: Planner,
        scratch: Scratch,
        cells: Callable[[int], NDArray[np.int64]],
        rules: NDArray[np.void],
        step: int,
    ) -> None:
        self._minds = minds
        self._knowledge = knowledge
        self._planner = planner
        self._scratch = scratch
        self._cells = cells
        self._rules = rules
        self._step = step
        self._frontiers: dict[int, Frontiers] = {}
        self._reached: dict[int, list[tuple[NDArray[np.bool_], NDArray[np.bool_]]]] = {}

    def of_map(self, row: int) -> Frontiers:
        """All candidates of one map."""
        if row not in self._frontiers:
            grids = self._knowledge.grids
            self._frontiers[row] = Frontiers(grids, row, self._cells(row), self._scratch)
        return self._frontiers[row]

    def offered(self, leader: int) -> NDArray[np.bool_] | None:
        """Which of its map's F candidates a leader may choose; None if there is none.

        Then it notes when to look again. In exploration a leader waits until places are not avoided
        any more; other tasks have candidates that stay, and where nothing else is left the leader
        may choose what it avoids.

        Args:
            leader: the robot.

        Returns:
            bool[F], at least one of them true.
        """
        me, step = self._minds.own[leader], self._step
        row = int(self._knowledge.ear[leader])
        flat = self.of_map(row).flat
        me["look_at"], me["hopeless"] = step + 1, True
        if len(flat) == 0:
            return None
        now, later, soonest = self._open(leader, flat)
        if me["doubts"]:
            routed = self._routed(leader, row)
            me["doubts"] = not routed[later].all()
            now &= routed
            later &= routed
        if not now.any() and not self._rules["closes"][0]:
            now = later
        if now.any():
            me["hopeless"] = False
            return now
        if self._rules["closes"][0]:
            me["look_at"] = min(step + LOOK_STEPS, soonest)
        me["hopeless"] = not later.any()
        return None

    def masks(
        self, row: int, leaders: Sequence[int]
    ) -> tuple[NDArray[np.bool_], NDArray[np.int64]]:
        """Where routes lead, for leaders that read the same map.

        Returns:
            bool[K, F]; and int64[L], the row that counts for each leader, -1 if it doubts nothing.
        """
        masks: list[NDArray[np.bool_]] = []
        which = np.full(len(leaders), -1, dtype=np.int64)
        doubts = self._minds.own["doubts"]
        for k, leader in enumerate(leaders):
            if doubts[leader]:
                routed = self._routed(leader, row)
                which[k] = next((m for m, known in enumerate(masks) if known is routed), len(masks))
                if which[k] == len(masks):
                    masks.append(routed)
        flat = self.of_map(row).flat
        return np.array(masks, dtype=np.bool_).reshape(len(masks), len(flat)), which

    def take(self, me: np.void, *, doubts: bool) -> None:
        """Note that a leader has chosen a candidate.

        Args:
            me: the leader's own record. doubts: whether another candidate has no route.
        """
        me["look_at"], me["hopeless"], me["doubts"] = self._step + 1, False, doubts

    def is_hopeless(self, robot: int) -> bool:
        """Whether a robot knows of no candidate that a route reaches, now or later."""
        row = int(self._knowledge.ear[robot])
        if self._knowledge.grids.counts[row, KNOWN_FREE] == 0:
            return False  # It has seen too little to know.
        flat = self.of_map(row).flat
        _, later, _ = self._open(robot, flat)
        return not later.any() or not (later & self._routed(robot, row)).any()

    def _open(
        self, robot: int, flat: NDArray[np.int64]
    ) -> tuple[NDArray[np.bool_], NDArray[np.bool_], int]:
        now, later = np.empty(len(flat), dtype=np.bool_), np.empty(len(flat), dtype=np.bool_)
        minds = self._minds
        soonest = mark_open(
            flat, minds.avoided[robot], minds.given_up[robot], self._rules, self._step, now, later
        )
        return now, later, int(soonest)

    def _routed(self, robot: int, row: int) -> NDArray[np.bool_]:
        """bool[F], whether there is a route from a robot to each candidate of its map.

        Ways lead back and forth, so one search answers for all robots whose places it reaches.
        """
        places = self._places
        for routed, met in self._reached.setdefault(row, []):
            if met[robot]:
                return routed
        flat, grids = self.of_map(row).flat, self._knowledge.grids
        entries = np.concatenate((self.of_map(row).entries, grids.entries(row, places)))
        reached = self._planner.connects(grids, row, int(places[robot]), entries)
        # Wherever a robot is, it is there already.
        reached[np.concatenate((flat, places)) == places[robot]] = True
        # Of robots that read another map it says nothing.
        met = reached[len(flat) :] & (self._knowledge.ear == row)
        self._reached[row].append((reached[: len(flat)], met))
        return self._reached[row][-1][0]

    @cached_property
    def _places(self) -> NDArray[np.int64]:
        """int64[N], the cells in which robots believe to be."""
        own, frame = self._minds.own, self._knowledge.grids.frame
        at = frame.cells_of(np.column_stack((own["x_m"], own["y_m"])))
        at[:, 0].clip(0, frame.rows - 1, out=at[:, 0])
        at[:, 1].clip(0, frame.columns - 1, out=at[:, 1])
        places: NDArray[np.int64] = at[:, 0] * frame.columns + at[:, 1]
        return places
