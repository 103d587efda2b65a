"""One choice: a coordinate or an id, as a text, a number or an object."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Any

from swarmscout.destinations.llm.answer_json import Several
from swarmscout.destinations.llm.answer_text import plain_signs

__all__ = [
    "ANY_PAIR",
    "LONGEST",
    "NUMBER",
    "Answer",
    "InvalidAnswer",
    "choice_of",
    "from_text",
    "named",
]

LONGEST = 300
"""Longest text that is read as a choice, so that no pattern below meets a long one."""

_OPEN = r"[\s\"'`*_(\[{<#$\\]{0,12}"
_CLOSE = r"[\s\"'`*_)\]}>$\\.,;!]{0,12}"
_KINDS = r"(?:the|frontier|candidate|cluster|group|cell|id|option|choice|number)"
_KIND = rf"(?:{_KINDS}\b[\s:=#]{{0,4}}){{0,3}}"
_REMARK = r"(?:[\s*]{0,4}(?:\(.{1,200}\)|(?:[:–—]|-\s|,?\s{0,4}(?:because|since|as)\b).{0,200}))?"
_WHOLE = r"([-+]?\d{1,9}(?:\.0{1,9})?)"
_PAIR = re.compile(
    rf"^{_OPEN}{_KIND}{_OPEN}(?:x\s?[=:]?\s?)?{_WHOLE}\s{{0,4}}[,;/ ]\s{{0,4}}"
    rf"(?:y\s?[=:]?\s?)?{_WHOLE}(?!\.?\d){_CLOSE}(?P<remark>{_REMARK}){_CLOSE}$",
    re.IGNORECASE | re.DOTALL,
)
_ID = re.compile(
    rf"^{_OPEN}{_KIND}{_OPEN}([A-Za-z]|[A-Za-z]{{1,2}}\d{{1,4}})(?![\w']){_CLOSE}"
    rf"(?P<remark>{_REMARK}){_CLOSE}$",
    re.IGNORECASE | re.DOTALL,
)
NUMBER = re.compile(r"^[\s\"'`*({\[<]*-?\d+(?:\.\d+)?[\s\"'`*)}\]>.]*$")
"""A number alone, perhaps in quotes or brackets."""

_DOUBT = re.compile(
    r"\b(or|not|never|no|avoid|wrong|bad|blocked|taken|except|unless|maybe|instead|rather|versus|vs|"
    r"both|either|neither|none)\b|\?",
    re.IGNORECASE,
)
ANY_PAIR = re.compile(r"-?\d{1,9}\s?[,;]\s?-?\d{1,9}")
"""Two whole numbers, anywhere in a text."""

_PLACEHOLDER = re.compile(r"^\s*<[^<>\d]*>\s*$")


class InvalidAnswer(Exception):
    """An answer cannot be used.

    Attributes:
        name: the reason, as it is counted.
        problem: the same for the model, so that it can answer better.
    """

    def __init__(self, name: str, problem: str) -> None:
        super().__init__(problem)
        self.name = name
        self.problem = problem


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


def choice_of(value: Any, reason: str) -> Answer:
    """The choice that a JSON value is.

    Raises:
        InvalidAnswer: it is none, or several.
    """
    if isinstance(value, Several):
        raise InvalidAnswer("several answers", "it names more than one choice")
    if isinstance(value, str):
        return from_text(value, reason)
    if isinstance(value, dict):
        lowered = {str(key).strip().casefold(): inner for key, inner in value.items()}
        if {"x", "y"} <= lowered.keys():
            return _from_numbers([lowered["x"], lowered["y"]], reason)
        for key in ("id", "cell", "coordinate", "coordinates", "frontier"):
            if key in lowered and not isinstance(lowered[key], dict):
                return choice_of(lowered[key], reason)
        raise InvalidAnswer("no choice", "its choice is not a frontier")
    if isinstance(value, list):
        if len(value) == 1 and isinstance(value[0], str):
            return from_text(value[0], reason)
        if len(value) == 1 and isinstance(value[0], list | dict):
            return choice_of(value[0], reason) if _flat(value[0]) else choice_of(None, reason)
        return _from_numbers(value, reason)
    if isinstance(value, int | float) and not isinstance(value, bool):
        raise InvalidAnswer("bare number", "its choice is a number, not a coordinate x,y or an id")
    raise InvalidAnswer("no choice", "it names no choice")


def _flat(value: Any) -> bool:
    inner = value.values() if isinstance(value, dict) else value
    return not any(isinstance(one, list | dict) for one in inner)


def named(value: str, reason: str) -> Answer | None:
    """The coordinate or id that a short text is; None if it is something else."""
    plain = plain_signs(value)
    pair, named = _PAIR.match(plain), _ID.match(plain)
    for match in (pair, named):
        if match is not None and _DOUBT.search(match.group("remark") or ""):
            return None
    if pair is not None:
        return Answer((int(float(pair.group(1))), int(float(pair.group(2)))), reason=reason)
    return Answer(None, named.group(1).upper(), reason) if named is not None else None


def from_text(value: str, reason: str) -> Answer:
    """The choice that a text is.

    Raises:
        InvalidAnswer: it is none, or several.
    """
    if not value.strip():
        raise InvalidAnswer("no choice", "its choice is empty")
    if len(value.strip()) > LONGEST:
        raise InvalidAnswer("no choice", "its choice is neither a coordinate x,y nor an id")
    value = value.strip()
    if _PLACEHOLDER.match(value):
        raise InvalidAnswer("placeholder", f"{value} stands for a frontier; name one")
    found = named(value, reason)
    if found is not None:
        return found
    if NUMBER.match(value):
        raise InvalidAnswer("bare number", "its choice is a number, not a coordinate x,y or an id")
    if len(ANY_PAIR.findall(value)) > 1:
        raise InvalidAnswer("several answers", "its choice names more than one frontier")
    raise InvalidAnswer("no choice", "its choice is neither a coordinate x,y nor an id")


def _from_numbers(values: list[Any], reason: str) -> Answer:
    if values and all(isinstance(v, list | dict) for v in values):
        raise InvalidAnswer("several answers", "its choice names more than one frontier")
    if values and all(isinstance(v, str) for v in values):
        if len(values) == 2 and all(re.fullmatch(r"\s{0,9}-?\d{1,9}\s{0,9}", v) for v in values):
            return Answer((int(values[0]), int(values[1])), reason=reason)
        raise InvalidAnswer("several answers", "its choice names more than one frontier")
    numbers = [v for v in values if isinstance(v, int | float) and not isinstance(v, bool)]
    if len(values) == 2 and len(numbers) == 2 and all(
        abs(v) < 1e9 and float(v).is_integer() for v in numbers
    ):  # fmt: skip
        return Answer((int(numbers[0]), int(numbers[1])), reason=reason)
    if len(values) == 1 and len(numbers) == 1:
        raise InvalidAnswer("bare number", "its choice is a number, not a coordinate x,y or an id")
    raise InvalidAnswer("no choice", "its choice is not a coordinate x,y of a cell")
