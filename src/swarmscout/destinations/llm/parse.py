"""Reading a model's answer: tolerant of its form, and never a guess.

The result is one choice, in the model's words: an id or a coordinate. Whether it is a frontier is
decided in :mod:`swarmscout.destinations.llm.resolve`.

An answer states its choice outright (a JSON object with ``choice``, a line ``Choice: …``, a box) or
implies it (an object with a destination, or with x and y). What is stated outright counts; what is
implied counts only if nothing is stated. Examples, candidates with arguments for and against, and
objects that the words beside them reject do not count. Two different choices are not an answer.
"""

from __future__ import annotations

import json
import re
from collections import deque
from collections.abc import Iterator
from typing import Any

from swarmscout.core.text import clean_line
from swarmscout.destinations.llm.answer_json import Found, objects_in
from swarmscout.destinations.llm.answer_text import Unfinished, answer_in, plain_signs
from swarmscout.destinations.llm.choice_value import (
    ANY_PAIR,
    LONGEST,
    NUMBER,
    Answer,
    InvalidAnswer,
    choice_of,
    from_text,
    named,
)

__all__ = ["Answer", "InvalidAnswer", "read_answer"]

_OUTRIGHT = (
    "choice", "chosen", "final_choice", "final_answer", "selected", "selection", "answer",
    "decision", "chosen_frontier", "selected_frontier", "chosen_id",
)  # fmt: skip
_IMPLIED = (
    "destination", "next_destination", "target", "goal", "cell", "frontier", "coordinate",
    "coordinates", "position", "id",
)  # fmt: skip
_WRAPPERS = (
    "response", "result", "output", "answer", "arguments", "parameters", "args", "input", "data",
    "json", "final", "final_answer", "decision", "function", "properties", "content", "tool_call",
    "tool_calls", "choice",
)  # fmt: skip
_LONGEST_REASON = 2000
_ARGUED = {"for", "against", "pro", "con", "pros", "cons"}

_LABEL = re.compile(
    r"^[\s*_#>\-`]{0,8}(?:my\s|the\s)?(?:final\s)?(choice|answer|destination|decision)"
    r"[\s*_`]{0,4}(?:is\b\s{0,4}[:=]?|[:=→]|->)(.*)$",
    re.IGNORECASE | re.DOTALL,
)
_BOX = re.compile(r"\\boxed\s?\{(?:\\text\s?\{)?([^{}]{0,100})\}")
_TAGGED = re.compile(
    r"<(answer|final|final_answer|choice|response|output)>([^<]{0,300})</\1>", re.IGNORECASE
)
_REFUSAL = re.compile(
    r"\b(i'?m sorry|i am sorry|i cannot|i can'?t|i'?m unable|i am unable|as an ai)\b", re.IGNORECASE
)
_TAKEN_BACK = re.compile(
    r"\bwait\s{0,3}[,.!…–-]|\b(scratch that|on second thought|correction\b|actually,|"
    r"(that|this|it|which)( i|')s (wrong|incorrect|invalid|a mistake|not (valid|right|a )))",
    re.IGNORECASE,
)
_REJECTED = re.compile(
    r"\b(not|never|avoid|instead of|rather than|don'?t|example|for instance|e\.g\.?|such as|unlike)"
    r"[\s:,*`\"']{0,4}"
    r"((choose|pick|select|take|use|go to|answer|answering|is|are)[\s:*`\"']{1,4})?$|"
    r"\b(am|is|are|was) at\s{0,4}$|\b(team|robot) \d{1,5}('s [a-z]{1,20})?[\s:,*]{0,4}$",
    re.IGNORECASE,
)
_JUDGED = re.compile(
    r"^[\s`*\"']{0,6}(\?\s{0,3}no\b|no\b|(is|was|would be|seems|looks) (a |an )?"
    r"(bad|wrong|not|blocked|taken|worse|impossible|invalid))",
    re.IGNORECASE,
)


