"""What a language model was asked: rows of the table ``attempts``, and texts by their hash."""

from __future__ import annotations

from collections.abc import Iterable
from hashlib import sha256
from pathlib import Path
from typing import TYPE_CHECKING

from swarmscout.core.errors import RunError
from swarmscout.core.language_model import Attempt, Message
from swarmscout.core.recorder import Decision
from swarmscout.recording.table_files import write_whole
from swarmscout.recording.tables import schema_of

if TYPE_CHECKING:
    import polars as pl

__all__ = ["TEXTS", "Texts", "attempt_row", "attempts_frame", "prompt_text", "text_hash"]

TEXTS = "texts"
"""The folder of a run that holds prompts and answers."""


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

    def keep(self, text: str) -> str:
        """Keep a text; return its hash.

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
            write_whole(folder / f"{name}.txt", text.encode())
            self._written.add(name)
        return name

    def keep_all(self, decisions: Iterable[Decision]) -> None:
        """Keep what was asked and answered for some decisions.

        Raises:
            RunError: it cannot be written.
        """
        for decision in decisions:
            for attempt in decision.attempts:
                self.keep(prompt_text(attempt.request.messages))
                if attempt.reply.text:
                    self.keep(attempt.reply.text)


def attempts_frame(decisions: Iterable[Decision], columns: int) -> pl.DataFrame:
    """Attempts of some decisions as a table.

    Args:
        decisions: in order.
        columns: of the map, for flat cells.
    """
    import polars as pl

    rows = [attempt_row(d, attempt, columns) for d in decisions for attempt in d.attempts]
    return pl.DataFrame(rows, schema=schema_of("attempts"), orient="row")


def attempt_row(decision: Decision, attempt: Attempt, columns: int) -> tuple[object, ...]:
    """One row of the table ``attempts``, in the order of its columns."""
    reply = attempt.reply
    return (
        decision.step,
        decision.team,
        decision.leader,
        attempt.number,
        reply.model,
        attempt.encoding,
        attempt.prompt_version,
        text_hash(prompt_text(attempt.request.messages)),
        attempt.candidates,
        attempt.dropped,
        text_hash(reply.text) if reply.text else None,
        attempt.verdict,
        None if attempt.cell is None else attempt.cell[0] * columns + attempt.cell[1],
        attempt.reason,
        reply.note,
        reply.tries,
        reply.seconds,
        reply.tokens_in,
        reply.tokens_out,
        reply.cost_usd,
    )
