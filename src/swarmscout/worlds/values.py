"""Selection of free cells by value, for arrays and images with another meaning."""

from __future__ import annotations

import re
from typing import Any

import numpy as np
from numpy.typing import NDArray

from swarmscout.core.errors import WorldError

__all__ = ["free_by_value"]

_NUMBER = r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d{1,3})?"
_RANGE = re.compile(rf"\s*({_NUMBER})\s*(?:\.\.\s*({_NUMBER})\s*)?")
_LONGEST = 200


def free_by_value(
    values: NDArray[Any], free: str | None, occupied: str | None
) -> NDArray[np.bool_]:
    """Select free cells by their value.

    Args:
        values: numbers of any kind, NaN where nothing is known.
        free: values that are free, as ``"0"``, ``"0..49"`` (both ends belong to it) or a list
            ``"0,205"``; None: all that ``occupied`` does not name.
        occupied: values that are not free, in the same form; None: all that ``free`` does not name.

    Returns:
        bool of the shape of ``values``; a value that both name is not free.

    Raises:
        WorldError: the text has another form, or nothing or all is selected.

    Example:
        >>> free_by_value(np.array([-1, 0, 30, 100]), "0..49", None).tolist()
        [False, True, True, False]
    """
    chosen = np.isfinite(values) if values.dtype.kind == "f" else np.ones(values.shape, np.bool_)
    if free is not None:
        chosen &= _within(values, "free", free)
    if occupied is not None:
        chosen &= ~_within(values, "occupied", occupied)
    if not chosen.any():
        low, high = np.nanmin(values), np.nanmax(values)
        asked = f"free = {free}" if free is not None else f"occupied = {occupied}"
        raise WorldError(f"{asked}: nothing is free: the values go from {low:g} to {high:g}")
    return chosen


def _within(values: NDArray[Any], name: str, text: str) -> NDArray[np.bool_]:
    found = np.zeros(values.shape, dtype=np.bool_)
    for part in text.split(",") if len(text) <= _LONGEST else [text]:
        match = _RANGE.fullmatch(part) if len(text) <= _LONGEST else None
        low = float(match[1]) if match else 0.0
        high = float(match[2]) if match and match[2] else low
        if match is None or high < low:
            raise WorldError(
                f"{name} = '{text[:40]}': expected a value as 0, a range as 0..49, or a list of "
                "these with commas"
            )
        found |= (values >= low) & (values <= high)
    return found
