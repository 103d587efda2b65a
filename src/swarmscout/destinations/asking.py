"""Selectors that ask a language model: all leaders of a step at the same time.

Such a selector is a conversation: it yields requests, is sent replies, and returns its choice. So
it stays as pure as any rule: no network, no file, no clock. Whoever drives it may ask for many
leaders at once and takes the answers in the order of robots.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Generator, Sequence
from typing import Any, Protocol, runtime_checkable

from swarmscout.core.language_model import Reply, Request
from swarmscout.destinations.selector import Choice, Selector
from swarmscout.destinations.view import LeaderView

__all__ = ["Ask", "AskingSelector", "Talk", "TalkCounts", "settle"]

Talk = Generator[Request, Reply, Choice]
"""Yields requests, is sent replies, returns a choice."""

Ask = Callable[[int, Sequence[tuple[int, Request]]], list[Reply]]
"""Asks in one step for several robots at the same time: (step, [(robot, request), …]) → replies."""


@runtime_checkable
class AskingSelector(Selector, Protocol):
    """A selector that asks a model; without one, :meth:`choose` decides as if none answered."""

    prompt_tokens: int
    """About how long its prompts may get."""

    def converse(self, view: LeaderView, memory: Any) -> Talk:
        """Begin a conversation about a leader's next destination.

        Args:
            view: what the leader knows.
            memory: what the last :class:`Choice` of this robot carried, at first None.
        """
        ...


def settle(talks: Sequence[tuple[int, Talk]], ask: Ask, step: int) -> list[Choice]:
    """Drive conversations to their ends, in rounds: everybody's question, then everybody's answer.

    Args:
        talks: a robot and its conversation each, in robot order.
        ask: who answers.
        step: the current step.

    Returns:
        Their choices, in the same order.
    """
    choices: dict[int, Choice] = {}
    questions: dict[int, Request] = {}

    def go_on(k: int, reply: Reply | None) -> None:
        try:
            talk = talks[k][1]
            questions[k] = next(talk) if reply is None else talk.send(reply)
        except StopIteration as end:
            choices[k] = end.value

    for k in range(len(talks)):
        go_on(k, None)
    while questions:
        asked = sorted(questions)
        replies = ask(step, [(talks[k][0], questions.pop(k)) for k in asked])
        for k, reply in zip(asked, replies, strict=True):
            go_on(k, reply)
    return [choices[k] for k in range(len(talks))]


class TalkCounts:
    """Counts what conversations came to."""

    def __init__(self) -> None:
        self._decisions = self._asked = self._attempts = self._retries = 0
        self._invalid: Counter[str] = Counter()
        self._fallbacks: Counter[str] = Counter()

    def add(self, choice: Choice) -> None:
        """Count one choice."""
        self._decisions += 1
        fallback = choice.details.get("fallback", "")
        self._asked += bool(choice.attempts) or bool(fallback)
        self._attempts += len(choice.attempts)
        self._retries += max(0, len(choice.attempts) - 1)
        for attempt in choice.attempts:
            if attempt.verdict != "valid" and not attempt.reply.failure:
                self._invalid[attempt.verdict] += 1
        if fallback:
            self._fallbacks[str(fallback)] += 1

    def figures(self) -> dict[str, Any]:
        """Plain figures for the summary."""
        return {
            "decisions": self._decisions,
            "asked": self._asked,
            "by_model": self._asked - self._fallbacks.total(),
            "attempts": self._attempts,
            "asked_again": self._retries,
            "invalid": dict(sorted(self._invalid.items())),
            "fallbacks": dict(sorted(self._fallbacks.items())),
        }
