"""A chunk: the rows of up to fifty steps, copied out of the mission into arrays made beforehand.

A step costs a dozen array copies and no Python object per row; the tables are made of whole arrays
when the chunk is closed. What a step adds counts only from the last line of :meth:`Chunk.add` on,
so an interrupt in the middle of it leaves the chunk as it was before the step.
"""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from swarmscout.core.codes import ACTIONS, EVENTS, MODES
from swarmscout.core.errors import SelectorError
from swarmscout.core.recorder import Decision, StepRecord
from swarmscout.recording.attempts import attempts_frame
from swarmscout.recording.tables import CONTACTS, schema_of, words

if TYPE_CHECKING:
    import polars as pl

__all__ = ["Chunk", "plain"]

_PLAIN = frozenset({int, str, bool, type(None)})
_to_json = json.JSONEncoder(sort_keys=True).encode


def plain(value: Any) -> Any:
    """A value as plain data for JSON: NumPy numbers and arrays unwrapped, NaN and ∞ as null."""
    kind = type(value)
    if kind is float:  # First what is met most: whether something is a Mapping takes longest.
        return value if math.isfinite(value) else None
    if kind in _PLAIN:
        return value
    if isinstance(value, Mapping):
        return {str(key): plain(inner) for key, inner in value.items()}
    if isinstance(value, list | tuple):
        return [plain(inner) for inner in value]
    if isinstance(value, np.ndarray | np.generic):
        return plain(value.tolist())
    if isinstance(value, float):
        return float(value) if math.isfinite(value) else None
    return value if value is None or isinstance(value, bool | int | str) else str(value)


class _Rows:
    """Integer rows of which each step adds any number; the array doubles when it is full."""

    def __init__(self, columns: int) -> None:
        self.array = np.empty((256, columns), dtype=np.int64)

    def put(self, at: int, step: int, *columns: NDArray[np.int64]) -> int:
        """Write rows ``(step, *columns)`` from row ``at`` on; return where they end."""
        end = at + len(columns[0])
        if end > len(self.array):
            wider = np.empty((max(end, 2 * len(self.array)), self.array.shape[1]), dtype=np.int64)
            wider[:at] = self.array[:at]
            self.array = wider
        self.array[at:end, 0] = step
        for index, column in enumerate(columns, start=1):
            self.array[at:end, index] = column
        return end


