"""What groups of robots know: rows of heard beacons, version vectors and maps.

``ear[i]`` names the row that robot i reads. Robots that know exactly the same share one row: under
full communication there is a single row, and robots that never speak have a row each. A row is
copied when its group parts, and two rows become one when their groups know the same again. So
memory and time grow with the number of groups, and the rules are the same code for all links.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from swarmscout.comms.exchange import deliver, same_knowledge
from swarmscout.comms.heard_sets import HeardSets, split_groups
from swarmscout.comms.messages import BEACON, blank_notices, send_beacons, send_notices
from swarmscout.core.links import Links
from swarmscout.mapping.evidence import EvidenceLog
from swarmscout.mapping.occupancy import CLOSED, OccupancyGrids
from swarmscout.minds.minds import Minds

__all__ = ["Knowledge"]


class Knowledge:
    """What N robots know of each other and of the world, in R rows.

    Attributes:
        ear: int64[N], the row that each robot reads.
        rows: int64[A], the rows in use, ascending.
        listeners: int64[N], robots by row and then by id.
        groups: int64[A, 3], for each row in use its number, and where the robots that read it begin
            and end in `listeners`.
        heard: BEACON[R, N], the last beacon heard of each robot.
        still: int64[R, N], for how many steps a robot has not moved, as far as is known.
        versions: int64[R, N], how many entries of each robot's log the row's map contains.
        grids: R occupancy grids.
        notices: NOTICE[N], what each robot last told its team; robot i may read those of the robots
            whose beacon it heard in the same step.

    Args:
        robots: N.
        grids: one blank occupancy grid.
    """

    def __init__(self, robots: int, grids: OccupancyGrids) -> None:
        self.ear = np.zeros(robots, dtype=np.int64)
        self.rows = np.zeros(1, dtype=np.int64)
        self.listeners = np.arange(robots)
        self.groups = np.array([[0, 0, robots]], dtype=np.int64)
        self.heard = np.zeros((1, robots), dtype=BEACON)
        self.heard["step"] = -1
        self.still = np.zeros((1, robots), dtype=np.int64)
        self.versions = np.zeros((1, robots), dtype=np.int64)
        self.grids = grids
        self.notices = blank_notices(robots)
        self._beacons = np.zeros(robots, dtype=BEACON)
        self._sound = True

    def send(self, minds: Minds, step: int) -> bool:
        """Robots make their beacons.

        Args:
            minds: what robots have to say.
            step: the current step.

        Returns:
            Whether each robot can hear, and each that thinks can send.
        """
        self._sound = bool(send_beacons(minds.own, step, self._beacons))
        return self._sound

    def receive(self, minds: Minds, log: EvidenceLog, links: Links, step: int) -> None:
        """Beacons and evidence flow along the links of a step.

        Args:
            minds: which robots send and hear.
            log: every robot's evidence.
            links: who is in whose range.
            step: the current step.
        """
        ear = self.ear
        if links.complete and self._sound and len(self.rows) == 1:
            # All robots hear the same: the one group stays together.
            members = minds.own["sends"].nonzero()[0]
            bounds = np.array([[self.rows[0], 0, len(members)]])
            shares_sets = False
        else:
            sets = HeardSets.of(links, minds.own)
            ear = self.ear.copy()
            self._part(sets)
            set_of_row = sets.set_of[self.listeners[self.groups[:, 1]]]
            members = sets.members
            bounds = np.column_stack((self.rows, sets.bounds[set_of_row]))
            shares_sets = len(np.unique(set_of_row)) < len(self.rows)
        before = self.versions.copy()
        deliver(
            self._beacons, log.end(), bounds, members, ear, self.heard, self.still, self.versions,
            before, step,
        )  # fmt: skip
        merged = self._merge(set_of_row) if shares_sets else []
        for row in self.rows.tolist():
            self.grids.apply(
                row, log.cells, log.increments,
                before[row] - log.dropped, self.versions[row] - log.dropped,
            )  # fmt: skip
        if merged:
            # What closed on the map of a row that was dropped may concern routes of its robots.
            self.grids.counts[merged, CLOSED] += 1

    def tell(self, minds: Minds, step: int) -> None:
        """Send team notices: what robots have decided since their beacons."""
        send_notices(minds.own, step, self.notices)

    def noticed(self, robot: int, step: int) -> NDArray[np.bool_]:
        """bool[N], the robots whose beacon and notices a robot heard in a step; itself too."""
        noticed: NDArray[np.bool_] = self.notices["step"] == step
        noticed &= self.heard["step"][self.ear[robot]] == step
        return noticed

    def oldest(self) -> NDArray[np.int64]:
        """int64[N], how many entries of each robot's log every row contains."""
        if len(self.rows) == 1:
            only: NDArray[np.int64] = self.versions[self.rows[0]]
            return only
        lowest: NDArray[np.int64] = self.versions[self.rows].min(axis=0)
        return lowest

    def effective(self, links: Links, minds: Minds) -> NDArray[np.bool_]:
        """bool[N, N]: who really heard whom; robots that cannot send are heard by none."""
        heard: NDArray[np.bool_] = links.matrix() & minds.own["sends"] & minds.own["hears"][:, None]
        np.fill_diagonal(heard, True)
        return heard

    def _part(self, sets: HeardSets) -> None:
        """Give a row of its own to each part of a group that hears different robots."""
        robots = len(self.ear)
        used = np.zeros(len(self.heard) + robots, dtype=np.bool_)
        used[self.rows] = True
        copies = np.empty((robots, 2), dtype=np.int64)
        table = np.full((1 << (2 * robots).bit_length(), 2), -1, dtype=np.int64)
        count = split_groups(
            self.ear, sets.set_of, np.flatnonzero(~used), table, np.zeros_like(used), copies
        )
        if count:
            self._grow(int(copies[:count, 1].max()) + 1)
            for source, target in copies[:count].tolist():
                for array in (self.heard, self.still, self.versions):
                    array[target] = array[source]
                self.grids.copy_row(source, target)
            self._index()

    def _grow(self, rows: int) -> None:
        """Make room for at least this number of rows."""
        have = len(self.heard)
        if rows > have:
            more = max(rows, min(2 * have, len(self.ear)))
            self.heard = np.resize(self.heard, (more, len(self.ear)))
            self.still = np.resize(self.still, (more, len(self.ear)))
            self.versions = np.resize(self.versions, (more, len(self.ear)))
            self.grids.grow(more)

    def _merge(self, set_of_row: NDArray[np.int64]) -> list[int]:
        """Let groups that know the same after hearing the same share one row.

        Returns:
            The rows that took in another one.
        """
        kept: dict[int, list[int]] = {}
        merged = set()
        for row, heard_set in zip(self.rows.tolist(), set_of_row.tolist(), strict=True):
            for other in kept.setdefault(heard_set, []):
                if same_knowledge(self.heard, self.still, self.versions, other, row):
                    self.ear[self.ear == row] = other
                    merged.add(other)
                    break
            else:
                kept[heard_set].append(row)
        if merged:
            self._index()
        return sorted(merged)

    def _index(self) -> None:
        self.listeners = np.argsort(self.ear, kind="stable")
        self.rows, first = np.unique(self.ear[self.listeners], return_index=True)
        self.groups = np.column_stack((self.rows, first, np.append(first[1:], len(self.ear))))
