"""Exchange: order, grouping and repetition of contacts never change what a map says.

The oracle knows nothing of prefixes: each robot has a *set* of entries, and a contact is a union.
"""

from __future__ import annotations

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from swarmscout.core.grid import GridFrame
from swarmscout.mapping.evidence import EvidenceLog
from swarmscout.mapping.exchange import exchange_evidence, merge_versions, share_evidence
from swarmscout.mapping.log_odds import InverseSensorModel, log_odds_of
from swarmscout.mapping.occupancy import OccupancyGrids

FRAME = GridFrame(0.0, 0.0, 0.5, rows=5, columns=7)
MODEL = InverseSensorModel(
    -405, 847, log_odds_of(0.03), log_odds_of(0.97), log_odds_of(0.35), log_odds_of(0.65), 0.05
)

Bools = NDArray[np.bool_]
Entry = tuple[int, int]  # Whose log, and which entry of it.


class Swarm:
    """N robots with a log and a map each, and beside them the oracle's sets."""

    def __init__(self, robots: int, seed: int) -> None:
        self.rng = np.random.default_rng(seed)
        self.log = EvidenceLog(robots, 1, 0.2, 0.5, keep=True)
        self.grids = OccupancyGrids(FRAME, robots, MODEL, 8)
        self.known = np.zeros((robots, robots), dtype=np.int64)
        self.sets: list[set[Entry]] = [set() for _ in range(robots)]
        self.robots = robots

    def see(self) -> None:
        """Each robot's log gets a few entries."""
        self.log.make_room()
        for k in range(self.robots):
            for _ in range(int(self.rng.integers(0, self.log.per_scan + 1))):
                n = int(self.log.length[k])
                self.log.cells[k, n] = self.rng.integers(FRAME.size)
                self.log.increments[k, n] = self.rng.choice([-405, -810, 847, 442])
                self.log.length[k] = n + 1
                self.sets[k].add((k, n))

    def meet(self, links: Bools) -> None:
        """One round of contacts, all at the same time."""
        exchange_evidence(self.grids, self.log, self.known, links)
        heard = [
            set().union(*(self.sets[j] for j in range(self.robots) if j == i or links[i, j]))
            for i in range(self.robots)
        ]
        self.sets = heard

    def sum_of(self, entries: set[Entry]) -> NDArray[np.int64]:
        total = np.zeros(FRAME.size, dtype=np.int64)
        for k, n in entries:
            total[self.log.cells[k, n]] += self.log.increments[k, n]
        return total

    def check(self) -> None:
        """Each map is the sum of exactly what its robot has heard, each entry once."""
        for i in range(self.robots):
            prefixes = {(k, n) for k in range(self.robots) for n in range(self.known[i, k])}
            assert prefixes == self.sets[i]
            assert np.array_equal(self.grids.evidence[i], self.sum_of(self.sets[i]))
            self.check_derived(i)

    def check_derived(self, i: int) -> None:
        """A map that grew bit by bit equals one that takes in everything at once."""
        whole = OccupancyGrids(FRAME, 1, MODEL, 8)
        whole.apply(
            0, self.log.cells, self.log.increments, np.zeros_like(self.known[i]), self.known[i]
        )
        assert np.array_equal(whole.evidence[0], self.grids.evidence[i])
        assert np.array_equal(whole.status[0], self.grids.status[i])
        assert np.array_equal(whole.price[0], self.grids.price[i])
        assert np.array_equal(whole.counts[0, 1:], self.grids.counts[i, 1:])
        assert np.array_equal(whole.frontiers(0), self.grids.frontiers(i))

    def fused(self) -> OccupancyGrids:
        """The map of one who hears everybody."""
        grids = OccupancyGrids(FRAME, 1, MODEL, 8)
        share_evidence(grids, self.log, np.zeros(self.robots, dtype=np.int64))
        return grids

    def check_complete(self) -> None:
        """All maps equal the fused one, bit for bit."""
        fused = self.fused()
        assert (self.known == self.log.length).all()
        for i in range(self.robots):
            assert np.array_equal(self.grids.evidence[i], fused.evidence[0])
            assert np.array_equal(self.grids.status[i], fused.status[0])
            assert np.array_equal(self.grids.price[i], fused.price[0])


