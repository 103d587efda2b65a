"""What a run records: every table, and of every column its type, unit, source and meaning.

Writer, reader, player, Rerun export and the lists in ``docs/recordings.md`` are made from
:data:`TABLES`. To record another number per robot, add a property to
:class:`swarmscout.core.recorder.StepRecord` and a row to the table ``steps``, and raise
:data:`FORMAT`.

Codes are recorded as words (an Enum), so that ``run.steps.filter(pl.col("mode") == "CHR")`` works.
Polars is imported late: a mission starts without it.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from operator import attrgetter, itemgetter
from typing import TYPE_CHECKING, Any

import numpy as np

from swarmscout.core.enums import ACTIONS, CAUSES, EVENTS, MODES
from swarmscout.core.errors import RunError, did_you_mean

if TYPE_CHECKING:
    import polars as pl

__all__ = [
    "CONTACTS",
    "FORMAT",
    "LEVELS",
    "OWN_MAPS",
    "PART_STEPS",
    "TABLES",
    "Column",
    "Table",
    "check_level",
    "empty_table",
    "schema_of",
]

FORMAT = 2
"""Number of the run folder's layout and columns; a reader refuses folders with another one."""

PART_STEPS = 50
"""Steps in one part: a killed mission loses fewer than these."""

CONTACTS = ("none", "wall", "robot")
"""Words for what blocked a body (``core.enums``: NO_CONTACT and so on)."""


@dataclass(frozen=True, slots=True)
class Column:
    """One column of a table.

    Attributes:
        name: its name in the table.
        kind: ``int32``, ``int64``, ``float64``, ``bool``, ``text``, or the words that codes mean.
        unit: of its values; ``robot`` and ``cell`` are indices and checked as such, and a ``?``
            behind a unit says that -1 (a number) or null (elsewhere) stands for "none".
        meaning: one line for the documentation.
        source: takes the value, or the step's array of values, from what :class:`Table` names.
    """

    name: str
    kind: str | tuple[str, ...]
    unit: str
    meaning: str
    source: Callable[[Any], Any]

    @property
    def dtype(self) -> type[np.generic]:
        """NumPy type of the values while they are gathered; codes for words."""
        kind: type[np.generic] = np.dtype(
            "uint8" if isinstance(self.kind, tuple) else self.kind
        ).type
        return kind


@dataclass(frozen=True, slots=True)
class Table:
    """One table.

    Attributes:
        meaning: what there is a row for.
        rows: what a column's source is applied to. ``step``: the step's record, which gives an
            array with a value for each row (or one value for all rows). ``links``: the same for
            :class:`LinkChanges`. ``coverage``, ``seconds``: that mapping of the step's record.
            ``decision``, ``attempt``: :class:`Decided`, :class:`Asked`.
        columns: in order; the first is the step.
    """

    meaning: str
    rows: str
    columns: tuple[Column, ...]

    @property
    def gathers_arrays(self) -> bool:
        """Whether a step adds arrays of rows, rather than single rows."""
        return self.rows in ("step", "links")


_STEP = "0 is the state before the first step"


def _at(name: str, index: int) -> Callable[[Any], Any]:
    """Column `index` of a two-dimensional array of the step's record."""
    return lambda record: getattr(record, name)[:, index]


def _step(path: str = "step") -> Column:
    return Column("step", "int32", "step", _STEP, attrgetter(path))


def _of(name: str, kind: str | tuple[str, ...], unit: str, meaning: str, path: str = "") -> Column:
    """A column out of an attribute, by default the one of the same name."""
    return Column(name, kind, unit, meaning, attrgetter(path or name))


def _key(name: str, kind: str, unit: str, meaning: str, key: str = "") -> Column:
    """A column out of a mapping."""
    return Column(name, kind, unit, meaning, itemgetter(key or name))


_LOG_ODDS = "1/1000 nat"

