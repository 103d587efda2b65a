"""The interface to language models: a request goes out, a reply comes back.

Selectors that ask a model use these records alone. What answers (a provider over the network, a
cassette, a test) is passed to the mission; ``swarmscout.llm`` has the package's own.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Protocol, runtime_checkable

__all__ = ["FAILURES", "FINISHES", "Attempt", "Message", "Model", "Reply", "Request"]

FAILURES = (
    "timeout",
    "no connection",
    "rate limit",
    "server error",
    "unauthorized",
    "forbidden",
    "not found",
    "bad request",
    "too long",
    "malformed reply",
    "paused",
    "budget used up",
)
"""Why a request has no answer; with the last two it was not sent."""

FINISHES = ("stop", "length", "refusal", "filter")
"""How an answer ended: complete, cut off, refused by the model, stopped by the provider."""


@dataclass(frozen=True, slots=True)
class Message:
    """One message of a chat.

    Attributes:
        role: ``system``, ``user`` or ``assistant``.
        text: its content.
    """

    role: str
    text: str


@dataclass(frozen=True, slots=True)
class Request:
    """A question to a model.

    Attributes:
        messages: the chat so far.
        schema: JSON schema of the answer, for models that support one.
        attempt: 1 for the first question of a decision.
        max_tokens: longest answer.
        budget_s: time limit in seconds, retries included; it does not change the answer.
    """

    messages: tuple[Message, ...]
    schema: Mapping[str, Any] | None = None
    attempt: int = 1
    max_tokens: int = 1000
    budget_s: float = field(default=60.0, compare=False)


@dataclass(frozen=True, slots=True)
class Reply:
    """A model's reply.

    Attributes:
        text: the model's answer.
        finish: one of :data:`FINISHES`.
        failure: why there is no answer, one of :data:`FAILURES`; empty when there is one.
        note: details of a failure, or something to know about an answer, in one line.
        model: the model that answered.
        tokens_in, tokens_out: as counted by the server; None when it did not count.
        tries: how many times the request was sent.
        seconds: duration, waiting included.
        cost_usd: its price; None when no price is known.
    """

    text: str = ""
    finish: str = "stop"
    failure: str = ""
    note: str = ""
    model: str = ""
    tokens_in: int | None = None
    tokens_out: int | None = None
    tries: int = 1
    seconds: float = 0.0
    cost_usd: float | None = None


@dataclass(frozen=True, slots=True)
class Attempt:
    """One question to a model and its outcome, for the record.

    Attributes:
        number: 1 for the first of a decision.
        request: the question.
        reply: the reply.
        verdict: ``valid``, why the answer is invalid, or ``failed: …``.
        cell: the cell that a valid answer chose.
        reason: the model's own words.
        encoding: how the view was written down.
        prompt_version: of the template.
        candidates: how many could be chosen.
        dropped: how many cells were left out for the token budget.
    """

    number: int
    request: Request
    reply: Reply
    verdict: str
    cell: tuple[int, int] | None
    reason: str
    encoding: str
    prompt_version: str
    candidates: int
    dropped: int


@runtime_checkable
class Model(Protocol):
    """Answers requests. It is called from several threads at once.

    A model with a method ``close()`` is closed at the mission's end; requests that are still under
    way should then end within a second.

    Example:
        >>> class Parrot:
        ...     def complete(self, request: Request) -> Reply:
        ...         return Reply(text=request.messages[-1].text)
        >>> Parrot().complete(Request((Message("user", "hello"),))).text
        'hello'
    """

    def complete(self, request: Request) -> Reply:
        """Answer a request; a model that cannot answer says why in :attr:`Reply.failure`."""
        ...
