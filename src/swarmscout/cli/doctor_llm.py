"""``swarmscout doctor --llm``: one small question to a language model, and what works of it."""

from __future__ import annotations

import sys
from typing import Any

__all__ = ["ask_once"]

_SCHEMA: dict[str, Any] = {
    "type": "object",
    "properties": {
        "choice": {"type": "string", "enum": ["A", "B"]},
        "reason": {"type": "string", "maxLength": 80},
    },
    "required": ["choice", "reason"],
    "additionalProperties": False,
}
_QUESTION = (
    "A is a wall, B is open ground. Where should a robot explore? Answer with JSON: "
    '{"choice": "<A or B>", "reason": "<why, in a few words>"}'
)


def ask_once(llm: str | None, model: str | None) -> int:
    """Ask one question, and print what works.

    Args:
        llm: a provider or a server's address.
        model: the model's name.

    Returns:
        0 if a valid answer came, else 2.

    Raises:
        ModelError: no model is configured.
    """
    import os

    from swarmscout.cli.llm_options import llm_overrides
    from swarmscout.core.language_model import Message, Request
    from swarmscout.destinations.llm.parse import InvalidAnswer, read_answer
    from swarmscout.llm.connect import connect
    from swarmscout.llm.settings import find_endpoint
    from swarmscout.mission.scenario_files import make_scenario

    settings = make_scenario({}, llm_overrides(llm, model, None, None)).llm
    endpoint = find_endpoint(settings, os.environ)
    print(f"provider    {endpoint.provider}")
    print(f"model       {endpoint.model}")
    if endpoint.base_url:
        print(f"address     {endpoint.base_url}")
    if endpoint.provider != "embedded":
        print(f"key         {'set' if endpoint.key else 'not set'}")
    dispatcher = connect(settings)
    try:
        question = Request((Message("user", _QUESTION),), _SCHEMA, max_tokens=120)
        reply = dispatcher(0, [(0, question)])[0]
    finally:
        dispatcher.close()
    note = f": {reply.note}" if reply.note else ""
    if reply.failure:
        times = f"{reply.tries} {'try' if reply.tries == 1 else 'tries'}"
        print(f"error: no answer after {times}: {reply.failure}{note}", file=sys.stderr)
        return 2
    times = "once" if reply.tries == 1 else f"{reply.tries} times"
    print(f"answered    {reply.model}, {reply.seconds:.2f} s, sent {times}")
    try:
        answer = read_answer(reply.text, reply.finish)
    except InvalidAnswer as invalid:
        print(f"error: the answer cannot be used: {invalid.problem}{note}", file=sys.stderr)
        return 2
    if answer.id not in ("A", "B"):
        print("error: the answer is valid JSON and chooses neither A nor B", file=sys.stderr)
        return 2
    counted = reply.tokens_in is not None
    tokens = f"{reply.tokens_in} + {reply.tokens_out}" if counted else "not counted by the server"
    print(f"chose       {answer.id}{f' ({answer.reason})' if answer.reason else ''}")
    print(f"tokens      {tokens}")
    cost = "no price known: see docs/llm.md" if reply.cost_usd is None else f"${reply.cost_usd:.6f}"
    print(f"cost        {cost}")
    if reply.note:
        print(f"note        {reply.note}")
    return 0
