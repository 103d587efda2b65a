"""The conformance check passes what is sound, and names each mistake."""

from __future__ import annotations

import random
import re
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from wrong_selectors import MISTAKES, first

from swarmscout.core.enums import FREE, UNKNOWN
from swarmscout.core.errors import SelectorError
from swarmscout.destinations.registry import selectors
from swarmscout.destinations.selector import Choice
from swarmscout.testing import check_selector, leader_view, situations, small_world


@pytest.mark.parametrize("name", sorted(selectors()))
def test_built_in_selectors_are_sound(name: str) -> None:
    report = check_selector(name, missions=1)
    assert report.answers > 20
    assert len(report.checks) == 7
    text = str(report)
    assert f"selector '{name}' is sound" in text
    assert "a single frontier" in text
    assert "hundreds of frontiers" in text


def test_an_instance_a_class_and_a_file_can_be_checked(tmp_path: Path) -> None:
    file = tmp_path / "mine.py"
    file.write_text(
        "from swarmscout.destinations.selector import Choice\n"
        "class Last:\n"
        "    def choose(self, view, memory):\n"
        "        return Choice(tuple(view.frontiers[-1]))\n"
    )
    assert check_selector(f"{file}:Last", missions=1).name == f"{file}:Last"

    class Counting:
        """Remembers how many decisions it made, by the contract."""

        def choose(self, view: Any, memory: Any) -> Choice:
            count = 0 if memory is None else memory["count"]
            return Choice(first(view), memory={"count": count + 1}, details={"n": np.int64(count)})

    assert check_selector(Counting, missions=1).name == "Counting"
    assert check_selector(Counting(), missions=0).name == "Counting"


def test_what_is_worked_out_once_is_no_change() -> None:
    @dataclass(frozen=True)
    class Cached:
        weights: tuple[float, ...] = (1.0, 2.0)

        @cached_property
        def total(self) -> float:
            return sum(self.weights)

        def choose(self, view: Any, memory: Any) -> Choice:
            return Choice(first(view), reason=f"{self.total}")

    check_selector(Cached(), missions=0)


@pytest.mark.parametrize(("kind", "says"), MISTAKES, ids=[kind.__name__ for kind, _ in MISTAKES])
def test_each_mistake_is_named(kind: type, says: str) -> None:
    with pytest.raises(SelectorError, match=re.escape(says)) as caught:
        check_selector(kind)
    message = str(caught.value)
    assert kind.__name__ in message
    assert "\n" not in message
    assert message.count("SelectorError") == 0, "a mistake found in a mission is not wrapped"


def test_a_mistake_that_shows_late_is_found_in_a_mission() -> None:
    class Late:
        def choose(self, view: Any, memory: Any) -> Choice:
            if view.step > 30:
                raise KeyError("no such thing")
            return Choice(first(view))

    with pytest.raises(SelectorError, match=r"'Late' failed: KeyError.*in step \d+ of a mission"):
        check_selector(Late())


def test_a_class_that_needs_arguments_is_refused_clearly() -> None:
    class Needs:
        def __init__(self, weight: float) -> None:
            self.weight = weight

        def choose(self, view: Any, memory: Any) -> Choice:
            return Choice(first(view))

    with pytest.raises(SelectorError, match="give an instance"):
        check_selector(Needs)
    check_selector(Needs(2.0), missions=0)


def test_unknown_names_are_refused() -> None:
    with pytest.raises(SelectorError, match="did you mean 'nearest'"):
        check_selector("nearst")


def test_the_global_generators_are_left_as_they_were() -> None:
    random.seed(5)
    np.random.seed(5)  # noqa: NPY002
    expected = random.Random(5).random(), np.random.RandomState(5).random()
    check_selector("random", missions=1)
    assert (random.random(), np.random.random()) == expected  # noqa: NPY002


def test_situations_are_what_they_say() -> None:
    by_words = {s.words: s.view for s in situations(3)}
    assert len(by_words["a single frontier"].frontiers) == 1
    assert len(by_words["hundreds of frontiers"].frontiers) >= 300
    assert np.isinf(by_words["frontiers to which no route leads"].route_costs()).all()
    some = np.isinf(by_words["some frontiers to which no route leads"].route_costs())
    assert some.any()
    assert not some.all()
    assert len(by_words["no other teams"].others.leaders) == 0
    nan = by_words["other teams without destinations (NaN)"].others.destinations_m
    assert np.isnan(nan).all()
    assert by_words["a team of one"].members.tolist() == [0]
    edge = by_words["frontiers and the leader at the map's edge"]
    assert {0, edge.frame.rows - 1} <= set(edge.frontiers[:, 0].tolist())
    assert by_words["a team with a destination before"].previous is not None
    again = {s.words: s.view for s in situations(3)}
    for words, view in by_words.items():
        assert view.frontiers.tolist() == again[words].frontiers.tolist()


def test_small_worlds_differ_by_seed_alone() -> None:
    assert small_world(1).digest == small_world(1).digest
    assert small_world(1).digest != small_world(2).digest


def test_a_view_can_be_made_among_any_number_of_teams() -> None:
    labels = np.full((6, 40), FREE, dtype=np.uint8)
    labels[:, 0] = UNKNOWN
    teams = tuple(((5, 2 + k), None) for k in range(20))
    view = leader_view(labels, (2, 10), others=teams)
    assert len(view.others.leaders) == 20
    assert view.members.tolist() == [0]
