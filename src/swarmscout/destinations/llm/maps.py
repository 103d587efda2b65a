"""Encodings that show the map: the paper's list of cells, run-length rows, or a drawn window."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from swarmscout.core.enums import FREE, OCCUPIED
from swarmscout.core.tokens import estimate_tokens
from swarmscout.destinations.llm.prompt_data import (
    Candidate,
    Encoded,
    cell_name,
    lines_within,
    names_of,
)
from swarmscout.destinations.llm.tables import encode_frontiers
from swarmscout.destinations.view import LeaderView

__all__ = ["encode_ascii", "encode_cells", "encode_rows"]

FREE_CELL, OBSTACLE_CELL, FRONTIER_CELL = 1, 2, 3
"""The paper's labels."""

WINDOW_M = 13.0
"""Edge of the window that ``ascii`` draws, in metres."""


def _labelled(view: LeaderView) -> NDArray[np.int64]:
    """int64[rows, cols]: the paper's labels; 0 where nothing is known."""
    labels = np.zeros(view.labels.shape, dtype=np.int64)
    labels[view.labels == FREE] = FREE_CELL
    labels[view.labels == OCCUPIED] = OBSTACLE_CELL
    labels[view.frontiers[:, 0], view.frontiers[:, 1]] = FRONTIER_CELL
    return labels


def _around(mask: NDArray[np.bool_]) -> NDArray[np.int64]:
    """int64[rows, cols]: number of each cell's 8 neighbours in a mask."""
    rows, cols = mask.shape
    wide = np.zeros((rows + 2, cols + 2), dtype=np.int64)
    wide[1:-1, 1:-1] = mask
    shifts = [(i, j) for i in range(3) for j in range(3) if (i, j) != (1, 1)]
    total: NDArray[np.int64] = sum(
        (wide[i : i + rows, j : j + cols] for i, j in shifts), start=np.zeros_like(wide[2:, 2:])
    )
    return total


def encode_cells(view: LeaderView, budget: int, order: NDArray[np.int64], features: str) -> Encoded:
    """The paper's list: every known cell with label, neighbours and distance.

    When the budget is short, cells go in this order: far free ground, far obstacles, far frontiers.

    Args:
        view: the leader's.
        budget: tokens.
        order: not used: cells stand in the order of the map.
        features: not used: the paper's.

    Source: paper, "LLM-based team destination determination".
    """
    labels = _labelled(view)
    frontiers, obstacles = _around(labels == FRONTIER_CELL), _around(labels == OBSTACLE_CELL)
    cells = np.argwhere(labels > 0)
    label = labels[cells[:, 0], cells[:, 1]]
    near_f = frontiers[cells[:, 0], cells[:, 1]]
    near_o = obstacles[cells[:, 0], cells[:, 1]]
    off = view.frame.centres_of(cells) - np.array(view.position_m)
    distance = np.sqrt(off[:, 0] ** 2 + off[:, 1] ** 2)
    lines = [
        f"(({x},{y}),{kind},({f},{o}),{away:.1f})"
        for (y, x), kind, f, o, away in zip(
            cells.tolist(), label.tolist(), near_f.tolist(), near_o.tolist(), distance.tolist(),
            strict=True,
        )
    ]  # fmt: skip
    # Free ground beside a frontier or an obstacle is more informative than other free ground.
    rank = np.select([label == FRONTIER_CELL, label == OBSTACLE_CELL, near_f + near_o > 0],
                     [3.0, 2.0, 1.0], 0.0)  # fmt: skip
    stay = lines_within(lines, rank * 1e6 - distance, budget)
    shown = stay[label[stay] == FRONTIER_CELL]
    return Encoded(
        "Each tuple is ((x,y), label, (frontier cells, obstacle cells among its 8 neighbours), "
        "distance in metres from your position). Labels: 1 explored free, 2 obstacle, 3 frontier.",
        "\n".join(lines[k] for k in stay.tolist()),
        _candidates(view, cells[shown]),
        dropped=len(lines) - len(stay),
    )


