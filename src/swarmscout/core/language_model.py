"""The one seam to language models: a request goes out, a reply comes back.

Rules that ask a model know nothing but these records. Who answers (a provider over the network, a
cassette, a test) is handed to the mission; ``swarmscout.llm`` has those that come with the package.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Protocol, runtime_checkable

__all__ = ["FAILURES", "Attempt", "Message", "Model", "Reply", "Request"]

FAILURES = (
    "timeout",
    "no connection",
    "rate limit",
    "server error",
    "unauthorized",
    "not found",
    "bad request",
    "too long",
    "malformed reply",
    "paused",
    "budget used up",
)
"""Why a request has no answer; after the last two it was not even sent."""


@dataclass(frozen=True, slots=True)
class Message:
    """One message of a chat.

    Attributes:
        role: ``system``, ``user`` or ``assistant``.
        text: what is said.
    """

    role: str
    text: str


@dataclass(frozen=True, slots=True)
class Request:
    """What a model is asked.

    Attributes:
        messages: the chat so far.
        schema: JSON schema of the answer, for models that can be held to one.
        attempt: 1 for the first question of a decision.
        max_tokens: longest answer.
        budget_s: how long an answer may take, retries included; it changes no answer.
    """

    messages: tuple[Message, ...]
    schema: Mapping[str, Any] | None = None
    attempt: int = 1
    max_tokens: int = 1000
    budget_s: float = field(default=60.0, compare=False)


@dataclass(frozen=True, slots=True)
class Reply:
    """What came back.

    Attributes:
        text: the model's answer.
        finish: ``stop``, ``length`` (cut off), ``refusal`` or ``filter``.
        failure: why there is no answer, one of :data:`FAILURES`; empty when there is one.
        note: more about a failure, in a few words.
        model: which model answered.
        tokens_in, tokens_out: as the server counted; None when it did not say.
        tries: how often the request was sent.
        seconds: how long it took, waiting included.
        cost_usd: what it cost; None when no price is known.
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
    """One question to a model and what became of it, for the record.

    Attributes:
        number: 1 for the first of a decision.
        request: what was asked.
        reply: what came back.
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

    Example:
        >>> class Parrot:
        ...     def complete(self, request: Request) -> Reply:
        ...         return Reply(text=request.messages[-1].text)
        >>> Parrot().complete(Request((Message("user", "hello"),))).text
        'hello'
    """

    def complete(self, request: Request) -> Reply:
        """Answer a request; a model that cannot says so in :attr:`Reply.failure`."""
        ...
