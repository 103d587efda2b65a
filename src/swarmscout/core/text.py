"""Text from outside, made safe to encode, to keep and to print."""

from __future__ import annotations

import re

__all__ = ["MOST_CHARACTERS", "clean_line", "clean_text"]

MOST_CHARACTERS = 200_000
"""Longest text that is kept."""

# Control characters but tab and line feed, and the marks that reverse the direction of writing.
_UNSAFE = re.compile("[\x00-\x08\x0b-\x1f\x7f-\x9f\u2028\u2029\u202a-\u202e\u2066-\u2069]")


def clean_text(text: str) -> str:
    """A text without control characters and halves of characters, each replaced by U+FFFD."""
    text = text[:MOST_CHARACTERS].replace("\r\n", "\n").replace("\r", "\n")
    # JSON may write one character as two escapes; alone, either half is not a character.
    text = text.encode("utf-16-le", "surrogatepass").decode("utf-16-le", "replace")
    return _UNSAFE.sub("\ufffd", text)


def clean_line(text: str, longest: int = 300) -> str:
    """A text as one short line."""
    line = " ".join(clean_text(text[: 20 * longest]).split())
    return line if len(line) <= longest else f"{line[: longest - 1]}…"
