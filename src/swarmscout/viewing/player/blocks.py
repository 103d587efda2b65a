"""Blocks: some steps of a mission as one packet.

A block can be read without the blocks before it, except that the map goes on from theirs. A
recorded run is one block, a mission that is being watched sends many small ones.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from swarmscout.core.enums import CONTACT, EVENTS
from swarmscout.recording.tables import TABLES, Column
from swarmscout.robots.bodies import TICKS
from swarmscout.viewing.player.packets import differences, pack, smallest, with_differences

__all__ = ["Block", "pack_block", "robot_columns", "short", "whole_numbers"]

LONGEST_TEXT = 20_000
"""Characters of a text that are handed to the page; what a model writes can be of any length."""

_SHOWN_EVENTS = [code for code in range(len(EVENTS)) if code != CONTACT]


@dataclass(slots=True)
class Block:
    """Some steps, in the page's units.

    Attributes:
        first: the first step.
        columns: int[n, N] for each of :func:`robot_columns`, see :func:`whole_numbers`.
        map_counts: int[n], how many map cells changed in each step.
        map_cells: int[m], flat cells; map_log_odds: int[m], in 1/1000 nat.
        events: int[k, 5], rows of step, kind, robot, other, value.
        decisions: rows as plain data.
        coverage: float64[n] for each column of the table ``coverage``.
    """

    first: int
    columns: Mapping[str, NDArray[Any]]
    map_counts: NDArray[Any]
    map_cells: NDArray[Any]
    map_log_odds: NDArray[Any]
    events: NDArray[np.int64]
    decisions: Sequence[Mapping[str, Any]]
    coverage: Mapping[str, NDArray[np.float64]]


def robot_columns() -> list[Column]:
    """The recorded columns per robot and step, which the page gets as whole numbers.

    Metres become millimetres, radians tenths of a degree, shares thousandths, words their codes
    (``facts.words``), and team ids places in the block's ``teams``.
    """
    return [column for column in TABLES["steps"].columns if column.name not in ("step", "robot")]


def whole_numbers(column: Column, values: NDArray[Any]) -> NDArray[Any]:
    """A recorded column in the page's units, see :func:`robot_columns`; team ids as they are."""
    if column.unit == "rad":
        return np.rint(values * (TICKS / (2.0 * np.pi))).astype(np.int32) % TICKS
    scaled = np.rint(values * 1000.0) if column.kind == "float64" else values
    return scaled.astype(np.int64 if column.kind == "int64" else np.int32)


def pack_block(block: Block) -> bytes:
    """A block as a packet."""
    arrays: dict[str, NDArray[Any]] = {}
    teams, index = np.unique(block.columns["team"], return_inverse=True)
    for name, values in block.columns.items():
        packed = index.reshape(values.shape) if name == "team" else values
        arrays |= with_differences(name, packed)
    arrays["map.counts"] = block.map_counts.astype(np.uint32)
    # Cells are in ascending order within a step: differences are small.
    arrays["map.cells"] = smallest(differences(block.map_cells))
    arrays["map.log_odds"] = block.map_log_odds.astype(np.int16)
    shown = block.events[np.isin(block.events[:, 1], _SHOWN_EVENTS)]
    for column, name in enumerate(("step", "kind", "robot", "other")):
        arrays[f"events.{name}"] = smallest(shown[:, column])
    arrays["events.value"] = shown[:, 4].astype(np.float64)
    for name, values in block.coverage.items():
        arrays[f"coverage.{name}"] = values.astype(np.float64)
    facts = {
        "first": block.first,
        "steps": len(block.columns["team"]),
        "columns": list(block.columns),
        "teams": teams.tolist(),
        "decisions": [short(row) for row in block.decisions],
        "coverage": list(block.coverage),
    }
    return pack(facts, arrays)


def short(value: Any) -> Any:
    """Plain data with its long texts cut, and without numbers that JSON does not have."""
    if isinstance(value, str):
        if len(value) <= LONGEST_TEXT:
            return value
        return f"{value[:LONGEST_TEXT]} … ({len(value):,} characters, cut)"
    if isinstance(value, Mapping):
        return {str(key): short(inner) for key, inner in value.items()}
    if isinstance(value, list | tuple):
        return [short(inner) for inner in value]
    if isinstance(value, float) and not np.isfinite(value):
        return None
    return value
