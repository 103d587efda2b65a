"""Numbers in text, many at a time."""

from __future__ import annotations

import warnings
from typing import Any

import numpy as np
from numpy.typing import NDArray

__all__ = ["numbers"]


def numbers(text: bytes | str, dtype: type, count: int | None = None) -> NDArray[Any]:
    """Read numbers that are separated by white space.

    Args:
        text: the numbers, and nothing else.
        dtype: ``np.float64`` or ``np.int64``; digits beyond the range become infinite, or the
            largest number.
        count: how many are expected, or None for any.

    Raises:
        ValueError: something is not a number of this kind, or there are more or fewer.
    """
    text = text.strip()
    found: NDArray[Any] = np.empty(0, dtype=dtype)
    with warnings.catch_warnings():
        warnings.simplefilter("error", DeprecationWarning)
        try:
            if text:
                found = np.fromstring(text, dtype=dtype, sep=" ")
        except DeprecationWarning:
            raise ValueError("something is not a number") from None
    if count is not None and len(found) != count:
        raise ValueError(f"{len(found):,} numbers where {count:,} are expected")
    return found
