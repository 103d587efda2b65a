"""Ranges of steps, each as one packet.

A range can be read without those before it, except that the map continues from theirs. A recorded
run is one range; a live mission sends many small ones.
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
from swarmscout.viewing.player.page_text import page_data

__all__ = ["StepRange", "pack_steps", "robot_columns", "whole_numbers"]


_SHOWN_EVENTS = [code for code in range(len(EVENTS)) if code != CONTACT]


@dataclass(slots=True)
class StepRange:
    """A range of steps, in the page's units.

    Attributes:
        first: the first step.
        columns: int[n, N] for each of :func:`robot_columns`, see :func:`whole_numbers`.
        map_counts: int[n], number of map cells that changed in each step.
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


def pack_steps(steps: StepRange) -> bytes:
    """A range of steps as a packet."""
    arrays: dict[str, NDArray[Any]] = {}
    teams, index = np.unique(steps.columns["team"], return_inverse=True)
    for name, values in steps.columns.items():
        packed = index.reshape(values.shape) if name == "team" else values
        arrays |= with_differences(name, packed)
    arrays["map.counts"] = steps.map_counts.astype(np.uint32)
    # Cells are in ascending order within a step: differences are small.
    arrays["map.cells"] = smallest(differences(steps.map_cells))
    arrays["map.log_odds"] = steps.map_log_odds.astype(np.int16)
    shown = steps.events[np.isin(steps.events[:, 1], _SHOWN_EVENTS)]
    for column, name in enumerate(("step", "kind", "robot", "other")):
        arrays[f"events.{name}"] = smallest(shown[:, column])
    arrays["events.value"] = shown[:, 4].astype(np.float64)
    for name, values in steps.coverage.items():
        arrays[f"coverage.{name}"] = values.astype(np.float64)
    facts = {
        "first": steps.first,
        "steps": len(steps.columns["team"]),
        "columns": list(steps.columns),
        "teams": teams.tolist(),
        "decisions": [page_data(row) for row in steps.decisions],
        "coverage": list(steps.coverage),
    }
    return pack(facts, arrays)
