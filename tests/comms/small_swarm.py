"""Robots that do nothing but write evidence and meet, and an oracle beside them.

The oracle knows nothing of prefixes and groups: each robot has a *set* of entries and a table of
the last beacons, and a contact is a union.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from swarmscout.comms.knowledge import Knowledge
from swarmscout.core.grid import GridFrame
from swarmscout.core.links import Links
from swarmscout.mapping.evidence import EvidenceLog
from swarmscout.mapping.log_odds import InverseSensorModel, log_odds_of
from swarmscout.mapping.occupancy import OccupancyGrids
from swarmscout.minds.minds import blank_minds

FRAME = GridFrame(0.0, 0.0, 0.5, rows=5, columns=7)
MODEL = InverseSensorModel(
    -405, 847, log_odds_of(0.03), log_odds_of(0.97), log_odds_of(0.35), log_odds_of(0.65), 0.05
)

Bools = NDArray[np.bool_]
Entry = tuple[int, int]  # Whose log, and which entry of it.


class Swarm:
    """N robots with a log each, what they know in rows, and beside them the oracle."""

    def __init__(self, robots: int, seed: int) -> None:
        self.rng = np.random.default_rng(seed)
        self.robots = robots
        self.minds = blank_minds(robots)
        self.log = EvidenceLog(robots, 1, 0.2, 0.5)
        self.knowledge = Knowledge(robots, OccupancyGrids(FRAME, 1, MODEL, 8))
        self.step = 0
        self.written: list[list[tuple[int, int]]] = [[] for _ in range(robots)]
        self.sets: list[set[Entry]] = [set() for _ in range(robots)]
        self.last_heard = np.full((robots, robots), -1)

    def row(self, robot: int) -> int:
        """The row that a robot reads."""
        return int(self.knowledge.ear[robot])

    def heard(self, robot: int) -> NDArray[np.void]:
        """The beacons that a robot has heard."""
        return self.knowledge.heard[self.row(robot)]

    @property
    def known(self) -> NDArray[np.int64]:
        """int64[N, N], version vectors."""
        return self.knowledge.versions[self.knowledge.ear]

    def see(self) -> None:
        """Each robot's log gets a few entries."""
        self.log.make_room(self.knowledge.oldest())
        for k in range(self.robots):
            for _ in range(int(self.rng.integers(0, self.log.per_scan + 1))):
                n = int(self.log.length[k])
                cell, increment = self.rng.integers(FRAME.size), self.rng.choice([-405, 847, 442])
                self.log.cells[k, n], self.log.increments[k, n] = cell, increment
                self.log.length[k] = n + 1
                self.sets[k].add((k, len(self.written[k])))
                self.written[k].append((int(cell), int(increment)))

    def meet(self, links: Bools | None) -> None:
        """One round of contacts, all at the same time; None: full communication."""
        self.step += 1
        robots = self.robots
        given = Links.full(robots) if links is None else Links.of_matrix(links, robots, "test")
        self.knowledge.send(self.minds, self.step)
        self.knowledge.receive(self.minds, self.log, given, self.step)
        heard = np.ones((robots, robots), dtype=np.bool_) if links is None else links.copy()
        heard &= self.minds.own["sends"] & self.minds.own["hears"][:, None]
        for i in range(robots):
            heard[i, i] = self.minds.own["thinks"][i]
        self.last_heard[heard] = self.step
        self.sets = [
            self.sets[i].union(*(self.sets[j] for j in np.flatnonzero(heard[i])))
            for i in range(robots)
        ]

    def sum_of(self, entries: set[Entry]) -> NDArray[np.int64]:
        total = np.zeros(FRAME.size, dtype=np.int64)
        for k, n in entries:
            cell, increment = self.written[k][n]
            total[cell] += increment
        return total

    def check(self) -> None:
        """Each map is the sum of exactly what its robot has heard, each entry once."""
        self.check_groups()
        for i in range(self.robots):
            prefixes = {(k, n) for k in range(self.robots) for n in range(self.known[i, k])}
            assert prefixes == self.sets[i]
            total = self.sum_of(self.sets[i])
            np.testing.assert_array_equal(self.knowledge.grids.evidence[self.row(i)], total)
            self.check_derived(self.row(i), total)
            np.testing.assert_array_equal(self.heard(i)["step"], self.last_heard[i])

    def check_groups(self) -> None:
        """Each robot is listed once: in the group of the row that it reads, by ascending id."""
        knowledge = self.knowledge
        listed = {row: knowledge.listeners[a:b].tolist() for row, a, b in knowledge.groups.tolist()}
        assert listed == {
            row: np.flatnonzero(knowledge.ear == row).tolist()
            for row in set(knowledge.ear.tolist())
        }
        assert knowledge.rows.tolist() == sorted(listed)

    def check_derived(self, row: int, total: NDArray[np.int64]) -> None:
        """A map that grew bit by bit equals one that takes in everything at once."""
        grids, whole = self.knowledge.grids, whole_map(total)
        np.testing.assert_array_equal(whole.status[0], grids.status[row])
        np.testing.assert_array_equal(whole.price[0], grids.price[row])
        np.testing.assert_array_equal(whole.counts[0, 1:], grids.counts[row, 1:])
        np.testing.assert_array_equal(whole.frontiers(0), grids.frontiers(row))

    def check_complete(self) -> None:
        """All maps equal the fused one, bit for bit."""
        everything = {(k, n) for k in range(self.robots) for n in range(len(self.written[k]))}
        assert all(entries == everything for entries in self.sets)
        self.check()


def whole_map(total: NDArray[np.int64]) -> OccupancyGrids:
    """A map with this evidence, made at once."""
    grids = OccupancyGrids(FRAME, 1, MODEL, 8)
    cells = np.arange(FRAME.size)[None]
    many = np.array([FRAME.size])
    grids.apply(0, cells, total[None].copy(), 0 * many, many)
    # Cells that nothing was said of count as untouched.
    named = np.flatnonzero(total)
    rows = named // FRAME.columns
    grids.bounds[0] = (rows.min(), rows.max()) if len(named) else (FRAME.rows, -1)
    return grids
