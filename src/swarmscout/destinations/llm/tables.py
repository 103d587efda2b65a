"""Encodings that show candidates only: frontier cells, or pieces of the frontier, with features."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from swarmscout.destinations.llm.features import columns_of
from swarmscout.destinations.llm.fronts import pieces_of
from swarmscout.destinations.llm.prompt_data import (
    Candidate,
    Encoded,
    cell_name,
    lines_within,
    names_of,
)
from swarmscout.destinations.view import LeaderView

__all__ = ["encode_clusters", "encode_frontiers", "number"]

_MEANINGS = {
    "distance_m": "straight distance from your position",
    "frontier_neighbours": "frontier cells among its 8 neighbours",
    "obstacle_neighbours": "obstacle cells among its 8 neighbours",
    "way_m": "length of the shortest known way (none: no known way)",
    "turn_deg": "how far you have to turn for it",
    "unknown_m2": "unknown area within 2 m of it",
    "nearest_other_destination_m": "distance to the nearest destination of another team",
    "cells": "frontier cells in the group",
}


def number(value: float) -> str:
    """A feature in its shortest form; ``none`` for infinity."""
    return f"{value:g}" if np.isfinite(value) else "none"


def _table(
    names: list[str], columns: Mapping[str, NDArray[np.float64]], picked: NDArray[np.int64]
) -> list[str]:
    """A line for each picked row: its name and its features."""
    return [
        f"{names[k]} | " + " | ".join(number(column[k]) for column in columns.values())
        for k in picked.tolist()
    ]


def _head(columns: Mapping[str, NDArray[np.float64]]) -> tuple[str, str]:
    """A table's header, and the meanings of its columns."""
    meaning = "; ".join(f"{name}: {_MEANINGS[name]}" for name in columns)
    return "id | " + " | ".join(columns), meaning


def encode_frontiers(
    view: LeaderView, budget: int, order: NDArray[np.int64], features: str
) -> Encoded:
    """Every frontier cell with its features; far ones go first when the budget is short.

    Args:
        view: the leader's.
        budget: tokens.
        order: int64[F], the order in which frontiers are shown.
        features: one of ``FEATURES``.
    """
    columns = columns_of(view, features)
    names = [cell_name(cell) for cell in view.frontiers]
    headline, meaning = _head(columns)
    lines = _table(names, columns, order)
    stay = lines_within(lines, -view.distances_m[order], budget)
    return Encoded(
        "Each line is a frontier cell, named by its coordinate x,y. " + meaning + ".",
        "\n".join([headline, *(lines[k] for k in stay.tolist())]),
        names_of(view, order[stay]),
        dropped=len(lines) - len(stay),
    )


def encode_clusters(
    view: LeaderView, budget: int, order: NDArray[np.int64], features: str
) -> Encoded:
    """Pieces of the frontier, 2 to 3 m long, each shown as the cell that is nearest to its middle.

    Args:
        view: the leader's.
        budget: tokens.
        order: int64[F], the order in which frontiers are shown; pieces come by their first cell.
        features: one of ``FEATURES``, of the cell in the middle.
    """
    heads, sizes = [], []
    seen: set[int] = set()
    pieces = pieces_of(view.frontiers, view.frame.cell_m)
    for frontier in order.tolist():
        cluster = int(pieces[frontier])
        if cluster in seen:
            continue
        seen.add(cluster)
        cells = np.flatnonzero(pieces == cluster)
        off = view.frontiers_m[cells] - view.frontiers_m[cells].mean(axis=0)
        heads.append(int(cells[np.argmin((off**2).sum(axis=1))]))
        sizes.append(float(len(cells)))
    picked = np.array(heads, dtype=np.int64)
    columns = {name: column[picked] for name, column in columns_of(view, features).items()}
    columns = {"cells": np.array(sizes), **columns}
    names = [f"C{k + 1}" for k in range(len(heads))]
    headline, meaning = _head(columns)
    lines = [
        f"{line} | ({cell_name(view.frontiers[frontier])})"
        for line, frontier in zip(_table(names, columns, np.arange(len(heads))), heads, strict=True)
    ]
    stay = lines_within(lines, -view.distances_m[picked], budget)
    cells_of = view.frontiers[picked].tolist()
    return Encoded(
        "Each line is a group of touching frontier cells. " + meaning + "; last the coordinate "
        "(x,y) of its middle, for which the features hold.",
        "\n".join([f"{headline} | middle", *(lines[k] for k in stay.tolist())]),
        tuple(Candidate(names[k], (cells_of[k][0], cells_of[k][1])) for k in stay.tolist()),
        dropped=len(lines) - len(stay),
    )