TABLES: dict[str, Table] = {
    "steps": Table(
        "a row per robot and step: what its body did and what it had in mind",
        "step",
        (
            _step(),
            Column("robot", "int32", "robot", "", lambda record: np.arange(len(record.action))),
            _of("x_m", "float64", "m", "x of the body's centre, after the step"),
            _of("y_m", "float64", "m", "y of it"),
            _of("heading_rad", "float64", "rad", "heading, counter-clockwise from the x axis"),
            _of("charge", "float64", "1", "charge left, as a fraction of the capacity"),
            _of("mode", MODES, "", "EXP (explore) or CHR (charge)"),
            _of("action", ACTIONS, "", "what it did in the step"),
            _of("contact", CONTACTS, "", "what blocked a forward move that was not made"),
            _of("alive", "bool", "", "false for a stranded robot"),
            _of("team", "int64", "", "id of its team"),
            _of("leader", "int32", "robot", "the robot that leads its team"),
            _of("desired", "int32", "robots", "desired team size"),
            _of("destination", "int32", "cell?", "its team's destination"),
            _of("target", "int32", "cell?", "the cell that it drives to itself"),
        ),
    ),
    "map_changes": Table(
        "a row per map cell that changed, of the map that the swarm as a whole has",
        "step",
        (
            _step(),
            _of("cell", "int32", "cell", "ascending within a step", "map_cells"),
            _of("log_odds", "int32", _LOG_ODDS, "as read, saturated", "map_log_odds"),
        ),
    ),
    "evidence": Table(
        "a row per robot and cell that its own scan says something new of; only where robots have "
        "maps of their own",
        "step",
        (
            _step(),
            Column("robot", "int32", "robot", "whose scan", _at("evidence", 0)),
            Column("cell", "int32", "cell", "", _at("evidence", 1)),
            Column("increment", "int32", _LOG_ODDS, "what its log gained", _at("evidence", 2)),
        ),
    ),
    "links": Table(
        "a row per change of who hears whom; only where robots have maps of their own",
        "links",
        (
            _step(),
            _of("listener", "int32", "robot", ""),
            _of("speaker", "int32", "robot", ""),
            _of("hears", "bool", "", "whether the listener hears the speaker from now on"),
        ),
    ),
    "decisions": Table(
        "a row per decision for a destination",
        "decision",
        (
            _step("decision.step"),
            _of("team", "int64", "", "id of the team", "decision.team"),
            _of("leader", "int32", "robot", "the robot that decided", "decision.leader"),
            _of("cause", CAUSES, "", "why a destination was needed", "decision.cause"),
            _of("selector", "text", "", "the selector's name", "decision.selector"),
            _of("cell", "int32", "cell?", "the chosen cell; null: there was nothing to choose"),
            _of("x_m", "float64", "m?", "x of its centre"),
            _of("y_m", "float64", "m?", "y of it"),
            _of("distance_m", "float64", "m?", "straight distance from the team's position"),
            _of("frontiers", "int32", "cells", "frontier cells in view", "decision.frontiers"),
            _of(
                "frontier_neighbours", "int32", "cells", "frontier cells round the chosen one",
                "decision.frontier_neighbours",
            ),
            _of(
                "obstacle_neighbours", "int32", "cells", "occupied cells round it",
                "decision.obstacle_neighbours",
            ),
            _of("reason", "text", "", "in the selector's own words"),
            _of("details", "text", "", "what else the selector recorded, a JSON object"),
        ),
    ),
    "attempts": Table(
        "a row per question to a language model; only where one was asked",
        "attempt",
        (
            _step("decision.step"),
            _of("team", "int64", "", "id of the team", "decision.team"),
            _of("leader", "int32", "robot", "the robot that asked", "decision.leader"),
            _of("attempt", "int32", "", "1 for a decision's first", "attempt.number"),
            _of("model", "text", "", "which model answered", "attempt.reply.model"),
            _of("encoding", "text", "", "how the view was written down", "attempt.encoding"),
            _of("prompt_version", "text", "", "of the template", "attempt.prompt_version"),
            _of("prompt", "text", "", "names the prompt in `texts/`"),
            _of("candidates", "int32", "cells", "could be chosen", "attempt.candidates"),
            _of("dropped", "int32", "cells", "left out to save tokens", "attempt.dropped"),
            _of("answer", "text", "?", "names the answer in `texts/`; null: there was none"),
            _of("verdict", "text", "", "valid, or why not", "attempt.verdict"),
            _of("cell", "int32", "cell?", "what a valid answer chose"),
            _of("reason", "text", "", "in the model's own words", "attempt.reason"),
            _of("note", "text", "", "more about a failure", "attempt.reply.note"),
            _of("tries", "int32", "", "requests sent for it", "attempt.reply.tries"),
            _of("latency_s", "float64", "s", "waiting included", "attempt.reply.seconds"),
            _of("tokens_in", "int64", "tokens?", "of the prompt", "attempt.reply.tokens_in"),
            _of("tokens_out", "int64", "tokens?", "of the answer", "attempt.reply.tokens_out"),
            _of("cost_usd", "float64", "USD?", "null: no price is known", "attempt.reply.cost_usd"),
        ),
    ),
    "events": Table(
        "a row per event; `core/enums.py` says for each kind what `other` and `value` are",
        "step",
        (
            _step(),
            Column("kind", EVENTS, "", "", _at("events", 0)),
            Column("robot", "int32", "robot", "", _at("events", 1)),
            Column("other", "int32", "", "", _at("events", 2)),
            Column("value", "int64", "", "", _at("events", 3)),
        ),
    ),
    "timing": Table(
        "a row per step: what a clock measured",
        "seconds",
        (
            _step(),
            _key("step_s", "float64", "s", "the whole step", "step"),
            _key("decide_s", "float64", "s", "choosing destinations", "decide"),
        ),
    ),
    "coverage": Table(
        "a row per step: how far the swarm is",
        "coverage",
        (
            _step(),
            _key("explored_m2", "float64", "m²", "explored area, see the summary"),
            _key("explored_fraction", "float64", "1", "of the reachable area"),
            _key("known_cells", "int64", "cells", "free or occupied in the swarm's map"),
            _key("frontier_cells", "int64", "cells", "frontiers in the swarm's map"),
            _key("teams", "int64", "", "teams of exploring robots"),
            _key("charging", "int64", "robots", "in mode CHR"),
            _key("stranded", "int64", "robots", "without charge"),
        ),
    ),
}  # fmt: skip
"""Every table by its name."""

