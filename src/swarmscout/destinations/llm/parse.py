"""Reading a model's answer: forgiving on its form, and never a guess.

What is read is one choice, in the model's words: an id or a coordinate. What it means is for
:mod:`swarmscout.destinations.llm.resolve`.
"""

from __future__ import annotations

import json
import re
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

__all__ = ["Answer", "InvalidAnswer", "read_answer"]

_REASONING = re.compile(r"<(think|thinking|reasoning|analysis)>.*?</\1>", re.DOTALL | re.IGNORECASE)
_OPEN_REASONING = re.compile(r"<(think|thinking|reasoning|analysis)>", re.IGNORECASE)
_CLOSED_BEFORE = re.compile(
    r"^.*?</(think|thinking|reasoning|analysis)>", re.DOTALL | re.IGNORECASE
)
_FENCE = re.compile(r"^[ \t]*```[\w-]*[ \t]*$|```(?:json)?", re.MULTILINE | re.IGNORECASE)
_PAIR = re.compile(
    r"^\W*?(?:x\s*[=:]\s*)?(-?\d+(?:\.0+)?)\s*[,;/ ]\s*(?:y\s*[=:]\s*)?(-?\d+(?:\.0+)?)\W*$"
)
_BARE = re.compile(r"^[\s\"'`*({\[<]*-?\d+(?:\.\d+)?[\s\"'`*)}\]>.]*$")
_ID = re.compile(
    r"^[\s\"'`*(\[<]*(?:(?:frontier|candidate|cluster|cell|id|option|choice)\b[\s:=#]*)?"
    r"([A-Za-z]|[A-Za-z]{1,2}\d{1,4})[\s\"'`*)\]>.]*$",
    re.IGNORECASE,
)
_LINE = re.compile(r"^\W*(?:final\s+)?(?:choice|answer|destination)\W*[:=]\s*(.+?)\s*$", re.I)
_REFUSAL = re.compile(
    r"\b(i'?m sorry|i am sorry|i cannot|i can'?t|i'?m unable|i am unable|as an ai)\b", re.IGNORECASE
)
_PLACEHOLDER = re.compile(r"^\s*<[^<>\d]*>\s*$")
_KEYS = ("choice", "chosen", "destination", "target", "selection", "answer", "cell", "id")
_CLOSERS = {"{": "}", "[": "]", "(": ")"}


class InvalidAnswer(Exception):
    """An answer cannot be used.

    Attributes:
        name: why, as it is counted.
        told: the same for the model, so that it can do better.
    """

    def __init__(self, name: str, told: str) -> None:
        super().__init__(told)
        self.name = name
        self.told = told


@dataclass(frozen=True, slots=True)
class Answer:
    """One choice, as read.

    Attributes:
        point: ``(x, y)`` when a coordinate was named, else None.
        id: the id that was named otherwise.
        reason: the model's own words.
    """

    point: tuple[int, int] | None
    id: str = ""
    reason: str = ""


def read_answer(text: str, finish: str = "stop") -> Answer:
    """Read the one choice in a text.

    Args:
        text: all that the model said.
        finish: how it ended, see :class:`swarmscout.core.language_model.Reply`.

    Raises:
        InvalidAnswer: there is none, more than one, or no telling.
    """
    if finish in ("refusal", "filter"):
        raise InvalidAnswer("refusal", "it was a refusal")
    if finish == "length":
        raise InvalidAnswer("cut off", "it was cut off before its end; be brief")
    plain = _FENCE.sub("\n", _without_reasoning(text)).strip()
    if not plain:
        raise InvalidAnswer("empty", "it was empty")
    if _names_a_choice(plain):
        return _choice_of(plain, "")
    found: dict[tuple[tuple[int, int] | None, str], Answer] = {}
    objects = 0
    for data in _objects(plain):
        objects += 1
        for answer in _choices_in(data):
            found.setdefault((answer.point, answer.id.casefold()), answer)
    if len(found) > 1:
        raise InvalidAnswer("several answers", "it names more than one choice")
    if found:
        return next(iter(found.values()))
    if objects:
        raise InvalidAnswer("no choice", 'its JSON has no "choice"')
    lines = [match.group(1) for line in plain.splitlines() if (match := _LINE.match(line))]
    if lines:
        answers = {(a.point, a.id.casefold()): a for a in (_choice_of(line, "") for line in lines)}
        if len(answers) > 1:
            raise InvalidAnswer("several answers", "it names more than one choice")
        return next(iter(answers.values()))
    if _BARE.match(plain):
        raise InvalidAnswer("bare number", "it is a number, not a coordinate x,y or an id")
    if _REFUSAL.search(plain):
        raise InvalidAnswer("refusal", "it was a refusal")
    raise InvalidAnswer("no answer", "it holds no JSON object")


def _without_reasoning(text: str) -> str:
    plain = _REASONING.sub("", text)
    # Some servers leave the opening tag out.
    plain = _CLOSED_BEFORE.sub("", plain)
    if _OPEN_REASONING.search(plain):
        raise InvalidAnswer("cut off", "it was cut off while reasoning; be brief")
    return plain


def _names_a_choice(text: str) -> bool:
    return "\n" not in text.strip() and bool(_PAIR.match(text) or _ID.match(text))


