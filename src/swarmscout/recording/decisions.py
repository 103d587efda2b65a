"""Decisions and the questions asked for them: rows of tables, and texts named by their hash."""

from __future__ import annotations

import json
import math
import re
from collections.abc import Iterable, Mapping
from hashlib import sha256
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from swarmscout.core.errors import RunError, SelectorError
from swarmscout.core.language_model import Attempt, Message
from swarmscout.core.recorder import Decision
from swarmscout.recording.table_files import write_whole
from swarmscout.recording.tables import TABLES

__all__ = [
    "TEXTS",
    "Asked",
    "Decided",
    "Texts",
    "attempt_row",
    "plain",
    "prompt_text",
    "read_text",
    "text_hash",
]

TEXTS = "texts"
"""The folder of a run that holds prompts and answers."""

_PLAIN = frozenset({int, str, bool, type(None)})
_to_json = json.JSONEncoder(sort_keys=True).encode


class Decided(NamedTuple):
    """A decision as the table ``decisions`` takes it.

    Attributes:
        decision: the decision.
        cell: flat, or None when there was nothing to choose; then the next three are None too.
        x_m, y_m, distance_m: of the decision.
        reason: its reason as valid text.
        details: its details as JSON.
    """

    decision: Decision
    cell: int | None
    x_m: float | None
    y_m: float | None
    distance_m: float | None
    reason: str
    details: str

    @staticmethod
    def of(decision: Decision, columns: int) -> Decided:
        """The row of a decision; details are copied, since a selector may go on using its mapping.

        Args:
            decision: what was decided.
            columns: of the map, for flat cells.

        Raises:
            SelectorError: the selector's details contain themselves.
        """
        reason, details = decision.reason, "{}"
        if not (isinstance(reason, str) and reason.isascii()):
            # Half of a surrogate pair cannot be written to a file.
            reason = str(reason).encode(errors="replace").decode()
        if decision.details:
            details = _details(decision)
        if decision.cell is None:
            return Decided(decision, None, None, None, None, reason, details)
        row, column = decision.cell
        place = (decision.x_m, decision.y_m, decision.distance_m)
        return Decided(decision, row * columns + column, *place, reason, details)


class Asked(NamedTuple):
    """A question to a language model as the table ``attempts`` takes it.

    Attributes:
        decision, attempt: what it was asked for, and what was asked and answered.
        prompt, answer: names of the texts; no answer is None.
        cell: the flat cell that a valid answer chose, or None.
    """

    decision: Decision
    attempt: Attempt
    prompt: str
    answer: str | None
    cell: int | None

    @staticmethod
    def of(decision: Decision, columns: int) -> list[Asked]:
        """The rows of a decision; `columns` of the map, for flat cells."""
        return [
            Asked(
                decision,
                attempt,
                text_hash(prompt_text(attempt.request.messages)),
                text_hash(attempt.reply.text) if attempt.reply.text else None,
                None if attempt.cell is None else attempt.cell[0] * columns + attempt.cell[1],
            )
            for attempt in decision.attempts
        ]


def attempt_row(asked: Asked) -> dict[str, Any]:
    """One row of the table ``attempts`` by its columns' names."""
    return {column.name: column.source(asked) for column in TABLES["attempts"].columns}


def text_hash(text: str) -> str:
    """The name under which a text is kept."""
    return sha256(text.encode()).hexdigest()[:16]


def prompt_text(messages: Iterable[Message]) -> str:
    """A prompt's messages as one text, each under a line with its role."""
    return "\n\n".join(f"[{message.role}]\n{message.text}" for message in messages) + "\n"


class Texts:
    """Prompts and answers, each kept once.

    Args:
        folder: the run's; None keeps them in memory.
    """

    def __init__(self, folder: Path | None) -> None:
        self.kept: dict[str, str] = {}
        self._folder = folder
        self._written: set[str] = set()

    def keep(self, text: str) -> None:
        """Keep a text.

        Raises:
            RunError: it cannot be written.
        """
        name = text_hash(text)
        if self._folder is None:
            self.kept[name] = text
        elif name not in self._written:
            folder = self._folder / TEXTS
            try:
                folder.mkdir(exist_ok=True)
            except OSError as error:
                raise RunError(f"cannot write '{folder}': {error.strerror or error}") from error
            write_whole(folder / f"{name}.txt", text.encode(), sweep=False)
            self._written.add(name)

    def keep_all(self, decisions: Iterable[Decision]) -> None:
        """Keep the prompts and answers of some decisions.

        Raises:
            RunError: one cannot be written.
        """
        for decision in decisions:
            for attempt in decision.attempts:
                self.keep(prompt_text(attempt.request.messages))
                if attempt.reply.text:
                    self.keep(attempt.reply.text)


def read_text(folder: Path, name: str) -> str:
    """A prompt or an answer of a run's folder.

    Args:
        folder: the run's.
        name: the text's hash. Anything else is refused: a table must not lead to other files.

    Raises:
        RunError: the text is missing, or its content does not match its name.
    """
    if not re.fullmatch(r"[0-9a-f]{16}", str(name)):
        raise RunError(f"run '{folder}' is damaged: {name!r} does not name a text")
    file = folder / TEXTS / f"{name}.txt"
    try:
        text = file.read_bytes().decode()
    except (OSError, UnicodeDecodeError) as error:
        reason = getattr(error, "strerror", None) or "it is not UTF-8 text"
        raise RunError(f"cannot read '{file}': {reason}") from None
    if text_hash(text) != name:
        raise RunError(f"'{file}' is damaged: its content does not match its name")
    return text


def plain(value: Any) -> Any:
    """A value as plain data for JSON: NumPy numbers and arrays unwrapped, NaN and ∞ as null."""
    kind = type(value)
    if kind is float:  # First the most frequent: the check for a Mapping takes longest.
        return value if math.isfinite(value) else None
    if kind in _PLAIN:
        return value
    if isinstance(value, Mapping):
        return {str(key): plain(inner) for key, inner in value.items()}
    if isinstance(value, list | tuple):
        return [plain(inner) for inner in value]
    if isinstance(value, np.ndarray | np.generic):
        return plain(value.tolist())
    if isinstance(value, float):
        return float(value) if math.isfinite(value) else None
    return value if value is None or isinstance(value, bool | int | str) else str(value)


def _details(decision: Decision) -> str:
    try:
        return _to_json(plain(decision.details))
    except RecursionError:
        raise SelectorError(
            f"selector '{decision.selector}' gave details that contain themselves (step "
            f"{decision.step}, robot {decision.leader}); give plain data"
        ) from None