OWN_MAPS = ("evidence", "links")
"""Tables from which each robot's own map follows."""

LEVELS: dict[str, tuple[str, ...]] = {
    "full": tuple(TABLES),
    "curves": ("decisions", "attempts", "timing", "coverage"),
    "summary": (),
}
"""What each recording level keeps, beside the scenario, the final map and the summary."""


def check_level(level: str) -> str:
    """Return a recording level unchanged.

    Raises:
        RunError: the level does not exist.
    """
    if level not in LEVELS:
        near = did_you_mean(level, LEVELS)
        raise RunError(f"recording level '{level}' is unknown: {near}")
    return level


@cache
def schema_of(table: str) -> dict[str, Any]:
    """Columns and Polars types of a table; the same object each time: do not change it."""
    import polars as pl

    types: dict[str, Any] = {
        "int32": pl.Int32,
        "int64": pl.Int64,
        "float64": pl.Float64,
        "bool": pl.Boolean,
        "text": pl.String,
    }
    return {
        column.name: types[column.kind] if isinstance(column.kind, str) else pl.Enum(column.kind)
        for column in TABLES[table].columns
    }


def empty_table(table: str) -> pl.DataFrame:
    """A table without rows."""
    import polars as pl

    return pl.DataFrame(schema=schema_of(table))
