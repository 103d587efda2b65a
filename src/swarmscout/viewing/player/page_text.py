"""Texts of a run as the page may show them: bounded, private, without control characters.

Selectors and language models write these texts. The page shows them as text and never as markup;
here they lose what could disturb a reader or tell a stranger about the machine they come from.
"""

from __future__ import annotations

import math
import os
import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

__all__ = ["page_data", "page_text"]

LONGEST_TEXT = 20_000
"""Longer texts are cut: a model's answer can have any length."""

# The folders of an absolute path; URLs, fractions and relative paths are left alone.
_PART = r"[^\s\\/'\"<>|:*?]+"
_FOLDERS = re.compile(
    rf"(?:file://|(?<![\w/.]))(?:/(?=[^/\s]*[A-Za-z])(?:{_PART}/)+|[A-Za-z]:[\\/](?:{_PART}[\\/])*)"
)
_HOMES = re.compile(rf"(?<![\w/.])(?:/home/|/Users/|[A-Za-z]:\\Users\\){_PART}(?![\w\\/])")
# Control characters, except tab and line feed, and marks that reorder the text around them.
_CONTROLS = {code: 0xFFFD for code in (*range(0x20), *range(0x7F, 0xA0)) if code not in (9, 10)}
_CONTROLS |= dict.fromkeys((*range(0x202A, 0x202F), *range(0x2066, 0x206A)), 0xFFFD)
_CONTROLS |= dict.fromkeys(range(0xD800, 0xE000), 0xFFFD)  # Lone surrogates: no UTF-8 for them.


def page_text(text: str) -> str:
    """A text without folders, control characters and what is too long.

    Absolute paths keep their last part only; control characters become U+FFFD.
    """
    length = len(text)
    if length > LONGEST_TEXT:
        text = f"{text[:LONGEST_TEXT]} … ({length:,} characters, cut)"
    text = text.replace("\r\n", "\n").translate(_CONTROLS)
    for home in (f"{Path.home()}{os.sep}", str(Path.home())):
        if len(home) > 2:
            text = text.replace(home, "" if home.endswith(os.sep) else "~")
    return _FOLDERS.sub("", _HOMES.sub("~", text))


def page_data(value: Any) -> Any:
    """Plain data with all texts as :func:`page_text`; numbers that JSON lacks become None."""
    if isinstance(value, str):
        return page_text(value)
    if isinstance(value, Mapping):
        return {page_text(str(key)): page_data(inner) for key, inner in value.items()}
    if isinstance(value, list | tuple):
        return [page_data(inner) for inner in value]
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value
