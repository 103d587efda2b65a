"""Frontiers cut into pieces of a few metres, so that a long front is more than one candidate."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterator

import numpy as np
from numpy.typing import NDArray

__all__ = ["EXTENT_M", "pieces_of"]

EXTENT_M = 2.5
"""Longest extent of a piece along its front, give or take a cell's diagonal."""

Cell = tuple[int, int]


def pieces_of(cells: NDArray[np.int64], cell_m: float) -> NDArray[np.int64]:
    """Cut touching cells into pieces along their front.

    A group of touching cells is measured from one of its ends: cells equally many moves from it,
    give or take :data:`EXTENT_M`, and touching each other make a piece.

    Args:
        cells: int64[F, 2], ``(row, col)`` of frontier cells.
        cell_m: edge of a cell, in metres.

    Returns:
        int64[F], the piece of each cell, numbered in the order of their first cells.
    """
    index = {(row, col): k for k, (row, col) in enumerate(cells.tolist())}
    width = max(1, int(EXTENT_M / cell_m))
    band: dict[Cell, tuple[int, int]] = {}
    for group, cell in enumerate(index):
        if cell in band:
            continue
        end = list(_moves(cell, index.__contains__))[-1][0]
        moves = dict(_moves(end, index.__contains__))
        length = max(moves.values()) + 1
        parts = -(-length // width)
        band |= {one: (group, away * parts // length) for one, away in moves.items()}
    piece = np.full(len(cells), -1, dtype=np.int64)
    number = 0
    for cell, k in index.items():
        if piece[k] >= 0:
            continue
        same = band[cell]
        for one, _ in _moves(cell, lambda other, same=same: band.get(other) == same):  # type: ignore[misc]
            piece[index[one]] = number
        number += 1
    return piece


def _moves(start: Cell, inside: Callable[[Cell], bool]) -> Iterator[tuple[Cell, int]]:
    """Cells that can be reached, the nearest first, each with its number of moves."""
    away = {start: 0}
    waiting = deque([start])
    while waiting:
        row, col = cell = waiting.popleft()
        yield cell, away[cell]
        for i in (-1, 0, 1):
            for j in (-1, 0, 1):
                other = (row + i, col + j)
                if other not in away and inside(other):
                    away[other] = away[cell] + 1
                    waiting.append(other)
