"""The form in which a server takes requests, found out from what it refuses."""

from __future__ import annotations

import re
from copy import deepcopy
from dataclasses import dataclass, replace
from typing import Any

from swarmscout.core.language_model import Request
from swarmscout.llm.causes import is_too_long

__all__ = ["THINKING_TOKENS", "RequestForm"]

THINKING_TOKENS = 8000
"""Added to the longest answer of a model that thinks before it answers."""

_LESS_THINKING = {8000: 2500, 2500: 700}

# The schema as it is; without lengths; without what some servers do not know; any JSON; any text.
_FULL, _NO_LENGTHS, _BARE, _JSON, _TEXT = range(5)

_SCHEMA_WORDS = re.compile(
    r"response[_ ]?format|json[_ -]?(schema|object|mode)|schema|grammar|structured|guided|"
    r"maxlength|maxitems|additionalproperties|\bstrict\b"
)
_SYSTEM_WORDS = re.compile(
    r"system[ _'\"]*(role|message|prompt|instruction)|role[^a-z]{0,12}system|developer instruction|"
    r"roles must alternate|only user and assistant|must be (the )?(one of )?\W*user"
)
_LIMIT_WORDS = re.compile(r"max(_completion|_new|_output)?_tokens")
_LARGEST = re.compile(
    r"(?:at most|maximum(?: of| is)?|less than or equal to|up to|<=)\D{0,20}(\d{2,7})"
)
_ADAPTABLE = (400, 404, 415, 422, 500, 501)


@dataclass(frozen=True, slots=True)
class RequestForm:
    """A form of requests.

    Attributes:
        hosted: at OpenAI or Azure, which call the limit ``max_completion_tokens``.
        schema: how much of the answer's schema is sent, from 0 (all) to 4 (nothing).
        insists: never without a schema.
        temperature: of sampling; None: not sent.
        effort: of thinking; empty: not sent.
        limit: name of the limit of the answer's length; empty: not sent.
        swapped: whether both of its names have been tried.
        system: whether system messages are sent as such; else they begin the user's.
        thinking: tokens added for thinking.
        largest: the longest answer that the server allows.
    """

    hosted: bool = False
    schema: int = _FULL
    insists: bool = False
    temperature: float | None = 0.0
    effort: str = ""
    limit: str = "max_tokens"
    swapped: bool = False
    system: bool = True
    thinking: int = 0
    largest: int = 1_000_000

    @classmethod
    def first(
        cls, *, hosted: bool, structured: str, temperature: float, effort: str
    ) -> RequestForm:
        """The form to begin with."""
        start = _NO_LENGTHS if hosted else _FULL
        return cls(
            hosted=hosted,
            schema=_TEXT if structured == "off" else start,
            insists=structured == "schema",
            temperature=temperature,
            effort=effort,
            limit="max_completion_tokens" if hosted else "max_tokens",
        )

    def tokens(self, request: Request) -> int:
        """The limit of an answer's length."""
        return min(request.max_tokens + self.thinking, self.largest)

    def body(self, model: str, request: Request) -> dict[str, Any]:
        """A request's fields in this form."""
        body: dict[str, Any] = {"model": model, "messages": self._messages(request)}
        if self.limit:
            body[self.limit] = self.tokens(request)
        if self.temperature is not None:
            body["temperature"] = self.temperature
        if self.effort:
            body["reasoning_effort"] = self.effort
        if request.schema is not None and self.schema == _JSON:
            body["response_format"] = {"type": "json_object"}
        elif request.schema is not None and self.schema < _JSON:
            schema = deepcopy(dict(request.schema))
            if self.schema >= _NO_LENGTHS:
                _strip(schema, ("maxLength", "maxItems"))
            if self.schema >= _BARE:
                _strip(schema, ("additionalProperties",))
            strict = {} if self.schema >= _BARE else {"strict": True}
            body["response_format"] = {
                "type": "json_schema",
                "json_schema": {"name": "destination", **strict, "schema": schema},
            }
        return body

    def after(self, status: int, words: str, *, guess: bool) -> RequestForm | None:
        """The form to try after a refusal; None if the refusal is about something else.

        Args:
            status: of the refusal; words: all that it says, in lower case.
            guess: take it to be about the form even if its words do not say so.
        """
        asks_less = _LIMIT_WORDS.search(words) or is_too_long(status, words)
        if self.thinking and asks_less:
            return replace(self, thinking=_LESS_THINKING.get(self.thinking, 0))
        if status not in _ADAPTABLE or is_too_long(status, words):
            return None
        if self.effort and re.search(r"effort|reasoning", words):
            return replace(self, effort="")
        if self.temperature is not None and "temperature" in words:
            return replace(self, temperature=None)
        if self.limit and _LIMIT_WORDS.search(words):
            return self._other_limit(words)
        if self.system and _SYSTEM_WORDS.search(words):
            return replace(self, system=False)
        if _SCHEMA_WORDS.search(words):
            return self._less_schema(self.schema + 1)
        if guess and status in (400, 422):
            return self._guessed()
        return None

    def _less_schema(self, level: int) -> RequestForm | None:
        last = _BARE if self.insists else _TEXT
        return replace(self, schema=level) if level <= last else None

    def _guessed(self) -> RequestForm | None:
        if self.schema < _JSON and not self.insists:
            return replace(self, schema=_JSON)
        if self.schema == _JSON:
            return replace(self, schema=_TEXT)
        return replace(self, temperature=None) if self.temperature is not None else None

    def _other_limit(self, words: str) -> RequestForm | None:
        largest = _LARGEST.search(words)
        if largest and 10 <= int(largest.group(1)) < self.largest:
            return replace(self, largest=int(largest.group(1)))
        if self.swapped:
            return replace(self, limit="")
        other = "max_tokens" if self.limit == "max_completion_tokens" else "max_completion_tokens"
        return replace(self, limit=other, swapped=True)

    def _messages(self, request: Request) -> list[dict[str, str]]:
        messages = [{"role": m.role, "content": m.text} for m in request.messages]
        if self.system or len(messages) < 2 or messages[0]["role"] != "system":
            return messages
        first, second, *rest = messages
        return [{**second, "content": f"{first['content']}\n\n{second['content']}"}, *rest]


def _strip(schema: Any, keywords: tuple[str, ...]) -> None:
    """Take keywords out of a JSON schema, everywhere in it."""
    if isinstance(schema, dict):
        for keyword in keywords:
            if not isinstance(schema.get(keyword), dict):
                schema.pop(keyword, None)
        for inner in schema.values():
            _strip(inner, keywords)
    elif isinstance(schema, list):
        for inner in schema:
            _strip(inner, keywords)