def _objects(text: str) -> Iterator[dict[str, Any]]:
    """JSON objects in a text, from outside; their brackets may be swapped.

    Raises:
        InvalidAnswer: an object is not closed, or is no JSON even with brackets put right.
    """
    at = text.find("{")
    broken = None
    while at >= 0:
        span, repaired = _balanced(text, at)
        if span is None:
            if '"' not in text[at:]:
                break  # A brace in prose.
            raise InvalidAnswer("cut off", "it was cut off before its end; be brief")
        data = _loaded(text[at:span]) or _loaded(repaired)
        if data is not None:
            yield data
        elif '"' in repaired or ":" in repaired:
            broken = repaired
        at = text.find("{", span)
    if broken is not None:
        raise InvalidAnswer("malformed JSON", "its JSON cannot be read")


def _balanced(text: str, start: int) -> tuple[int | None, str]:
    """Where the bracket at a place is closed, and what is between with brackets put right."""
    stack: list[str] = []
    out: list[str] = []
    quoted = escaped = False
    for at in range(start, len(text)):
        sign = text[at]
        if quoted:
            quoted = escaped or sign != '"'
            escaped = sign == "\\" and not escaped
        elif sign == '"':
            quoted = True
        elif sign in "{[(":
            stack.append("[" if sign == "(" else sign)
            sign = stack[-1]
        elif sign in "}])":
            sign = _CLOSERS[stack.pop()]
            while out and out[-1].isspace():
                out.pop()
            if out and out[-1] == ",":
                out.pop()
        out.append(sign)
        if not stack:
            return at + 1, "".join(out)
    return None, "".join(out)


def _loaded(text: str) -> dict[str, Any] | None:
    try:
        data = json.loads(text, object_pairs_hook=_keeping_all)
    except (ValueError, RecursionError):
        return None
    return data if isinstance(data, dict) else None


def _keeping_all(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    """A JSON object as a dict; values of a key that comes twice stand together in a _Several."""
    data: dict[str, Any] = {}
    for key, value in pairs:
        if key in data and data[key] != value:
            value = _Several((data[key], value))
        data[key] = value
    return data


class _Several(tuple[Any, ...]):
    """Values of one key that came more than once."""


def _choices_in(data: dict[str, Any]) -> list[Answer]:
    lowered = {str(key).strip().casefold(): value for key, value in data.items()}
    key = next((key for key in _KEYS if key in lowered), None)
    if key is None:
        if {"x", "y"} <= lowered.keys():
            return [_choice_of(lowered, _reason(lowered))]
        return []
    if key != "choice" and sum(other in lowered for other in _KEYS) > 1:
        raise InvalidAnswer("several answers", 'it names more than one choice; use "choice"')
    return [_choice_of(lowered[key], _reason(lowered))]


def _reason(data: dict[str, Any]) -> str:
    reason = data.get("reason", data.get("why", ""))
    return " ".join(str(reason).split()) if isinstance(reason, str) else ""


def _choice_of(value: Any, reason: str) -> Answer:
    if isinstance(value, _Several):
        raise InvalidAnswer("several answers", "it names more than one choice")
    if isinstance(value, str):
        return _from_text(value, reason)
    if isinstance(value, dict):
        lowered = {str(key).strip().casefold(): inner for key, inner in value.items()}
        if {"x", "y"} <= lowered.keys():
            return _from_numbers([lowered["x"], lowered["y"]], reason)
        for key in ("id", "cell", "coordinate"):
            if key in lowered:
                return _choice_of(lowered[key], reason)
        raise InvalidAnswer("no choice", "its choice is no frontier")
    if isinstance(value, list):
        if len(value) == 1 and isinstance(value[0], str | list | dict):
            return _choice_of(value[0], reason)
        return _from_numbers(value, reason)
    if isinstance(value, int | float) and not isinstance(value, bool):
        raise InvalidAnswer("bare number", "its choice is a number, not a coordinate x,y or an id")
    raise InvalidAnswer("no choice", "it names no choice")


def _from_text(value: str, reason: str) -> Answer:
    if not value.strip():
        raise InvalidAnswer("no choice", "its choice is empty")
    if _PLACEHOLDER.match(value):
        raise InvalidAnswer("placeholder", f"{value.strip()} stands for a frontier; name one")
    pair = _PAIR.match(value)
    if pair:
        return Answer((int(float(pair.group(1))), int(float(pair.group(2)))), reason=reason)
    if _BARE.match(value):
        raise InvalidAnswer("bare number", "its choice is a number, not a coordinate x,y or an id")
    named = _ID.match(value)
    if named:
        return Answer(None, named.group(1).upper(), reason)
    if len(re.findall(r"-?\d+\s*[,;]\s*-?\d+", value)) > 1:
        raise InvalidAnswer("several answers", "its choice names more than one frontier")
    raise InvalidAnswer("no choice", "its choice is neither a coordinate x,y nor an id")


def _from_numbers(values: list[Any], reason: str) -> Answer:
    if values and all(isinstance(v, list | dict) for v in values):
        raise InvalidAnswer("several answers", "its choice names more than one frontier")
    if values and all(isinstance(v, str) for v in values):
        if len(values) == 2 and all(re.fullmatch(r"\s*-?\d+\s*", v) for v in values):
            return Answer((int(values[0]), int(values[1])), reason=reason)
        raise InvalidAnswer("several answers", "its choice names more than one frontier")
    numbers = [v for v in values if isinstance(v, int | float) and not isinstance(v, bool)]
    if len(values) == 2 and len(numbers) == 2 and all(float(v).is_integer() for v in numbers):
        return Answer((int(numbers[0]), int(numbers[1])), reason=reason)
    if len(values) == 1 and len(numbers) == 1:
        raise InvalidAnswer("bare number", "its choice is a number, not a coordinate x,y or an id")
    raise InvalidAnswer("no choice", "its choice is no coordinate x,y of a cell")
