"""A chunk: the rows of some steps, copied out of the mission.

Rows of robots, cells and events are copied into arrays, one per column, without a Python object per
row. What comes once a step is kept as it came. A step counts only from the last line of
:meth:`Chunk.add` on, so an interrupt in the middle of it leaves the chunk as it was before.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import chain
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from swarmscout.core.recorder import StepRecord
from swarmscout.recording.decisions import Asked, Decided
from swarmscout.recording.tables import OWN_MAPS, TABLES, Column, schema_of

if TYPE_CHECKING:
    import polars as pl

__all__ = ["Chunk"]


class _LinkChanges(NamedTuple):
    """Changes of who hears whom in a step: arrays of equal length."""

    step: int
    listener: NDArray[np.int64]
    speaker: NDArray[np.int64]
    hears: NDArray[np.bool_]


class _Arrays:
    """The columns of a table to which each step adds any number of rows; they double when full."""

    def __init__(self, columns: Sequence[Column], room: int) -> None:
        self._columns = columns
        self._arrays = [np.empty(room, dtype=column.dtype) for column in columns]

    def put(self, at: int, step: Any) -> int:
        """Write a step's rows from row `at` on; return where they end."""
        values = [column.source(step) for column in self._columns]
        end = at + len(values[-1])
        if end == at:
            return at
        if end > len(self._arrays[0]):
            room = max(end, 2 * len(self._arrays[0]))
            self._arrays = [np.resize(array, room) for array in self._arrays]
        for array, value in zip(self._arrays, values, strict=True):
            array[at:end] = value
        return end

    def series(self, end: int) -> list[pl.Series]:
        """The first rows as columns of a table."""
        import polars as pl

        made = []
        for column, array in zip(self._columns, self._arrays, strict=True):
            if isinstance(column.kind, tuple):
                words = pl.Series(column.kind, dtype=pl.Enum(column.kind))
                made.append(words.gather(array[:end]).alias(column.name))
            else:
                made.append(pl.Series(column.name, array[:end].copy()))
        return made


class _Step(NamedTuple):
    """What is kept of a step beside its rows in arrays, and where those end in each table."""

    step: int
    coverage: Mapping[str, float | int]
    seconds: Mapping[str, float]
    decisions: Sequence[Decided]
    ends: Sequence[int]


class Chunk:
    """Room for the rows of some steps.

    Args:
        robots: N, the number of robots.
        steps: how many steps fit.
        columns: columns of the map, for flat cells.
        tables: which tables are kept.
    """

    def __init__(self, robots: int, steps: int, columns: int, tables: Sequence[str]) -> None:
        self._capacity = steps
        self._columns = columns
        self._tables = tables
        self._arrays = {
            name: _Arrays(TABLES[name].columns, steps * robots if name == "steps" else 256)
            for name in tables
            if TABLES[name].gathers_arrays
        }
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
        links, ends = self._links, []
        for (name, arrays), end in zip(self._arrays.items(), self._ends, strict=True):
            source: Any = record
            if name in OWN_MAPS and getattr(record, name) is None:  # Before the first step.
                ends.append(end)
                continue
            if name == "links" and record.links is not None:
                links = record.links & ~np.eye(len(self._links), dtype=np.bool_)
                listener, speaker = np.nonzero(links != self._links)
                hears = links[listener, speaker]
                source = _LinkChanges(record.step, listener, speaker, hears)
            ends.append(arrays.put(end, source))
        decided = [Decided.of(decision, self._columns) for decision in record.decisions]
        step = _Step(record.step, record.coverage, record.seconds, decided, ends)
        self._links = links
        self._steps.append(step)

    @property
    def _ends(self) -> Sequence[int]:
        return self._steps[-1].ends if self._steps else (0,) * len(self._arrays)

    def frames(self) -> dict[str, pl.DataFrame]:
        """The chunk as tables: a frame for each table that is kept, some perhaps without rows."""
        import polars as pl

        ends = dict(zip(self._arrays, self._ends, strict=True))
        return {
            name: pl.DataFrame(
                self._arrays[name].series(ends[name]) if name in ends else self._series(name)
            )
            for name in self._tables
        }

    def _series(self, name: str) -> list[pl.Series]:
        """The columns of a table whose rows were kept as they came."""
        import polars as pl

        table, types = TABLES[name], schema_of(name)
        decided = chain.from_iterable(step.decisions for step in self._steps)
        rows: Sequence[Any]
        if table.rows == "decision":
            rows = list(decided)
        elif table.rows == "attempt":
            rows = [asked for row in decided for asked in Asked.of(row.decision, self._columns)]
        else:
            rows = [getattr(step, table.rows) for step in self._steps]
        made = []
        for column in table.columns:
            # A mapping does not hold its step.
            of_steps = column.name == "step" and table.rows in ("coverage", "seconds")
            values = list(map(column.source, self._steps if of_steps else rows))
            made.append(pl.Series(column.name, values, dtype=types[column.name]))
        return made
