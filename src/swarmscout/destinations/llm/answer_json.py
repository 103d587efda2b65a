"""JSON objects in a model's text, also where their form is not quite JSON.

Strict JSON is read first. What is almost JSON is repaired: swapped brackets, tuples, trailing
commas, comments, single or typographic quotes, keys and values without quotes, line ends and stray
escapes in strings, doubled braces. What is cut off is never completed. The time is linear in the
text.
"""

from __future__ import annotations

import json
import re
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from swarmscout.destinations.llm.answer_text import plain_signs

__all__ = ["Found", "Several", "objects_in"]

_CLOSERS = {"{": "}", "[": "]", "(": ")"}
_WORDS = {"true": "true", "false": "false", "null": "null", "none": "null", "nan": "null"}
_NUMBER = re.compile(r"-?(0|[1-9]\d{0,14})(\.\d{1,15})?\Z")
_PAIR = re.compile(r"[-+]?\d{1,9}[ \t]*,[ \t]*[-+]?\d{1,9}(?=\s{0,20}[,}])(?!\s{0,20},\s{0,20}\d)")
_BARE = re.compile(r"[^\s,:{}\[\]()\"'][^,:{}\[\]()\"'\n]{0,200}")
_ESCAPES = '"\\/bfnrtu'


class Several(tuple[Any, ...]):
    """Different values of one key that came more than once."""


@dataclass(frozen=True, slots=True)
class Found:
    """An object in a text, or a place where one was begun.

    Attributes:
        start, end: its place; ``end`` is -1 if it is not closed.
        data: the object; None if it cannot be read.
        loose: whether one of its values is a word without quotes.
        text: as written.
    """

    start: int
    end: int
    data: dict[str, Any] | None
    loose: bool
    text: str


def objects_in(text: str) -> Iterator[Found]:
    """Outermost objects in a text, in their order.

    Args:
        text: a model's answer.

    Yields:
        Each object; the last one may not be closed.
    """
    strict = json.JSONDecoder(
        object_pairs_hook=_keeping_all,
        parse_int=_whole,
        parse_constant=lambda _: None,
        strict=False,
    )
    at = text.find("{")
    while at >= 0:
        try:
            data, end = strict.raw_decode(text, at)
            yield Found(at, end, data, False, text[at:end])
        except (ValueError, RecursionError):
            repair = _Repair(text, at)
            end = repair.end
            yield Found(at, end, _loaded(strict, repair, text), repair.loose, text[at:end])
            if end < 0:
                return
        at = text.find("{", end)


def _loaded(strict: json.JSONDecoder, repair: _Repair, text: str) -> dict[str, Any] | None:
    if repair.end < 0:
        return None
    texts = [repair.text]
    written = text[repair.start : repair.end]
    plain = plain_signs(written)
    if plain != written:
        other = _Repair(plain, 0)
        if other.end == len(plain):
            texts.append(other.text)
    for one in texts:
        for _ in range(3):
            try:
                data = strict.decode(one)
            except (ValueError, RecursionError):
                # Templates double their braces, and so do models that were shown one.
                if not (one.startswith("{{") and one.endswith("}}")):
                    break
                one = one[1:-1].strip()
                continue
            return data if isinstance(data, dict) else None
    return None


def _whole(digits: str) -> int | None:
    """A whole number; None for one that no coordinate has."""
    return int(digits) if len(digits) <= 10 else None


def _keeping_all(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    """A JSON object as a dict; different values of one key stand together in a Several."""
    data: dict[str, Any] = {}
    for key, value in pairs:
        if key in data and data[key] != value:
            value = Several((data[key], value))
        data[key] = value
    return data


class _Repair:
    """One pass over an object that is almost JSON.

    Attributes:
        start, end: the object's place; ``end`` is -1 if it is not closed.
        text: the object, as JSON if it can be read that way.
        loose: whether one of its values is a word without quotes.
    """

    def __init__(self, text: str, start: int) -> None:
        self.start, self.end = start, -1
        self.loose = False
        self._text = text
        self._out: list[str] = []
        self._stack: list[str] = []
        at = start
        while at < len(text):
            at = self._token(at)
            if not self._stack:
                self.end = at
                break
        self.text = "".join(self._out)

    def _token(self, at: int) -> int:
        """Take the token at a place; returns the place behind it."""
        sign = self._text[at]
        if sign in "{[(":
            self._stack.append("[" if sign == "(" else sign)
            self._out.append(self._stack[-1])
            return at + 1
        if sign in "}])":
            while self._out[-1] == ",":
                self._out.pop()
            self._out.append(_CLOSERS[self._stack.pop()])
            return at + 1
        if sign == '"' or (sign == "'" and self._out[-1] in "{[,:"):
            return self._string(at, sign)
        if sign.isspace():
            return at + 1
        if self._text.startswith(("//", "/*"), at):
            return self._behind_comment(at)
        if sign in ",:":
            self._out.append(sign)
            return at + 1
        return self._word(at)

    def _behind_comment(self, at: int) -> int:
        """The place behind a comment."""
        closer = "\n" if self._text[at + 1] == "/" else "*/"
        end = self._text.find(closer, at + 2)
        return len(self._text) if end < 0 else end + len(closer)

    def _string(self, start: int, quote: str) -> int:
        """A string; its quote ends it where a value may end, and else belongs to it."""
        text, out = self._text, ['"']
        at = start + 1
        while at < len(text):
            sign = text[at]
            if sign == quote and self._may_end(at + 1):
                self._out.append("".join([*out, '"']))
                return at + 1
            if sign == "\\" and at + 1 < len(text):
                following = text[at + 1]
                out.append(sign + following if following in _ESCAPES else following)
                at += 2
                continue
            out.append('\\"' if sign == '"' else sign)
            at += 1
        self._out.append("".join(out))
        return at

    def _may_end(self, at: int) -> bool:
        """Whether a string may end before a place: something follows that follows a value."""
        text = self._text
        while at < len(text) and text[at].isspace():
            at += 1
        return at == len(text) or text[at] in ",:}])" or text.startswith(("//", "/*"), at)

    def _word(self, at: int) -> int:
        """A key or a value without quotes."""
        value = self._out[-1] == ":" and self._stack[-1] == "{"
        pair = _PAIR.match(self._text, at) if value else None
        match = pair or _BARE.match(self._text, at)
        if match is None:
            self._out.append(self._text[at])
            return at + 1
        word = match.group().strip()
        if pair:
            self._out.append(json.dumps(word))
        elif word.casefold() in _WORDS:
            self._out.append(_WORDS[word.casefold()])
        elif _NUMBER.match(word):
            self._out.append(word)
        else:
            self.loose = self.loose or self._out[-1] == ":"
            self._out.append(json.dumps(word, ensure_ascii=False))
        return match.end()
