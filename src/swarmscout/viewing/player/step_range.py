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
from swarmscout.robots.bodies import TICKS
from swarmscout.viewing.player.packets import differences, pack, smallest, with_differences
from swarmscout.viewing.player.page_text import page_data

__all__ = ["ROBOT_COLUMNS", "StepRange", "pack_steps", "robot_columns"]

ROBOT_COLUMNS = ("x", "y", "heading", "charge", "state", "leader", "desired", "destination")
"""Columns of whole numbers per robot and step; ``team`` is apart, for its ids are long.

``x``, ``y``: millimetres · ``heading``: tenths of a degree · ``charge``: thousandths ·
``state``: bit 0 CHR mode, bits 1–2 action, bits 3–4 contact, bit 5 alive (codes of
``core.codes``) · ``leader``: robot · ``desired``: team size · ``destination``: flat map cell or -1.
"""


_SHOWN_EVENTS = [code for code in range(len(EVENTS)) if code != CONTACT]


@dataclass(slots=True)
class StepRange:
    """A range of steps, in the page's units.

    Attributes:
        first: the first step.
        columns: int[n, N] for each of :data:`ROBOT_COLUMNS`.
        team: int64[n, N], team ids.
        map_counts: int[n], number of map cells that changed in each step.
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


def pack_steps(steps: StepRange) -> bytes:
    """A range of steps as a packet."""
    arrays: dict[str, NDArray[Any]] = {}
    for name in ROBOT_COLUMNS:
        arrays |= with_differences(name, steps.columns[name])
    teams, index = np.unique(steps.team, return_inverse=True)
    arrays |= with_differences("team", index.reshape(steps.team.shape))
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
        "steps": len(steps.team),
        "teams": teams.tolist(),
        "decisions": [page_data(row) for row in steps.decisions],
        "coverage": list(steps.coverage),
    }
    return pack(facts, arrays)
