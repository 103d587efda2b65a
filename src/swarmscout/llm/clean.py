"""Replies made safe to keep and to show, regardless of what a server or a cassette says.

Every reply passes here where it comes in: from a provider, from a cassette, from a user's own
model. Afterwards its texts can be encoded as UTF-8 and printed, and its numbers fit their columns.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

from swarmscout.core.language_model import FAILURES, FINISHES, Reply
from swarmscout.core.text import MOST_CHARACTERS, clean_line, clean_text

__all__ = ["clean_count", "clean_reply"]

_MOST_TOKENS = 1_000_000_000


def clean_count(value: Any) -> int | None:
    """A count of tokens, or None where it cannot be one."""
    if isinstance(value, float) and value.is_integer():
        value = int(value)
    if isinstance(value, bool) or not isinstance(value, int):
        return None
    return value if 0 <= value <= _MOST_TOKENS else None


def clean_reply(reply: Reply) -> Reply:
    """A reply that can be recorded and shown.

    Raises:
        TypeError: a field has a wrong type, or an unknown word in it; the message names it.
    """
    for name in ("text", "finish", "failure", "note", "model"):
        if not isinstance(getattr(reply, name), str):
            raise TypeError(f"{name} is not a text")
    if reply.finish not in FINISHES:
        raise TypeError(f"finish is none of {', '.join(FINISHES)}")
    if reply.failure and reply.failure not in FAILURES:
        raise TypeError(f"failure is none of {', '.join(FAILURES)}")
    for name in ("tokens_in", "tokens_out"):
        if not isinstance(getattr(reply, name), int | float | None):
            raise TypeError(f"{name} is not a count")
    tries = clean_count(reply.tries)
    if tries is None:
        raise TypeError("tries is not a count")
    cut = len(reply.text) > MOST_CHARACTERS
    return replace(
        reply,
        text=clean_text(reply.text),
        finish="length" if cut else reply.finish,
        note=clean_line(reply.note),
        model=clean_line(reply.model, 200),
        tokens_in=clean_count(reply.tokens_in),
        tokens_out=clean_count(reply.tokens_out),
        tries=min(tries, 1_000_000),
        seconds=_amount("seconds", reply.seconds),
        cost_usd=None if reply.cost_usd is None else _amount("cost_usd", reply.cost_usd),
    )


def _amount(name: str, value: Any) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise TypeError(f"{name} is not a number")
    if not 0 <= value <= 1e9 or not math.isfinite(value):
        raise TypeError(f"{name} = {value!r:.20} is impossible")
    return float(value)
