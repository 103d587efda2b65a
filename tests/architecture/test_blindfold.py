"""No robot decides by what it cannot know; a selector that peeks is found out."""

from __future__ import annotations

import pytest
from blindfold import PeeksAtMemories, PeeksAtMinds, PeeksAtTruth, ToldAll, peeks, peeks_alone

from swarmscout.destinations.registry import make_selector, selectors


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
