"""A model that chooses among the best candidates of a rule, and the random control for it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np

from swarmscout.destinations.asking import Talk
from swarmscout.destinations.llm.dialogue import Outcome, converse, question
from swarmscout.destinations.llm.features import FEATURES, columns_of
from swarmscout.destinations.llm.history import Remembered
from swarmscout.destinations.llm.llm import at_least, by_rule, one_of, rule_of, settled
from swarmscout.destinations.llm.prompt_data import Candidate, Encoded
from swarmscout.destinations.llm.prompts import Prompt, load_prompt
from swarmscout.destinations.llm.tables import number
from swarmscout.destinations.selector import Choice, Selector
from swarmscout.destinations.view import LeaderView

__all__ = ["LlmShortlist", "ShortlistRandom", "best_of"]

_WORDS = {
    "distance_m": "distance m",
    "way_m": "way m",
    "turn_deg": "turn °",
    "unknown_m2": "unexplored m2",
    "frontier_neighbours": "frontier cells beside it",
    "obstacle_neighbours": "obstacles beside it",
    "nearest_other_destination_m": "m to other teams' goals",
}
"""Names of features in prompts: short, since small models read slowly."""

_LETTERS = "ABCDEFGHIJKLMNOPQRSTUVWXYZ"


def best_of(rule: Selector, view: LeaderView, memory: Any, k: int, apart_m: float) -> list[Choice]:
    """A rule's choice, then its choice without that one and those near it, and so on.

    For a rule that scores frontiers one by one these are its k best at a distance from each other.

    Args:
        rule: the selector that ranks.
        view: the leader's.
        memory: the rule's memory.
        k: number of candidates.
        apart_m: smallest distance between two candidates, in metres.

    Returns:
        Up to k choices, the rule's own first.
    """
    found: list[Choice] = []
    left = view
    while len(found) < k:
        choice = rule.choose(left, memory)
        found.append(choice)
        row, col = choice.cell
        off = left.frontiers_m - np.array(view.frame.centre_of(int(row), int(col)))
        far = off[:, 0] ** 2 + off[:, 1] ** 2 >= max(apart_m, 1e-6) ** 2
        if not far.any():
            break
        left = left.among(far)
    return found


@dataclass(frozen=True)
class _Shortlist:
    rule: str = "multi-criteria"
    rule_parameters: Mapping[str, Any] = field(default_factory=dict)
    k: int = 5
    apart_m: float = 2.0
    warm_up_steps: int = 20

    def __post_init__(self) -> None:
        at_least("k", self.k, 1)
        if self.k > len(_LETTERS):
            raise ValueError(f"k = {self.k} must be at most {len(_LETTERS)}")
        at_least("warm_up_steps", self.warm_up_steps, 0)
        if not self.apart_m >= 0.0:
            raise ValueError(f"apart_m = {self.apart_m!r} must be at least 0")
        _ = self._rule  # Raises for a name that does not exist.

    @cached_property
    def _rule(self) -> Selector:
        return rule_of(self.rule, self.rule_parameters)

    def _shuffled(self, view: LeaderView, memory: Any) -> tuple[Choice, list[Choice]]:
        """The rule's own choice, and the shortlist in random order."""
        best = best_of(self._rule, view, memory, self.k, self.apart_m)
        return best[0], [best[k] for k in view.rng.permutation(len(best)).tolist()]


