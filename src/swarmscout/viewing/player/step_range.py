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
from swarmscout.robots.bodies import TICKS
from swarmscout.viewing.player.packets import differences, pack, smallest, with_differences

__all__ = ["ROBOT_COLUMNS", "StepRange", "pack_steps", "robot_columns", "short"]

ROBOT_COLUMNS = ("x", "y", "heading", "charge", "state", "leader", "desired", "destination")
"""Columns of whole numbers per robot and step; ``team`` is apart, for its ids are long.

``x``, ``y``: millimetres · ``heading``: tenths of a degree · ``charge``: thousandths ·
``state``: bit 0 CHR mode, bits 1–2 action, bits 3–4 contact, bit 5 alive (codes of
``core.codes``) · ``leader``: robot · ``desired``: team size · ``destination``: flat map cell or -1.
"""

LONGEST_TEXT = 20_000
"""Characters of a text that are handed to the page; what a model writes can be of any length."""

_SHOWN_EVENTS = [code for code in range(len(EVENTS)) if code != CONTACT]


@dataclass(slots=True)
class StepRange:
    """Some steps, in the page's units.

    Attributes:
        first: the first step.
        columns: int[n, N] for each of :data:`ROBOT_COLUMNS`.
        team: int64[n, N], team ids.
        map_counts: int[n], how many map cells changed in each step.
        map_cells: int[m], flat cells; map_log_odds: int[m], in 1/1000 nat.
        events: int[k, 5], rows of step, kind, robot, other, value.
        decisions: rows as plain data.
        coverage: float64[n] for each column of the table ``coverage``.
    """

    first: int
    columns: Mapping[str, NDArray[Any]]
    team: NDArray[np.int64]
    map_counts: NDArray[Any]
    map_cells: NDArray[Any]
    map_log_odds: NDArray[Any]
    events: NDArray[np.int64]
    decisions: Sequence[Mapping[str, Any]]
    coverage: Mapping[str, NDArray[np.float64]]


def robot_columns(
    x_m: NDArray[np.float64],
    y_m: NDArray[np.float64],
    heading_rad: NDArray[np.float64],
    charge: NDArray[np.float64],
    mode: NDArray[Any],
    action: NDArray[Any],
    contact: NDArray[Any],
    alive: NDArray[np.bool_],
    leader: NDArray[Any],
    desired: NDArray[Any],
    destination: NDArray[Any],
) -> dict[str, NDArray[Any]]:
    """Robots of one step [N] or of many [n, N] in the page's units; see :data:`ROBOT_COLUMNS`."""
    small = np.uint8
    state = (
        mode.astype(small)
        | (action.astype(small) << 1)
        | (contact.astype(small) << 3)
        | (alive.astype(small) << 5)
    )
    return {
        "x": np.rint(x_m * 1000.0).astype(np.int32),
        "y": np.rint(y_m * 1000.0).astype(np.int32),
        "heading": np.rint(heading_rad * (TICKS / (2.0 * np.pi))).astype(np.int32) % TICKS,
        "charge": np.rint(charge * 1000.0).astype(np.int16),
        "state": state,
        "leader": leader.astype(np.int32),
        "desired": desired.astype(np.int32),
        "destination": destination.astype(np.int32),
    }


def pack_steps(block: StepRange) -> bytes:
    """A block as a packet."""
    arrays: dict[str, NDArray[Any]] = {}
    for name in ROBOT_COLUMNS:
        arrays |= with_differences(name, block.columns[name])
    teams, index = np.unique(block.team, return_inverse=True)
    arrays |= with_differences("team", index.reshape(block.team.shape))
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
        "steps": len(block.team),
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
