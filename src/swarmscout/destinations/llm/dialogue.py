"""The conversation of one decision: ask, read, check, ask again with what was wrong, give up."""

from __future__ import annotations

from collections.abc import Generator
from dataclasses import dataclass
from typing import Any

from swarmscout.core.language_model import Attempt, Message, Reply, Request
from swarmscout.destinations.llm.parse import InvalidAnswer, read_answer
from swarmscout.destinations.llm.prompt_data import Encoded
from swarmscout.destinations.llm.prompts import Prompt
from swarmscout.destinations.llm.resolve import cell_of_answer
from swarmscout.destinations.view import LeaderView

__all__ = ["NOT_SENT", "Outcome", "converse", "question", "schema_of"]

NOT_SENT = ("paused", "budget used up")
"""Failures of requests that were not sent."""

# Providers limit the number of values in an enumeration, and their characters above 250 values.
_MOST_VALUES, _MANY_VALUES, _MOST_CHARACTERS = 1000, 250, 15_000
_MOST_WORDS = 2000


@dataclass(frozen=True, slots=True)
class Outcome:
    """The result of a conversation.

    Attributes:
        cell: the frontier that the model chose, or None.
        reason: its words.
        attempts: every question that was sent, with its answer.
        fallback: without a cell: why the rule has to decide.
    """

    cell: tuple[int, int] | None
    reason: str
    attempts: tuple[Attempt, ...]
    fallback: str = ""


def schema_of(encoded: Encoded, *, brief: bool) -> dict[str, Any]:
    """JSON schema of an answer: an enumeration of the candidates where it is not too long.

    Args:
        encoded: the view with the candidates.
        brief: a choice and a short reason; else also the candidates considered, before the choice.
    """
    ids = [candidate.id for candidate in encoded.candidates]
    text = {"type": "string", "maxLength": 200}
    choice: dict[str, Any] = {"type": "string"}
    few = len(ids) <= _MANY_VALUES or sum(map(len, ids)) <= _MOST_CHARACTERS
    if len(ids) <= _MOST_VALUES and few:
        choice["enum"] = ids
    considered = {
        "type": "array",
        "maxItems": 5,
        "items": {
            "type": "object",
            "properties": {"id": {"type": "string", "maxLength": 20}, "for": text, "against": text},
            "required": ["id", "for", "against"],
            "additionalProperties": False,
        },
    }
    properties = {
        "choice": choice,
        "reason": {"type": "string", "maxLength": 80 if brief else 300},
    }
    if not brief:
        properties = {"candidates": considered, **properties}
    return {
        "type": "object",
        "properties": properties,
        "required": list(properties),
        "additionalProperties": False,
    }


def converse(
    view: LeaderView,
    encoded: Encoded,
    prompt: Prompt,
    messages: tuple[Message, ...],
    *,
    encoding: str,
    brief: bool,
    attempts: int,
    max_tokens: int,
) -> Generator[Request, Reply, Outcome]:
    """Ask until an answer is valid, or until all attempts are used.

    Args:
        view: what the leader knows.
        encoded: the view as the model sees it.
        prompt: with the words for asking again; without them the call is repeated.
        messages: the question.
        encoding: its name, for the record.
        brief: see :func:`schema_of`.
        attempts: maximum number of questions; a failed request ends the conversation.
        max_tokens: longest answer.
    """
    schema = schema_of(encoded, brief=brief)
    made: list[Attempt] = []
    chat = messages
    for number in range(1, attempts + 1):
        request = Request(chat, schema, number, max_tokens)
        reply = yield request
        if reply.failure in NOT_SENT:
            return Outcome(None, "", tuple(made), reply.failure)
        cell, reason, problem = None, "", ""
        if reply.failure:
            verdict = f"failed: {reply.failure}"
        else:
            try:
                answer = read_answer(reply.text, reply.finish)
                cell, reason = cell_of_answer(answer, encoded, view), answer.reason
                verdict = "valid"
            except InvalidAnswer as invalid:
                verdict, problem = invalid.name, invalid.problem
        made.append(
            Attempt(
                number, request, reply, verdict, cell, reason, encoding, prompt.version,
                len(encoded.candidates), encoded.dropped,
            )
        )  # fmt: skip
        if cell is not None:
            return Outcome(cell, reason, tuple(made))
        if reply.failure:
            return Outcome(None, "", tuple(made), reply.failure)
        if prompt.retry.strip():
            said = reply.text.strip()[:_MOST_WORDS] or "(nothing)"
            again = prompt.filled("retry", problem=problem)
            chat = (*messages, Message("assistant", said), Message("user", again))
    return Outcome(None, "", tuple(made), "invalid answers")


def question(
    view: LeaderView, encoded: Encoded, prompt: Prompt, history: str = ""
) -> tuple[Message, ...]:
    """The first messages of a decision.

    Args:
        view: what the leader knows.
        encoded: the view, written down.
        prompt: the template.
        history: the team's last decisions, a line each.
    """
    frame = view.frame
    row, col = frame.cell_of(*view.position_m)
    form = (
        "one of " + ", ".join(c.id for c in encoded.candidates)
        if encoded.closed
        else _form(encoded)
    )
    return (
        Message("system", prompt.filled("system")),
        Message(
            "user",
            prompt.filled(
                "user",
                legend=encoded.legend,
                map=encoded.text,
                position=f"({col},{row})",
                heading=_compass(view.pose[2]),
                others=_others(view),
                cell_m=f"{frame.cell_m:g}",
                history=f"\nYour last decisions:\n{history}\n" if history else "",
                answer=prompt.filled("answer", form=form),
            ),
        ),
    )


def _form(encoded: Encoded) -> str:
    if encoded.candidates[0].id[0].isalpha():
        return "as its id"
    return "as its coordinate x,y"


def _others(view: LeaderView) -> str:
    frame, others = view.frame, view.others
    lines = []
    for leader, place, goal in zip(
        others.leaders.tolist(),
        others.positions_m.tolist(),
        others.destinations_m.tolist(),
        strict=True,
    ):
        row, col = frame.cell_of(*place)
        text = f"team of robot {leader} at ({col},{row})"
        if goal[0] == goal[0]:
            to_row, to_col = frame.cell_of(*goal)
            text += f", going to ({to_col},{to_row})"
        lines.append(text)
    return "\n".join(lines) or "none"


def _compass(heading_rad: float) -> str:
    names = ("east", "north-east", "north", "north-west", "west", "south-west", "south",
             "south-east")  # fmt: skip
    return names[round(heading_rad / 0.7853981633974483) % 8]