@dataclass(frozen=True)
class LlmShortlist(_Shortlist):
    """A language model chooses among the best candidates of a rule.

    They are shown in random order. During the warm-up, without a valid answer, and with a single
    candidate the rule decides. Comparing with the rule alone and with ``shortlist-random`` shows
    what the model adds.

    Attributes:
        rule: the selector that ranks; rule_parameters: its parameters.
        k: number of candidates.
        apart_m: smallest distance between two candidates, in metres: neighbouring cells differ
            little.
        warm_up_steps: until this step the rule decides.
        features: ``paper`` or ``full``.
        prompt: a template of the package, or a TOML file.
        answer_tokens: longest answer.
        retries: further questions after an invalid answer.
        history: number of the team's last decisions, with their outcomes, in the prompt.
    """

    features: str = "full"
    prompt: str = "shortlist"
    answer_tokens: int = 120
    retries: int = 5
    history: int = 0
    prompt_tokens: int = 2000

    def __post_init__(self) -> None:
        super().__post_init__()
        one_of("features", self.features, FEATURES)
        at_least("answer_tokens", self.answer_tokens, 10)
        at_least("retries", self.retries, 0)
        at_least("history", self.history, 0)
        _ = self._prompt

    @cached_property
    def _prompt(self) -> Prompt:
        return load_prompt(self.prompt)

    def choose(self, view: LeaderView, memory: Any) -> Choice:
        """The rule's choice, for when no model answers."""
        return by_rule(self._rule, view, memory, self.history)

    def converse(self, view: LeaderView, memory: Any) -> Talk:
        """See :class:`swarmscout.destinations.asking.AskingSelector`."""
        if view.step <= self.warm_up_steps:
            return by_rule(self._rule, view, memory, self.history, warm_up=True)
        kept = Remembered.of(memory)
        plain, shown = self._shuffled(view, kept.rule)
        if len(shown) == 1:
            return settled(view, plain, Outcome(None, "", ()), {"shown": 1}, kept, self.history)
        encoded = self._encoded(view, shown)
        outcome = yield from converse(
            view,
            encoded,
            self._prompt,
            question(view, encoded, self._prompt, kept.lines(view, self.history)),
            encoding="shortlist",
            brief=True,
            attempts=1 + self.retries,
            max_tokens=self.answer_tokens,
        )
        details: dict[str, Any] = {"shown": len(shown)}
        rule_memory = None
        if outcome.cell is not None:
            cells = [candidate.cell for candidate in encoded.candidates]
            place = cells.index(outcome.cell)
            details["place"] = place + 1
            details["rule_place"] = cells.index(_cell(plain)) + 1
            rule_memory = shown[place].memory
        return settled(view, plain, outcome, details, kept, self.history, rule_memory)

    def _encoded(self, view: LeaderView, shown: list[Choice]) -> Encoded:
        cells = [_cell(choice) for choice in shown]
        index = {(row, col): k for k, (row, col) in enumerate(view.frontiers.tolist())}
        picked = np.array([index[cell] for cell in cells], dtype=np.int64)
        columns = {name: c[picked] for name, c in columns_of(view, self.features).items()}
        names = list(_LETTERS[: len(cells)])
        if "way_m" in columns:
            del columns["distance_m"]
        kept = [name for name in _WORDS if name in columns]
        lines = [
            f"{name}: " + ", ".join(_short(key, columns[key][k]) for key in kept)
            for k, name in enumerate(names)
        ]
        return Encoded(
            f"Candidates ({', '.join(_WORDS[name] for name in kept)}):",
            "\n".join(lines),
            tuple(Candidate(name, cell) for name, cell in zip(names, cells, strict=True)),
            closed=True,
        )


@dataclass(frozen=True)
class ShortlistRandom(_Shortlist):
    """A random one of a rule's best candidates: the control for ``llm-shortlist``.

    Attributes:
        rule: the selector that ranks; rule_parameters: its parameters.
        k: number of candidates.
        apart_m: smallest distance between two candidates, in metres.
        warm_up_steps: until this step the rule decides.
    """

    def choose(self, view: LeaderView, memory: Any) -> Choice:
        """See :class:`swarmscout.destinations.selector.Selector`."""
        if view.step <= self.warm_up_steps:
            return self._rule.choose(view, memory)
        plain, shown = self._shuffled(view, memory)
        picked = shown[0]
        ranked = [_cell(choice) for choice in shown]
        return Choice(
            picked.cell,
            reason=f"one of {len(shown)} at random",
            memory=picked.memory,
            details={"shown": len(shown), "rule_place": ranked.index(_cell(plain)) + 1},
        )


def _short(name: str, value: float) -> str:
    """A feature for small models: metres with a decimal, the others as whole numbers."""
    return number(value if name in ("way_m", "distance_m") else np.round(value))


def _cell(choice: Choice) -> tuple[int, int]:
    return int(choice.cell[0]), int(choice.cell[1])
