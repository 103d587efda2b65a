"""Whole numbers on the command line: 1.5 is refused, not rounded."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Annotated

from cyclopts import Parameter

if TYPE_CHECKING:
    from cyclopts import Token

__all__ = ["WholeNumber"]


def _whole(_: type, tokens: Sequence[Token]) -> int:
    text = tokens[0].value
    try:
        return int(text)
    except ValueError:
        raise ValueError(f'unable to convert "{text}" into int: expected a whole number') from None


WholeNumber = Annotated[int, Parameter(converter=_whole)]
"""An option's value; ``15``, but neither ``1.5`` nor ``1e3``."""
