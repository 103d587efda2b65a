"""Exchange: order, grouping and repetition of contacts never change what a map says."""

from __future__ import annotations

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from small_swarm import Bools, Swarm


def some_links(rng: np.random.Generator, robots: int, share: float) -> Bools:
    """Random links; they need not be mutual, and the diagonal does not matter."""
    return rng.random((robots, robots)) < share


swarms = st.builds(Swarm, st.integers(1, 6), st.integers(0, 2**32 - 1))
shares = st.sampled_from([0.0, 0.1, 0.3, 0.7, 1.0])


@given(swarms, st.lists(shares, min_size=1, max_size=10))
def test_maps_equal_exactly_what_the_version_vectors_name(
    swarm: Swarm, rounds: list[float]
) -> None:
    swarm.check_groups()
    for share in rounds:
        if swarm.rng.random() < 0.7:
            swarm.see()
        swarm.meet(some_links(swarm.rng, swarm.robots, share))
        swarm.check()


@given(swarms, st.lists(shares, min_size=1, max_size=10))
def test_robots_that_cannot_send_hear_or_think_change_nothing_for_others(
    swarm: Swarm, rounds: list[float]
) -> None:
    for share in rounds:
        for capability in ("sends", "hears", "thinks"):
            swarm.minds.own[capability] = swarm.rng.random(swarm.robots) < 0.8
        # A robot that does not think sends nothing either, and writes no evidence.
        swarm.minds.own["sends"] &= swarm.minds.own["thinks"]
        if swarm.minds.own["thinks"].all():
            swarm.see()
        swarm.meet(None if share == 1.0 else some_links(swarm.rng, swarm.robots, share))
        swarm.check()


@given(swarms, shares)
def test_meeting_again_without_news_changes_nothing(swarm: Swarm, share: float) -> None:
    for _ in range(3):
        swarm.see()
        swarm.meet(some_links(swarm.rng, swarm.robots, share))
    everybody = np.ones((swarm.robots, swarm.robots), dtype=np.bool_)
    swarm.meet(everybody)
    before = swarm.known.copy()
    for _ in range(3):
        swarm.meet(some_links(swarm.rng, swarm.robots, 0.8))
        swarm.meet(everybody)
    assert np.array_equal(swarm.known, before)
    swarm.check_complete()


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


@given(swarms)
def test_full_communication_is_one_row(swarm: Swarm) -> None:
    everybody = np.ones((swarm.robots, swarm.robots), dtype=np.bool_)
    for _ in range(4):
        swarm.see()
        swarm.meet(everybody)
        assert swarm.knowledge.rows.tolist() == [0]
        swarm.check_complete()
        swarm.see()
        swarm.meet(None)
        assert swarm.knowledge.rows.tolist() == [0]
        swarm.check_complete()


@given(st.integers(2, 6), st.integers(0, 2**32 - 1))
def test_groups_part_and_merge_again(robots: int, seed: int) -> None:
    swarm = Swarm(robots, seed)
    half = np.arange(robots) < robots // 2
    for _ in range(3):
        swarm.see()
        swarm.meet(half[:, None] == half[None, :])
    assert len(swarm.knowledge.rows) == 2
    swarm.see()
    # Robots that have not moved are known to have stood for different times.
    swarm.minds.own["x_m"] += 1.0
    swarm.meet(None)
    assert len(swarm.knowledge.rows) == 1
    swarm.check_complete()
    # What all robots have is not kept.
    swarm.log.make_room(swarm.knowledge.oldest())
    assert swarm.log.length.tolist() == [0] * robots


def test_news_travel_one_contact_at_a_time() -> None:
    """In one round of contacts 0 hears 1 and 1 hears 2, so 0 does not hear of 2 yet."""
    swarm = Swarm(3, 0)
    swarm.see()
    links = np.array([[0, 1, 0], [0, 0, 1], [0, 0, 0]], dtype=np.bool_)
    a, b, c = (len(entries) for entries in swarm.written)
    swarm.meet(links)
    assert swarm.known.tolist() == [[a, b, 0], [0, b, c], [0, 0, c]]
    swarm.meet(links)
    assert swarm.known.tolist() == [[a, b, c], [0, b, c], [0, 0, c]]
