"""The result of an encoding: a text, and the candidates in it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from swarmscout.core.tokens import estimate_tokens
from swarmscout.destinations.view import LeaderView

__all__ = ["Candidate", "Encoded", "cell_name", "lines_within", "names_of"]

Cell = tuple[int, int]


@dataclass(frozen=True, slots=True)
class Candidate:
    """A destination that can be chosen.

    Attributes:
        id: its name in the prompt.
        cell: its ``(row, col)``.
    """

    id: str
    cell: Cell


@dataclass(frozen=True, slots=True)
class Encoded:
    """A view, written down.

    Attributes:
        legend: how to read the text.
        text: the map or the candidates.
        candidates: in the order in which the text shows them.
        dropped: cells left out for the token budget.
        closed: whether only candidates may be chosen; else any frontier of the view.
    """

    legend: str
    text: str
    candidates: tuple[Candidate, ...]
    dropped: int = 0
    closed: bool = False


def cell_name(cell: Sequence[int] | NDArray[np.int64]) -> str:
    """A cell ``(row, col)`` as ``"x,y"``: column first, as points are written."""
    return f"{int(cell[1])},{int(cell[0])}"


def names_of(view: LeaderView, picked: NDArray[np.int64]) -> tuple[Candidate, ...]:
    """Frontiers of a view, by their indices, as candidates named by their cells."""
    cells = view.frontiers[picked].tolist()
    return tuple(Candidate(cell_name(cell), (cell[0], cell[1])) for cell in cells)


def lines_within(
    lines: Sequence[str], worth: NDArray[np.float64], budget: int
) -> NDArray[np.int64]:
    """The lines that fit into a token budget, without the least informative ones.

    Args:
        lines: one per cell.
        worth: float64[n], how informative each line is; ties are broken by their order.
        budget: tokens.

    Returns:
        int64[k], indices of the lines that stay, ascending; at least one.
    """
    tokens = np.array([estimate_tokens(line) + 1 for line in lines], dtype=np.int64)
    order = np.argsort(-worth, kind="stable")
    stay = int(np.searchsorted(np.cumsum(tokens[order]), budget, side="right"))
    return np.sort(order[: max(1, stay)])
