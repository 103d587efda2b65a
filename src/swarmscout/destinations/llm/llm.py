"""The paper's selector: a language model chooses among the frontiers of the leader's map."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np

from swarmscout.core.errors import did_you_mean
from swarmscout.destinations.asking import Talk
from swarmscout.destinations.llm.dialogue import Outcome, converse, question
from swarmscout.destinations.llm.encodings import ENCODINGS
from swarmscout.destinations.llm.features import FEATURES
from swarmscout.destinations.llm.history import Remembered
from swarmscout.destinations.llm.prompts import Prompt, load_prompt
from swarmscout.destinations.selector import Choice, Selector
from swarmscout.destinations.view import LeaderView

__all__ = ["Llm", "at_least", "by_rule", "one_of", "rule_of", "settled"]


def rule_of(name: str, parameters: Mapping[str, Any] | None = None) -> Selector:
    """The selector that decides without a model."""
    # The registry imports this module, so it is imported here when a rule is made.
    from swarmscout.destinations.registry import make_selector

    return make_selector(name, parameters)


def one_of(name: str, value: str, known: Any) -> None:
    """Check a parameter that is one of several words.

    Raises:
        ValueError: it is not a known one.
    """
    if value not in known:
        raise ValueError(f"{name} = '{value}' is unknown: {did_you_mean(value, known)}")


def at_least(name: str, value: int, least: int) -> None:
    """Check a parameter that is a whole number.

    Raises:
        ValueError: it is smaller, or not a whole number.
    """
    if isinstance(value, bool) or not isinstance(value, int) or value < least:
        raise ValueError(f"{name} = {value!r} must be a whole number of at least {least}")


@dataclass(frozen=True)
class Llm:
    """A language model chooses a frontier of the leader's map (the paper's method).

    During the warm-up, without a valid answer, and with a single candidate the baseline decides. It
    draws its random numbers before the model is asked, so that a mission whose model never answers
    equals the baseline's.

    Attributes:
        encoding: how the view is written down: ``cells`` (the paper's), ``rows``, ``frontiers``,
            ``clusters`` or ``ascii``.
        features: of frontiers in tables: ``paper``, or ``full`` (ways, turns, unknown area, …).
        prompt: a template of the package, or a TOML file.
        prompt_tokens: longest prompt; beyond it the least informative cells are left out.
        answer_tokens: longest answer.
        warm_up_steps: until this step the baseline decides.
        retries: further questions after an invalid answer.
        baseline: a selector's name; baseline_parameters: its parameters.
        history: number of the team's last decisions, with their outcomes, in the prompt.
        shuffle: show tables of candidates in random order instead of the map's.

    Source: paper, "LLM-based team destination determination" and "Setup".
    """

    encoding: str = "cells"
    features: str = "paper"
    prompt: str = "paper"
    prompt_tokens: int = 100_000
    answer_tokens: int = 1200
    warm_up_steps: int = 20
    retries: int = 5
    baseline: str = "quantile"
    baseline_parameters: Mapping[str, Any] = field(default_factory=dict)
    history: int = 0
    shuffle: bool = False

    def __post_init__(self) -> None:
        one_of("encoding", self.encoding, ENCODINGS)
        one_of("features", self.features, FEATURES)
        at_least("prompt_tokens", self.prompt_tokens, 200)
        at_least("answer_tokens", self.answer_tokens, 10)
        for name in ("warm_up_steps", "retries", "history"):
            at_least(name, getattr(self, name), 0)
        # Both raise for a name that does not exist.
        _ = self._rule, self._prompt

    @cached_property
    def _rule(self) -> Selector:
        return rule_of(self.baseline, self.baseline_parameters)

    @cached_property
    def _prompt(self) -> Prompt:
        return load_prompt(self.prompt)

    def choose(self, view: LeaderView, memory: Any) -> Choice:
        """The baseline's choice, for when no model answers."""
        return by_rule(self._rule, view, memory, self.history)

    def converse(self, view: LeaderView, memory: Any) -> Talk:
        """See :class:`swarmscout.destinations.asking.AskingSelector`."""
        if view.step <= self.warm_up_steps:
            return by_rule(self._rule, view, memory, self.history, warm_up=True)
        kept = Remembered.of(memory)
        plain = self._rule.choose(view, kept.rule)
        frontiers = len(view.frontiers)
        order = view.rng.permutation(frontiers) if self.shuffle else np.arange(frontiers)
        encode = ENCODINGS[self.encoding]
        encoded = encode(view, self.prompt_tokens, order, self.features)
        if len(encoded.candidates) == 1:
            return settled(view, plain, Outcome(None, "", ()), {"shown": 1}, kept, self.history)
        messages = question(view, encoded, self._prompt, kept.lines(view, self.history))
        outcome = yield from converse(
            view,
            encoded,
            self._prompt,
            messages,
            encoding=self.encoding,
            brief=False,
            attempts=1 + self.retries,
            max_tokens=self.answer_tokens,
        )
        cells = [candidate.cell for candidate in encoded.candidates]
        details = {"shown": len(cells)}
        if outcome.cell in cells:
            details["place"] = cells.index(outcome.cell) + 1
        return settled(view, plain, outcome, details, kept, self.history)


def by_rule(
    rule: Selector, view: LeaderView, memory: Any, history: int, *, warm_up: bool = False
) -> Choice:
    """The choice of the rule behind a language model, when the model is not asked.

    Args:
        rule: the selector that decides.
        view: what the leader knows.
        memory: as the mission passes it.
        history: number of decisions to remember.
        warm_up: whether it is too early to ask, for the record.
    """
    kept = Remembered.of(memory)
    details = {"warm_up": True} if warm_up else {}
    plain = rule.choose(view, kept.rule)
    return settled(view, plain, Outcome(None, "", ()), details, kept, history)


def settled(
    view: LeaderView,
    plain: Choice,
    outcome: Outcome,
    details: Mapping[str, Any],
    kept: Remembered,
    history: int,
    rule_memory: Any = None,
) -> Choice:
    """The choice after a conversation: the model's, or else the rule's.

    Args:
        view: what the leader knows.
        plain: the rule's choice.
        outcome: of the conversation.
        details: for the record.
        kept: the memory so far; history: number of decisions to remember.
        rule_memory: the rule's memory after the model's choice; None: as after its own.
    """
    record = dict(details)
    if outcome.cell is None:
        if outcome.fallback:
            record["fallback"] = outcome.fallback
        record.update(plain.details)
        memory = kept.after(view, plain.memory, plain.cell, plain.reason, history)
        return Choice(plain.cell, plain.reason, memory, record, outcome.attempts)
    rule = plain.memory if rule_memory is None else rule_memory
    memory = kept.after(view, rule, outcome.cell, outcome.reason, history)
    return Choice(outcome.cell, outcome.reason, memory, record, outcome.attempts)
