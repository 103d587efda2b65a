"""How the values of all commands are read: whole numbers, paths, values that begin with a minus."""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from cyclopts import Token

__all__ = ["convert_value", "with_values_joined"]

_OPTION = re.compile(r"--[a-z][a-z-]*|-[a-z]")
_NEGATIVE = re.compile(r"-\.?\d\S*")


def convert_value(kind: Any, tokens: Sequence[Token]) -> Any:
    """An option's value: ``~`` and ``$HOME`` are replaced in paths, 1.5 is not rounded to an int.

    Args:
        kind: the option's type.
        tokens: what was typed.
    """
    from cyclopts import convert

    from swarmscout.core.paths import expanded

    text = tokens[0].value if tokens else ""
    if kind is Path:
        return expanded(text)
    if kind is str and text.startswith(("~", "$")):  # A world, a scenario, FILE.py:NAME.
        return str(expanded(text))
    if kind is int:
        try:
            return int(text)
        except ValueError:
            raise ValueError(
                f'unable to convert "{text}" into int: expected a whole number'
            ) from None
    return convert(kind, tokens)


def with_values_joined(words: Sequence[str]) -> list[str]:
    """Join an option and a value such as ``-10,2``, which would be taken for an option.

    ``--llm`` without a value gets the value ``auto``.

    Example:
        >>> with_values_joined(["--start", "-10,2", "--llm", "--no-picture"])
        ['--start=-10,2', '--llm=auto', '--no-picture']
    """
    joined: list[str] = []
    for word, following in zip(words, [*words[1:], "-"], strict=False):
        if word == "--llm" and following.startswith("-"):
            joined.append("--llm=auto")
        elif joined and _OPTION.fullmatch(joined[-1]) and _NEGATIVE.fullmatch(word):
            joined[-1] = f"{joined[-1]}={word}"
        else:
            joined.append(word)
    return joined
