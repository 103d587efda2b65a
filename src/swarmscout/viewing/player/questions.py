"""Prompts to a language model and its answers, as the page shows them."""

from __future__ import annotations

import contextlib
from typing import Any

from swarmscout.core.errors import RunError
from swarmscout.core.recorder import Decision
from swarmscout.recording.decisions import Asked, attempt_row, prompt_text
from swarmscout.recording.run import Run

__all__ = ["questions_live", "questions_of"]

KEY = ("step", "team", "leader")


def questions_live(decision: Decision, columns: int) -> list[dict[str, Any]]:
    """The attempts of a live decision, with their texts.

    Args:
        decision: with its attempts.
        columns: of the map, for flat cells.
    """
    rows = []
    for asked in Asked.of(decision, columns):
        row = attempt_row(asked)
        row["prompt"] = prompt_text(asked.attempt.request.messages)
        row["answer"] = asked.attempt.reply.text or None
        rows.append(_shown(row))
    return rows


def questions_of(run: Run) -> dict[tuple[int, int, int], list[dict[str, Any]]]:
    """The attempts of a recorded run by step, team and leader, with their texts."""
    found: dict[tuple[int, int, int], list[dict[str, Any]]] = {}
    for row in run.attempts.to_dicts():
        for name in ("prompt", "answer"):
            # Where a text is missing, its hash is shown instead.
            with contextlib.suppress(RunError):
                row[name] = row[name] and run.text(row[name])
        found.setdefault((row["step"], row["team"], row["leader"]), []).append(_shown(row))
    return found


def _shown(row: dict[str, Any]) -> dict[str, Any]:
    """A row without the columns of the decision itself."""
    return {name: value for name, value in row.items() if name not in KEY}
