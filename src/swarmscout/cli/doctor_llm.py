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


def ask_once(llm: str | None, model: str | None) -> int:
    """Ask, and print what works.

    Args:
        llm: a provider or a server's address.
        model: a name.

    Returns:
        0 if a valid answer came, else 2.

    Raises:
        ModelError: no model is configured.
    """
    import os

    from swarmscout.cli.llm_options import llm_overrides
    from swarmscout.core.language_model import Message, Request
    from swarmscout.destinations.llm.parse import InvalidAnswer, read_answer
    from swarmscout.llm.connect import make_model
    from swarmscout.llm.settings import ModelSettings, find_endpoint
    from swarmscout.mission.scenario_files import make_scenario

    scenario = make_scenario({}, llm_overrides(llm, model, None, None))
    settings = ModelSettings(**scenario.llm.model_dump(exclude={"latency_steps"}))
    endpoint = find_endpoint(settings, os.environ)
    print(f"provider    {endpoint.provider}")
    print(f"model       {endpoint.model}")
    if endpoint.base_url:
        print(f"address     {endpoint.base_url}")
    if endpoint.provider != "embedded":
        print(f"key         {'set' if endpoint.key else 'not set'}")
    answerer, _ = make_model(settings, os.environ)
    try:
        reply = answerer.complete(
            Request(
                (
                    Message(
                        "user",
                        "A is a wall, B is open ground. Where should a robot explore? Answer with "
                        'JSON: {"choice": "<A or B>", "reason": "<why, in a few words>"}',
                    ),
                ),
                _SCHEMA,
                max_tokens=120,
            )
        )
    finally:
        close = getattr(answerer, "close", None)
        if close is not None:
            close()
    if reply.failure:
        note = f": {reply.note}" if reply.note else ""
        print(f"error: no answer after {reply.tries} tries: {reply.failure}{note}", file=sys.stderr)
        return 2
    print(f"answered    {reply.model}, {reply.seconds:.2f} s, sent {reply.tries} times")
    try:
        answer = read_answer(reply.text, reply.finish)
    except InvalidAnswer as invalid:
        print(f"error: the answer cannot be used: {invalid.told}", file=sys.stderr)
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
    return 0
