"""No robot decides by what it cannot know; a selector that peeks is found out."""

from __future__ import annotations

import pytest
from blindfold import (
    PeeksAtMaps,
    PeeksAtMemories,
    PeeksAtMinds,
    PeeksAtNotices,
    PeeksAtTruth,
    SizedByAll,
    SizesByAllHeard,
    SizesByMinds,
    SizesByOthersCharge,
    SizesByTruth,
    ToldAll,
    peeks,
    peeks_alone,
    peeks_partly,
)

from swarmscout.destinations.nearest import Nearest
from swarmscout.destinations.registry import make_selector, selectors
from swarmscout.mission.mission import Mission
from swarmscout.teams.registry import make_policy, policies


def nearest(mission: Mission) -> Nearest:
    return Nearest()


@pytest.mark.parametrize("name", sorted(selectors()))
def test_built_in_selectors_decide_blindfold(name: str) -> None:
    assert peeks(lambda mission: make_selector(name), seeds=(1,), steps=5) == []


def test_a_view_shows_nothing_that_the_leader_cannot_know() -> None:
    assert peeks(lambda mission: ToldAll(), steps=10) == []


def test_who_hears_nobody_decides_by_itself() -> None:
    assert peeks_alone(lambda mission: ToldAll()) == []


@pytest.mark.parametrize("mutant", [PeeksAtTruth, PeeksAtMinds, PeeksAtMemories])
def test_a_selector_that_peeks_is_found_out(mutant: type) -> None:
    found = peeks(mutant)
    assert any("decisions" in line for line in found)


def test_a_selector_that_peeks_is_found_out_when_it_is_alone() -> None:
    found = peeks_alone(PeeksAtTruth)
    assert any("decisions" in line for line in found)


@pytest.mark.parametrize("name", sorted(policies()))
def test_built_in_policies_decide_blindfold(name: str) -> None:
    assert peeks(nearest, lambda mission: make_policy(name), seeds=(1,), steps=5) == []
    assert peeks_alone(nearest, lambda mission: make_policy(name), steps=2) == []


def test_a_view_of_robots_shows_nothing_that_they_cannot_know() -> None:
    assert peeks(nearest, lambda mission: SizedByAll(), seeds=(1,)) == []
    assert peeks_alone(nearest, lambda mission: SizedByAll(), steps=3) == []


@pytest.mark.parametrize("mutant", [SizesByTruth, SizesByMinds])
def test_a_policy_that_peeks_is_found_out(mutant: type) -> None:
    assert any("own" in line for line in peeks(nearest, mutant, seeds=(1,)))


def test_a_policy_that_looks_at_other_rows_is_found_out() -> None:
    found = peeks_alone(nearest, lambda mission: SizesByOthersCharge(), steps=1)
    assert any("own" in line for line in found)


@pytest.mark.parametrize("seed", [0, 2])
def test_who_hears_some_decides_by_what_it_hears(seed: int) -> None:
    assert peeks_partly(nearest, lambda mission: SizedByAll(), seed=seed) == []
    assert peeks_partly(lambda mission: ToldAll(), seed=seed) == []


@pytest.mark.parametrize("mutant", [PeeksAtNotices, PeeksAtMaps])
def test_a_selector_that_reads_unheard_messages_is_found_out(mutant: type) -> None:
    assert any("decisions" in line for line in peeks_partly(mutant, steps=3))


def test_a_policy_that_reads_unheard_messages_is_found_out() -> None:
    found = peeks_partly(nearest, SizesByAllHeard, steps=2)
    assert any("own" in line for line in found)
