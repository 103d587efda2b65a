"""Selectors that ask a language model, for all leaders of a step at the same time.

Such a selector is a generator: it yields requests, is sent replies, and returns its choice. It uses
neither network nor files nor clock. Its driver may ask for many leaders at once and processes the
answers in the order of robots.
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
"""Asks for several robots of one step at the same time: (step, [(robot, request), …]) → replies."""


@runtime_checkable
class AskingSelector(Selector, Protocol):
    """A selector that asks a model; without one, :meth:`choose` decides."""

    prompt_tokens: int
    """Longest prompt, in estimated tokens."""

    def converse(self, view: LeaderView, memory: Any) -> Talk:
        """Begin a conversation about a leader's next destination.

        Args:
            view: what the leader knows.
            memory: that of this robot's last :class:`Choice`; None at first.
        """
        ...


def settle(talks: Sequence[tuple[int, Talk]], ask: Ask, step: int) -> list[Choice]:
    """Drive conversations to their ends, in rounds: all questions, then all answers.

    Args:
        talks: robots with their conversations, in the order of robots.
        ask: answers a round of questions.
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
    """Counts of conversations and their results."""

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
        """The counts, for the summary."""
        return {
            "decisions": self._decisions,
            "asked": self._asked,
            "by_model": self._asked - self._fallbacks.total(),
            "attempts": self._attempts,
            "asked_again": self._retries,
            "invalid": dict(sorted(self._invalid.items())),
            "fallbacks": dict(sorted(self._fallbacks.items())),
        }
