"""A random stream depends on its address and on nothing else."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from swarmscout.core.streams import stream

GOLDEN_START = [7326321732788805764, 5026154919675793260, 2177477748776465972, 8401500219380857101]
GOLDEN_DECIDE = [7647849934700782601, 3142766032235342922, 6096362692092297635, 6003026603536933454]
GOLDEN_FLOATS = [0.967576499846616, 0.09927774934330036]

addresses = st.tuples(
    st.integers(0, 2**40),
    st.sampled_from(["start", "heading", "sensor", "decide", "world"]),
    st.lists(st.integers(0, 10**6), max_size=3).map(tuple),
)


def numbers(address: tuple[int, str, tuple[int, ...]]) -> list[int]:
    seed, purpose, index = address
    return stream(seed, purpose, *index).integers(0, 2**63, 4).tolist()


@given(addresses)
def test_the_same_address_gives_the_same_numbers(
    address: tuple[int, str, tuple[int, ...]],
) -> None:
    assert numbers(address) == numbers(address)


@given(st.lists(addresses, min_size=2, max_size=12, unique=True))
def test_different_addresses_give_different_numbers(
    some: list[tuple[int, str, tuple[int, ...]]],
) -> None:
    assert len({tuple(numbers(address)) for address in some}) == len(some)


@given(st.lists(addresses, min_size=2, max_size=8, unique=True), st.randoms(use_true_random=False))
def test_it_does_not_matter_who_asks_first_or_draws_in_between(
    some: list[tuple[int, str, tuple[int, ...]]], random: object
) -> None:
    before = {address: numbers(address) for address in some}
    generators = {a: stream(a[0], a[1], *a[2]) for a in reversed(some)}
    drawn: dict[object, list[int]] = {a: [] for a in some}
    for _ in range(4):
        for a in sorted(some, key=lambda _: random.random()):  # type: ignore[attr-defined]
            drawn[a].append(int(generators[a].integers(0, 2**63)))
    assert drawn == before


def test_neighbouring_addresses_are_not_correlated() -> None:
    draws = np.array([stream(0, "sensor", step).standard_normal(200) for step in range(100)])
    correlation = np.corrcoef(draws)[np.triu_indices(100, 1)]
    # Of 4950 pairs none should stray farther than five standard deviations.
    assert np.abs(correlation).max() < 5.0 / np.sqrt(200)


def test_numpy_integers_are_addresses_like_any_other() -> None:
    index = np.int64(12)
    assert stream(7, "decide", index).random() == stream(7, "decide", 12).random()


def test_golden_numbers_do_not_change_with_platform_or_version() -> None:
    assert numbers((0, "start", ())) == GOLDEN_START
    assert numbers((7, "decide", (3, 120))) == GOLDEN_DECIDE
    assert stream(1, "sensor", 2).random(2).tolist() == GOLDEN_FLOATS