def some_links(rng: np.random.Generator, robots: int, share: float) -> Bools:
    """Random links; they need not be mutual, and who hears himself does not matter."""
    return rng.random((robots, robots)) < share


swarms = st.builds(Swarm, st.integers(1, 6), st.integers(0, 2**32 - 1))
shares = st.sampled_from([0.0, 0.1, 0.3, 0.7, 1.0])


@given(swarms, st.lists(shares, min_size=1, max_size=10))
def test_maps_equal_exactly_what_the_version_vectors_name(
    swarm: Swarm, rounds: list[float]
) -> None:
    for share in rounds:
        if swarm.rng.random() < 0.7:
            swarm.see()
        swarm.meet(some_links(swarm.rng, swarm.robots, share))
        swarm.check()


@given(swarms, shares)
def test_meeting_again_without_news_changes_nothing(swarm: Swarm, share: float) -> None:
    for _ in range(3):
        swarm.see()
        swarm.meet(some_links(swarm.rng, swarm.robots, share))
    everybody = np.ones((swarm.robots, swarm.robots), dtype=np.bool_)
    swarm.meet(everybody)
    before = swarm.grids.evidence.copy(), swarm.known.copy()
    for _ in range(3):
        swarm.meet(some_links(swarm.rng, swarm.robots, 0.8))
        swarm.meet(everybody)
    assert np.array_equal(swarm.grids.evidence, before[0])
    assert np.array_equal(swarm.known, before[1])


@given(swarms, shares)
def test_complete_gossip_gives_the_fused_map(swarm: Swarm, share: float) -> None:
    for _ in range(4):
        swarm.see()
        swarm.meet(some_links(swarm.rng, swarm.robots, share))
    # Round a ring, each hearing one other only, everything has gone round after N - 1 contacts.
    ring = np.roll(np.eye(swarm.robots, dtype=np.bool_), 1, axis=1)
    for _ in range(max(1, swarm.robots - 1)):
        swarm.meet(ring)
    swarm.check_complete()


@settings(max_examples=25)
@given(st.integers(2, 5), st.integers(0, 2**32 - 1))
def test_order_and_grouping_of_contacts_do_not_matter(robots: int, seed: int) -> None:
    ends = []
    for order in range(3):
        swarm = Swarm(robots, seed)
        for _ in range(3):
            swarm.see()
        pairs = [(i, j) for i in range(robots) for j in range(robots) if i != j]
        mixed = np.random.default_rng([seed, order])
        for _ in range(robots):
            mixed.shuffle(pairs)
            group = int(mixed.integers(1, len(pairs) + 1))
            for first in range(0, len(pairs), group):
                links = np.zeros((robots, robots), dtype=np.bool_)
                for i, j in pairs[first : first + group]:
                    links[i, j] = True
                swarm.meet(links)
        swarm.check_complete()
        ends.append(swarm.grids.evidence)
    assert np.array_equal(ends[0], ends[1])
    assert np.array_equal(ends[0], ends[2])


@given(swarms)
def test_full_communication_is_the_special_case_of_complete_links(swarm: Swarm) -> None:
    shared = OccupancyGrids(FRAME, 1, MODEL, 8)
    everybody = np.ones((swarm.robots, swarm.robots), dtype=np.bool_)
    for _ in range(4):
        since = swarm.log.length.copy()
        swarm.see()
        touched = share_evidence(shared, swarm.log, since)
        assert touched == len(set(shared.touched[:touched].tolist()))
        swarm.meet(everybody)
        for i in range(swarm.robots):
            assert np.array_equal(swarm.grids.status[i], shared.status[0])
            assert np.array_equal(swarm.grids.counts[i], shared.counts[0])
        swarm.check_complete()


def test_news_travel_one_contact_at_a_time() -> None:
    """In one round of contacts 0 hears 1 and 1 hears 2, so 0 does not hear of 2 yet."""
    known = np.zeros((3, 3), dtype=np.int64)
    links = np.array([[0, 1, 0], [0, 0, 1], [0, 0, 0]], dtype=np.bool_)
    length = np.array([4, 5, 6])
    merged = np.empty_like(known)
    merge_versions(known, length, links, merged)
    assert merged.tolist() == [[4, 5, 0], [0, 5, 6], [0, 0, 6]]
    merge_versions(merged, length, links, known)
    assert known.tolist() == [[4, 5, 6], [0, 5, 6], [0, 0, 6]]
