"""Token counts, estimated without any model's vocabulary."""

from __future__ import annotations

import re

__all__ = ["estimate_tokens"]

_PIECES = re.compile(r"[^\W\d_]+|\d{1,3}|\s*\n\s*| +(?=[^\w])|[^\w\s]+|_+")
_LETTERS = 9.0


def estimate_tokens(text: str) -> int:
    """Estimate the tokens of a text in a vocabulary like that of gpt-4o.

    Digits count in threes, words by their length, runs of punctuation as one. docs/llm.md compares
    the estimate with real counts.

    Args:
        text: any text.
    """
    tokens = 0
    for match in _PIECES.finditer(text):
        piece = match.group()
        tokens += 1 + int(len(piece) / _LETTERS) if piece[0].isalpha() else 1
    return tokens