def encode_rows(view: LeaderView, budget: int, order: NDArray[np.int64], features: str) -> Encoded:
    """Run-length rows of the map, and a table of the frontiers.

    When the budget is short, rows far from the leader go first, then far frontiers.

    Args:
        view: the leader's.
        budget: tokens.
        order: int64[F], of the frontiers in the table.
        features: one of ``FEATURES``.
    """
    frontiers = encode_frontiers(view, int(0.6 * budget), order, features)
    labels = _labelled(view)
    own = view.frame.cell_of(*view.position_m)[0]
    rows = np.flatnonzero((labels > 0).any(axis=1))
    lines = [f"y={row}: " + " ".join(_runs(labels[row])) for row in rows.tolist()]
    left = budget - estimate_tokens(frontiers.text)
    stay = lines_within(lines, -np.abs(rows - own).astype(np.float64), max(0, left))
    hidden = [int((labels[row] > 0).sum()) for row in np.delete(rows, stay).tolist()]
    return Encoded(
        "The known map in rows: y, then runs of x as first-last and a letter: f free, o obstacle, "
        "F frontier; what is not named is unknown. Below it, a table. " + frontiers.legend,
        "\n".join([*(lines[k] for k in stay.tolist()), "", frontiers.text]),
        frontiers.candidates,
        dropped=frontiers.dropped + sum(hidden),
    )


def encode_ascii(view: LeaderView, budget: int, order: NDArray[np.int64], features: str) -> Encoded:
    """A drawn window of the map round the leader, and a table of the frontiers.

    When the budget is short, the window shrinks to half of it, and far frontiers go first.

    Args:
        view: the leader's.
        budget: tokens.
        order: int64[F], of the frontiers in the table.
        features: one of ``FEATURES``.
    """
    labels = _labelled(view)
    signs = np.array([" ", ".", "#", "F"])[labels]
    for x_m, y_m in view.others.positions_m.tolist():
        row, col = view.frame.cell_of(x_m, y_m)
        if view.frame.contains(row, col):
            signs[row, col] = "T"
    row, col = view.frame.cell_of(*view.position_m)
    if view.frame.contains(row, col):
        signs[row, col] = "L"
    half = int(0.5 * WINDOW_M / view.frame.cell_m)
    while True:
        low, high = max(0, row - half), min(view.frame.rows, row + half + 1)
        left, right = max(0, col - half), min(view.frame.columns, col + half + 1)
        drawn = "\n".join(
            f"y={r:<4d}|{''.join(signs[r, left:right])}|" for r in range(high - 1, low - 1, -1)
        )
        if half <= 1 or estimate_tokens(drawn) <= budget // 2:
            break
        half -= 1
    table = encode_frontiers(view, budget - estimate_tokens(drawn), order, features)
    return Encoded(
        f"A drawn window of the map, north up, x from {left} (left) to {right - 1} (right): "
        "'.' free, '#' obstacle, 'F' frontier, 'L' you, 'T' another team, blank unknown. "
        "Below it, a table of frontiers, also of those outside the window. " + table.legend,
        f"{drawn}\n\n{table.text}",
        table.candidates,
        dropped=table.dropped,
    )


def _candidates(view: LeaderView, cells: NDArray[np.int64]) -> tuple[Candidate, ...]:
    """Cells as candidates; the nearest frontier if none is left."""
    if len(cells) == 0:
        return names_of(view, np.array([int(np.argmin(view.distances_m))]))
    return tuple(Candidate(cell_name(cell), (int(cell[0]), int(cell[1]))) for cell in cells)


def _runs(row: NDArray[np.int64]) -> list[str]:
    edges = np.flatnonzero(np.diff(row)) + 1
    starts = [0, *edges.tolist()]
    ends = [*edges.tolist(), len(row)]
    letters = " foF"
    return [
        f"{first}-{last - 1}{letters[row[first]]}" if last - first > 1
        else f"{first}{letters[row[first]]}"
        for first, last in zip(starts, ends, strict=True)
        if row[first] > 0
    ]  # fmt: skip
