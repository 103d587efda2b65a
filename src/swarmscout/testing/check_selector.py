"""A conformance check for selectors: run it in the tests of your own rule.

It tries a selector in the situations of :mod:`swarmscout.testing.situations` and in short missions,
and says in one error which part of the contract of
:class:`swarmscout.destinations.selector.Selector` is broken, and how.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from swarmscout.core.errors import SelectorError
from swarmscout.destinations.registry import SELECTORS
from swarmscout.destinations.selector import Choice, Selector
from swarmscout.destinations.view import LeaderView
from swarmscout.mission.mission import Mission
from swarmscout.mission.scenario import Scenario
from swarmscout.testing.fingerprints import fingerprint
from swarmscout.testing.harness import how_it_went, instance_of, report_text
from swarmscout.testing.instrumented_view import asked, checked_answer
from swarmscout.testing.situations import situations
from swarmscout.testing.small_worlds import small_world

__all__ = ["SelectorReport", "check_selector"]

CHECKS = (
    "has choose(view, memory)",
    "returns a Choice with a frontier cell of its view, in whole numbers",
    "reason is text, details are plain data",
    "changes neither its view nor the memory it is handed, nor itself",
    "reads nothing private of its view",
    "neither draws from nor depends on the global generators of random and numpy.random",
    "gives the same answer to the same view and memory",
)


@dataclass(frozen=True, slots=True)
class SelectorReport:
    """What was checked, and held.

    Attributes:
        name: the selector's.
        checks: one line for each part of the contract.
        situations: in words, what the selector was confronted with.
        decisions: how many it made in all.
    """

    name: str
    checks: tuple[str, ...]
    situations: tuple[str, ...]
    decisions: int

    def __str__(self) -> str:
        """All of it as text."""
        sound = f"selector '{self.name}' is sound ({self.decisions} decisions)"
        return report_text(sound, self.checks, self.situations)


def check_selector(selector: Any, *, missions: int = 2, seed: int = 0) -> SelectorReport:
    """Check that a selector keeps to its contract.

    Args:
        selector: an instance, a class that needs no arguments, a registered name, or
            ``path/to/file.py:ClassName``.
        missions: so many short missions in small caves are run to their end (each twice).
        seed: makes the situations and the caves.

    Returns:
        What was checked; print it if you like.

    Raises:
        SelectorError: which rule was broken, in which situation.

    Example:
        >>> from swarmscout.destinations.nearest import Nearest
        >>> check_selector(Nearest()).checks[0]
        'has choose(view, memory)'
    """
    rule, name = instance_of(SELECTORS, selector)
    guard = _Guard(rule, name)
    tried = []
    for situation in situations(seed):
        guard.where = f"with {situation.words}"
        first = guard.choose(situation.view, None)
        # Once more, with what it remembers of another place.
        guard.choose(situation.view, first.memory)
        tried.append(situation.words)
    guard.where = ""
    for k in range(missions):
        guarded = _mission(guard, name, seed + k)
        alone = _mission(rule, name, seed + k)
        if guarded != alone:
            raise SelectorError(
                f"selector '{name}' is not deterministic: the same mission in "
                f"small_world({seed + k}) went differently when it was run again"
            )
    if missions:
        tried.append(f"{missions} missions in small caves, to the end, each twice")
    return SelectorReport(name, CHECKS, tuple(tried), guard.decisions)


class _Guard:
    """A selector that asks another one, several times, and checks each answer."""

    def __init__(self, rule: Selector, name: str) -> None:
        self.rule = rule
        self.name = name
        self.where = ""
        self.decisions = 0

    def choose(self, view: LeaderView, memory: Any) -> Choice:
        """What the rule answers, if it keeps to the contract."""
        self.decisions += 1
        where = self.where or f"in step {view.step} of a mission"
        try:
            return self._checked(view, memory)
        except SelectorError as error:
            raise SelectorError(f"selector '{self.name}' {error} ({where})") from error.__cause__

    def _checked(self, view: LeaderView, memory: Any) -> Choice:
        choice = checked_answer(asked(self.rule, view, memory, globals_seed=1), view)
        told = fingerprint(choice)
        if fingerprint(asked(self.rule, view, memory, globals_seed=1)) != told:
            raise SelectorError(
                "is not deterministic: it gave two different answers to the same view and memory; "
                "draw from view.rng (or view.character), and remember through Choice.memory"
            )
        if fingerprint(asked(self.rule, view, memory, globals_seed=2)) != told:
            raise SelectorError(
                "depends on global randomness: its answer changes with the seed of random or "
                "numpy.random; draw from view.rng"
            )
        return choice


def _mission(rule: Selector, name: str, seed: int) -> tuple[Any, ...]:
    """Run a short mission with a rule to its end; how it went."""
    # Little charge at the start, so that teams lose members and leaders within the mission.
    scenario = Scenario.model_validate(
        {
            "robots": 8,
            "steps": 80,
            "seed": seed,
            "destinations": "nearest",
            "battery": {"capacity_steps": 120, "start_min": 0.3},
        }
    )
    mission = Mission(scenario, world=small_world(seed))
    mission.destinations.selector = rule
    mission.destinations.name = name
    return how_it_went(SELECTORS, mission, guarded=True)