def read_answer(text: str, finish: str = "stop") -> Answer:
    """Read the one choice in a text.

    Args:
        text: all that the model wrote.
        finish: how it ended, see :class:`swarmscout.core.language_model.Reply`.

    Raises:
        InvalidAnswer: it holds no choice, several, or an unclear one.
    """
    if finish in ("refusal", "filter"):
        raise InvalidAnswer("refusal", "it was a refusal")
    try:
        plain = answer_in(text)
        if "｛" in plain:
            plain = plain_signs(plain)
    except Unfinished:
        raise InvalidAnswer("cut off", "it was cut off while reasoning; be brief") from None
    if finish == "length" and not _is_complete(text, plain):
        raise InvalidAnswer("cut off", "it was cut off before its end; be brief")
    if not plain:
        raise InvalidAnswer("empty", "it was empty")
    if _names_a_choice(plain):
        return choice_of(plain, "")
    if plain.startswith('"') and "{" in plain:
        plain = _unquoted(plain)
    return _one_of(plain)


def _is_complete(text: str, plain: str) -> bool:
    """Whether a text that reached its limit is a whole object, and blanks until the limit."""
    if not text[-1:].isspace() or not plain.endswith("}"):
        return False
    last = deque(objects_in(plain), maxlen=1)
    return bool(last) and last[0].end == len(plain) and last[0].data is not None


def _names_a_choice(text: str) -> bool:
    short = len(text) <= LONGEST and "\n" not in text and "{" not in text
    return short and named(text, "") is not None


def _unquoted(text: str) -> str:
    """A JSON object that was written as a JSON string."""
    try:
        inner = json.loads(text, strict=False)
    except (ValueError, RecursionError):
        return text
    return inner if isinstance(inner, str) else text


def _one_of(plain: str) -> Answer:
    """The choice among all that a text states."""
    found = [one for one in objects_in(plain) if one.end < 0 or not _rejected(plain, one)]
    proper = any(one.data is not None and not one.loose for one in found)
    outright: list[Answer] = []
    implied: list[Answer] = []
    broken = None
    for one in found:
        if one.end < 0:
            if '"' in one.text or "choice" in one.text:
                raise InvalidAnswer("cut off", "it was cut off before its end; be brief")
        elif one.data is not None and not (one.loose and proper):
            for sure, answer in _choices_in(one.data):
                (outright if sure else implied).append(answer)
        elif one.data is None and ('"' in one.text or ":" in one.text):
            broken = one
    unclear = None
    for sure, text in _stated(_outside(plain, found)):
        try:
            (outright if sure else implied).append(from_text(text, ""))
        except InvalidAnswer as invalid:
            unclear = unclear or invalid
    if unclear is not None and not outright:
        raise unclear
    if broken is not None and (not (outright or implied) or "choice" in broken.text.casefold()):
        raise InvalidAnswer("malformed JSON", "its JSON cannot be read")
    if outright or implied:
        return _agreed(plain, found, outright, implied)
    if any(one.data is not None for one in found):
        raise InvalidAnswer("no choice", 'its JSON has no "choice"')
    if len(plain) <= LONGEST and NUMBER.match(plain):
        raise InvalidAnswer("bare number", "it is a number, not a coordinate x,y or an id")
    if _REFUSAL.search(plain):
        raise InvalidAnswer("refusal", "it was a refusal")
    raise InvalidAnswer("no answer", "it holds no JSON object")


def _agreed(
    plain: str, found: list[Found], outright: list[Answer], implied: list[Answer]
) -> Answer:
    """The one choice that all statements agree on.

    Raises:
        InvalidAnswer: they do not, or the words after them take the choice back.
    """
    stated = outright or implied
    if len({(answer.point, answer.id.casefold()) for answer in stated}) > 1:
        raise InvalidAnswer("several answers", "it names more than one choice")
    ends = [one.end for one in found if one.data is not None]
    after = plain[max(ends) :] if ends else _behind_labels(plain)
    if _REFUSAL.search(after):
        raise InvalidAnswer("refusal", "it was a refusal")
    if _TAKEN_BACK.search(after):
        raise InvalidAnswer("several answers", "it takes its choice back")
    if not outright and not ends:
        others = {pair.group().replace(" ", "") for pair in ANY_PAIR.finditer(plain_signs(plain))}
        if len(others) > 1:
            raise InvalidAnswer("several answers", "it names more than one coordinate")
    return stated[0]


