"""Cells taken one after the other, none of them too near to one that was taken before."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from swarmscout.core.grid import GridFrame

__all__ = ["take_apart"]

_AT_ONCE = 1024
"""Candidates that are looked at together: most are near a place that was taken before."""


def take_apart(
    candidates: NDArray[np.int64], frame: GridFrame, spacing_m: float, wanted: int
) -> NDArray[np.int64]:
    """Take candidates in order, leaving out those too near to one that was taken.

    Each cell that is taken marks those round it. So the time grows with the candidates and with
    the area that is marked, not with one times the other.

    Args:
        candidates: int64[n], flat cells.
        frame: the grid.
        spacing_m: the least distance of two cells' centres.
        wanted: how many to take at most.

    Returns:
        int64[m, 2] cells (row, column), ``m <= wanted``.
    """
    reach = spacing_m / frame.cell_m
    about = math.ceil(reach)
    down, across = np.mgrid[-about : about + 1, -about : about + 1]
    near = down**2 + across**2 < reach**2 - 1e-9
    taken = np.zeros((frame.rows + 2 * about, frame.columns + 2 * about), dtype=np.bool_)
    chosen: list[tuple[int, int]] = []
    for begin in range(0, len(candidates), _AT_ONCE):
        rows, columns = np.divmod(candidates[begin : begin + _AT_ONCE], frame.columns)
        left = ~taken[rows + about, columns + about]
        for row, col in zip(rows[left].tolist(), columns[left].tolist(), strict=True):
            if taken[row + about, col + about]:
                continue
            chosen.append((row, col))
            if len(chosen) == wanted:
                return np.array(chosen, dtype=np.int64)
            taken[row : row + 2 * about + 1, col : col + 2 * about + 1] |= near
    return np.array(chosen, dtype=np.int64).reshape(-1, 2)