class Chunk:
    """Room for the rows of some steps.

    Args:
        robots: N, the number of robots.
        steps: how many steps fit.
        columns: columns of the map, for flat cells.
        tables: which tables are kept.
    """

    def __init__(self, robots: int, steps: int, columns: int, tables: tuple[str, ...]) -> None:
        self.capacity = steps
        self._robots = robots
        self._columns = columns
        self._tables = tables
        self._has = frozenset(tables)
        rows = steps if "steps" in tables else 0
        self._step = np.zeros(steps, dtype=np.int32)
        self._pose = np.empty((rows, robots, 3), dtype=np.float64)
        self._charge = np.empty((rows, robots), dtype=np.float64)
        self._codes = np.empty((3, rows, robots), dtype=np.uint8)
        self._alive = np.empty((rows, robots), dtype=np.bool_)
        self._team = np.empty((rows, robots), dtype=np.int64)
        self._small = np.empty((4, rows, robots), dtype=np.int32)
        self._events = _Rows(5)
        self._changes = _Rows(3)
        self._evidence = _Rows(4)
        self._link_changes = _Rows(4)
        self._links = np.zeros((robots, robots) if "links" in tables else (0, 0), dtype=np.bool_)
        self._decisions: list[tuple[Decision, dict[str, Any]]] = []
        self._coverage: list[Mapping[str, float | int]] = []
        self._timing: list[Mapping[str, float]] = []
        # Steps, events, map changes, decisions, evidence and changes of links that count.
        self._ends = (0, 0, 0, 0, 0, 0)

    @property
    def length(self) -> int:
        """Steps in the chunk."""
        return self._ends[0]

    def clear(self) -> None:
        """Forget all rows; the arrays are used again."""
        self._ends = (0, 0, 0, 0, 0, 0)

    def add(self, record: StepRecord) -> None:
        """Copy one step."""
        at, events, changes, decisions, evidence, link_changes = self._ends
        links = self._links
        self._step[at] = record.step
        if "steps" in self._has:
            self._pose[at] = record.pose
            self._charge[at] = record.charge
            self._codes[0, at] = record.mode
            self._codes[1, at] = record.action
            self._codes[2, at] = record.contact
            self._alive[at] = record.alive
            self._team[at] = record.team
            self._small[0, at] = record.leader
            self._small[1, at] = record.desired
            self._small[2, at] = record.destination
            self._small[3, at] = record.target
        if "events" in self._has and len(record.events):
            events = self._events.put(events, record.step, *record.events.T)
        if "map_changes" in self._has and len(record.map_cells):
            changes = self._changes.put(changes, record.step, record.map_cells, record.map_log_odds)
        if "evidence" in self._has and record.evidence is not None:
            evidence = self._evidence.put(evidence, record.step, *record.evidence.T)
        if "links" in self._has and record.links is not None:
            links = record.links & ~np.eye(self._robots, dtype=np.bool_)
            listener, speaker = np.nonzero(links != self._links)
            hears = links[listener, speaker].astype(np.int64)
            link_changes = self._link_changes.put(
                link_changes, record.step, listener, speaker, hears
            )
        if "decisions" in self._has and record.decisions:
            # Details are copied now: a selector may go on using the mapping it gave.
            told = [(d, _details(d)) for d in record.decisions]
            self._decisions[decisions:] = told
            decisions += len(told)
        self._coverage[at:] = [dict(record.coverage)]
        self._timing[at:] = [dict(record.seconds)]
        self._links = links
        self._ends = (at + 1, events, changes, decisions, evidence, link_changes)

    def frames(self, coverage_types: Mapping[str, Any]) -> dict[str, pl.DataFrame]:
        """The chunk as tables.

        Args:
            coverage_types: Polars types of the coverage columns beside ``step``.

        Returns:
            A frame for each table that is kept, some perhaps without rows.
        """
        make: dict[str, Callable[[], pl.DataFrame]] = {
            "steps": self._steps_frame,
            "map_changes": lambda: _whole_numbers("map_changes", self._changes, self._ends[2]),
            "evidence": lambda: _whole_numbers("evidence", self._evidence, self._ends[4]),
            "links": lambda: _whole_numbers("links", self._link_changes, self._ends[5]),
            "decisions": self._decisions_frame,
            "attempts": lambda: attempts_frame(
                (d for d, _ in self._decisions[: self._ends[3]]), self._columns
            ),
            "events": self._events_frame,
            "timing": self._timing_frame,
            "coverage": lambda: self._coverage_frame(coverage_types),
        }
        return {table: make[table]() for table in self._tables}

    def coverage_types(self) -> dict[str, Any]:
        """Polars types of the coverage columns: Int64 for whole numbers, else Float64.

        The first step of a mission fixes them for all of its parts.
        """
        import polars as pl

        return {
            name: pl.Int64 if isinstance(value, int | np.integer) else pl.Float64
            for name, value in self._coverage[0].items()
        }

    def _steps_frame(self) -> pl.DataFrame:
        import polars as pl

        n = self.length
        codes = self._codes[:, :n].reshape(3, -1)
        small = self._small[:, :n].reshape(4, -1)
        pose = self._pose[:n].reshape(-1, 3)
        return pl.DataFrame(
            {
                "step": np.repeat(self._step[:n], self._robots),
                "robot": np.tile(np.arange(self._robots, dtype=np.int32), n),
                "x_m": np.ascontiguousarray(pose[:, 0]),
                "y_m": np.ascontiguousarray(pose[:, 1]),
                "heading_rad": np.ascontiguousarray(pose[:, 2]),
                "charge": self._charge[:n].flatten(),
                "mode": words(codes[0], MODES),
                "action": words(codes[1], ACTIONS),
                "contact": words(codes[2], CONTACTS),
                "alive": self._alive[:n].flatten(),
                "team": self._team[:n].flatten(),
                "leader": small[0].copy(),
                "desired": small[1].copy(),
                "destination": small[2].copy(),
                "target": small[3].copy(),
            },
            schema=schema_of("steps"),
        )

    def _events_frame(self) -> pl.DataFrame:
        import polars as pl

        rows = self._events.array[: self._ends[1]]
        return pl.DataFrame(
            {
                "step": rows[:, 0].astype(np.int32),
                "kind": words(rows[:, 1], EVENTS),
                "robot": rows[:, 2].astype(np.int32),
                "other": rows[:, 3].astype(np.int32),
                "value": rows[:, 4].copy(),
            },
            schema=schema_of("events"),
        )

    def _decisions_frame(self) -> pl.DataFrame:
        import polars as pl

        rows = [
            (
                d.step,
                d.team,
                d.leader,
                d.cause,
                d.selector,
                None if d.cell is None else d.cell[0] * self._columns + d.cell[1],
                *((None, None, None) if d.cell is None else (d.x_m, d.y_m, d.distance_m)),
                d.frontiers,
                d.frontier_neighbours,
                d.obstacle_neighbours,
                # Half a surrogate pair is no text that a file could hold.
                str(d.reason).encode(errors="replace").decode(),
                _to_json(details) if details else "{}",
            )
            for d, details in self._decisions[: self._ends[3]]
        ]
        schema = schema_of("decisions")
        columns = zip(*rows, strict=True) if rows else ((),) * len(schema)
        return pl.DataFrame(dict(zip(schema, columns, strict=True)), schema=schema)

    def _coverage_frame(self, types: Mapping[str, Any]) -> pl.DataFrame:
        import polars as pl

        rows = self._coverage[: self.length]
        columns = {name: [row[name] for row in rows] for name in types}
        return pl.DataFrame(
            {"step": self._step[: self.length].copy(), **columns},
            schema={**schema_of("coverage"), **types},
        )

    def _timing_frame(self) -> pl.DataFrame:
        import polars as pl

        rows = self._timing[: self.length]
        names = list(dict.fromkeys(name for row in rows for name in row))
        return pl.DataFrame(
            {
                "step": self._step[: self.length].copy(),
                **{f"{name}_s": [row.get(name) for row in rows] for name in names},
            },
            schema={**schema_of("timing"), **{f"{name}_s": pl.Float64 for name in names}},
        )


def _details(decision: Decision) -> dict[str, Any]:
    """A decision's details as plain data; most have none."""
    if not decision.details:
        return {}
    try:
        copied: dict[str, Any] = plain(decision.details)
    except RecursionError:
        raise SelectorError(
            f"selector '{decision.selector}' gave details that hold themselves (step "
            f"{decision.step}, robot {decision.leader}); give plain data"
        ) from None
    return copied


def _whole_numbers(table: str, rows: _Rows, end: int) -> pl.DataFrame:
    import polars as pl

    schema = schema_of(table)
    return pl.DataFrame(
        {
            name: rows.array[:end, i].astype(np.bool_ if name == "hears" else np.int32)
            for i, name in enumerate(schema)
        },
        schema=schema,
    )
