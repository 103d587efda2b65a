"""A chunk: the rows of up to fifty steps, copied out of the mission.

What there is a row of for each robot, event or cell is copied into arrays made beforehand: a dozen
copies a step, and no Python object per row. What there is once a step is kept as it came. Tables
are made of the whole when the chunk is closed. A step counts only from the last line of
:meth:`Chunk.add` on, so an interrupt in the middle of it leaves the chunk as it was before.
"""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from itertools import chain
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from swarmscout.core.enums import ACTIONS, EVENTS, MODES
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


class _Ends(NamedTuple):
    """How many rows count of what has any number of them in a step."""

    events: int = 0
    changes: int = 0
    evidence: int = 0
    link_changes: int = 0


class _Step(NamedTuple):
    """What is kept of a step beside its rows in arrays."""

    step: int
    coverage: Mapping[str, float | int]
    seconds: Mapping[str, float]
    decisions: Sequence[tuple[Decision, dict[str, Any]]]
    ends: _Ends


_NO_ROWS = _Ends()


class Chunk:
    """Room for the rows of some steps.

    Args:
        robots: N, the number of robots.
        steps: how many steps fit.
        columns: columns of the map, for flat cells.
        tables: which tables are kept.
    """

    def __init__(self, robots: int, steps: int, columns: int, tables: tuple[str, ...]) -> None:
        self._capacity = steps
        self._robots = robots
        self._columns = columns
        self._tables = tables
        self._has_arrays = bool({*tables} - {"decisions", "attempts", "timing", "coverage"})
        rows = steps if "steps" in tables else 0
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
        self._steps: list[_Step] = []

    @property
    def length(self) -> int:
        """Steps in the chunk."""
        return len(self._steps)

    @property
    def full(self) -> bool:
        """Whether no further step fits."""
        return len(self._steps) == self._capacity

    def clear(self) -> None:
        """Forget all rows; the arrays are used again."""
        self._steps = []

    def add(self, record: StepRecord) -> None:
        """Keep one step."""
        ends, links = _NO_ROWS, self._links
        if self._has_arrays:
            ends, links = self._copy(record)
        told: Sequence[tuple[Decision, dict[str, Any]]] = ()
        if record.decisions:
            # Details are copied now: a selector may go on using the mapping it gave.
            told = [(decision, _details(decision)) for decision in record.decisions]
        step = _Step(record.step, record.coverage, record.seconds, told, ends)
        self._links = links
        self._steps.append(step)

    def _copy(self, record: StepRecord) -> tuple[_Ends, NDArray[np.bool_]]:
        """Copy a step's rows behind those that count; return where they end, and its links."""
        at, tables, links = len(self._steps), self._tables, self._links
        events, changes, evidence, link_changes = self._ends
        if "steps" in tables:
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
        if "events" in tables and len(record.events):
            events = self._events.put(events, record.step, *record.events.T)
        if "map_changes" in tables and len(record.map_cells):
            changes = self._changes.put(changes, record.step, record.map_cells, record.map_log_odds)
        if "evidence" in tables and record.evidence is not None:
            evidence = self._evidence.put(evidence, record.step, *record.evidence.T)
        if "links" in tables and record.links is not None:
            links = record.links & ~np.eye(self._robots, dtype=np.bool_)
            listener, speaker = np.nonzero(links != self._links)
            hears = links[listener, speaker].astype(np.int64)
            link_changes = self._link_changes.put(
                link_changes, record.step, listener, speaker, hears
            )
        return _Ends(events, changes, evidence, link_changes), links

    @property
    def _ends(self) -> _Ends:
        return self._steps[-1].ends if self._steps else _NO_ROWS

    def _told(self) -> Iterator[tuple[Decision, dict[str, Any]]]:
        return chain.from_iterable(step.decisions for step in self._steps)

    def _step_column(self) -> NDArray[np.int32]:
        return np.array([step.step for step in self._steps], dtype=np.int32)

    def frames(self, coverage_types: Mapping[str, Any]) -> dict[str, pl.DataFrame]:
        """The chunk as tables.

        Args:
            coverage_types: Polars types of the coverage columns beside ``step``.

        Returns:
            A frame for each table that is kept, some perhaps without rows.
        """
        make: dict[str, Callable[[], pl.DataFrame]] = {
            "steps": self._steps_frame,
            "map_changes": lambda: _whole_numbers("map_changes", self._changes, self._ends.changes),
            "evidence": lambda: _whole_numbers("evidence", self._evidence, self._ends.evidence),
            "links": lambda: _whole_numbers("links", self._link_changes, self._ends.link_changes),
            "decisions": self._decisions_frame,
            "attempts": lambda: attempts_frame(
                (decision for decision, _ in self._told()), self._columns
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
            for name, value in self._steps[0].coverage.items()
        }

    def _steps_frame(self) -> pl.DataFrame:
        n = self.length
        codes = self._codes[:, :n].reshape(3, -1)
        small = self._small[:, :n].reshape(4, -1)
        pose = self._pose[:n].reshape(-1, 3)
        return _frame(
            {
                "step": np.repeat(self._step_column(), self._robots),
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
            schema_of("steps"),
        )

    def _events_frame(self) -> pl.DataFrame:
        rows = self._events.array[: self._ends.events]
        return _frame(
            {
                "step": rows[:, 0].astype(np.int32),
                "kind": words(rows[:, 1], EVENTS),
                "robot": rows[:, 2].astype(np.int32),
                "other": rows[:, 3].astype(np.int32),
                "value": rows[:, 4].copy(),
            },
            schema_of("events"),
        )

    def _decisions_frame(self) -> pl.DataFrame:
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
            for d, details in self._told()
        ]
        schema = schema_of("decisions")
        columns = zip(*rows, strict=True) if rows else ((),) * len(schema)
        return _frame(dict(zip(schema, columns, strict=True)), schema)

    def _coverage_frame(self, types: Mapping[str, Any]) -> pl.DataFrame:
        rows = [step.coverage for step in self._steps]
        columns = {name: [row[name] for row in rows] for name in types}
        schema = {**schema_of("coverage"), **types}
        return _frame({"step": self._step_column(), **columns}, schema)

    def _timing_frame(self) -> pl.DataFrame:
        import polars as pl

        rows = [step.seconds for step in self._steps]
        names = list(dict.fromkeys(name for row in rows for name in row))
        columns = {f"{name}_s": [row.get(name) for row in rows] for name in names}
        schema = {**schema_of("timing"), **dict.fromkeys(columns, pl.Float64)}
        return _frame({"step": self._step_column(), **columns}, schema)


def _frame(columns: Mapping[str, Any], schema: Mapping[str, Any]) -> pl.DataFrame:
    """A table; made of single columns, since a frame looks twice at whatever else it is given."""
    import polars as pl

    return pl.DataFrame([pl.Series(name, columns[name], dtype=schema[name]) for name in schema])


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
    schema = schema_of(table)
    return _frame(
        {
            name: rows.array[:end, i].astype(np.bool_ if name == "hears" else np.int32)
            for i, name in enumerate(schema)
        },
        schema,
    )