def _behind_labels(text: str) -> str:
    """What follows the last line that states a choice."""
    lines = text.splitlines()
    stating = [k for k, line in enumerate(lines) if _LABEL.match(line[:LONGEST])]
    return "\n".join(lines[stating[-1] + 1 :]) if stating else ""


def _rejected(text: str, one: Found) -> bool:
    """Whether the words right before or behind an object say that it is not the answer."""
    before = text[max(0, one.start - 60) : one.start].replace("’", "'")
    rejected = _REJECTED.search(before.rsplit("\n", 1)[-1])
    return bool(rejected or _JUDGED.match(text[one.end : one.end + 60]))


def _outside(text: str, found: list[Found]) -> str:
    """A text without its objects."""
    kept, at = [], 0
    for one in found:
        if one.end >= 0 and not text[: one.start].endswith(("\\boxed", "\\text")):
            kept.append(text[at : one.start])
            at = one.end
    return "".join([*kept, text[at:]])


def _stated(text: str) -> Iterator[tuple[bool, str]]:
    """What lines, boxes and tags state as the choice, each with whether they do so outright."""
    for line in text.splitlines():
        label = _LABEL.match(line[:LONGEST])
        if label and label.group(2).strip(" \t*_`:"):
            sure = label.group(1).casefold() != "destination"
            yield sure, label.group(2)
    for pattern, group in ((_BOX, 1), (_TAGGED, 2)):
        for match in pattern.finditer(text):
            if match.group(group).strip():
                yield True, match.group(group)


def _choices_in(data: dict[str, Any], depth: int = 0) -> list[tuple[bool, Answer]]:
    """Choices in an object, each with whether it is stated outright."""
    lowered = {str(key).strip().casefold().replace(" ", "_"): v for key, v in data.items()}
    reason = _reason(lowered)
    for key in _OUTRIGHT:
        if key in lowered and not (key in _WRAPPERS and _wraps(lowered[key])):
            return [(True, choice_of(lowered[key], reason))]
    inner = [lowered[key] for key in _WRAPPERS if key in lowered and depth < 4]
    for value in inner:
        value = value[0] if isinstance(value, list) and len(value) == 1 else value
        wrapped = _object(value)
        if wrapped is not None:
            found = _choices_in(wrapped, depth + 1)
            if found:
                return found
    if _ARGUED & lowered.keys():
        return []
    answers = [choice_of(lowered[key], reason) for key in _IMPLIED if key in lowered]
    if {"x", "y"} <= lowered.keys():
        answers.append(choice_of(lowered, reason))
    if len({(answer.point, answer.id) for answer in answers}) > 1:
        raise InvalidAnswer("several answers", 'it names more than one choice; use "choice"')
    return [(False, answer) for answer in answers[:1]]


def _wraps(value: Any) -> bool:
    """Whether a value holds an object with a choice in it, rather than a choice."""
    inner = _object(value)
    return inner is not None and any(
        str(key).strip().casefold() in (*_OUTRIGHT, *_WRAPPERS) for key in inner
    )


def _object(value: Any) -> dict[str, Any] | None:
    if isinstance(value, str) and value.lstrip().startswith("{") and len(value) < 20_000:
        found = next(objects_in(value), None)
        return found.data if found is not None else None
    return value if isinstance(value, dict) else None


def _reason(data: dict[str, Any]) -> str:
    reason = data.get("reason", data.get("why", ""))
    return clean_line(reason, _LONGEST_REASON) if isinstance(reason, str) else ""
