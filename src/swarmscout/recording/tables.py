"""The tables of a run: which there are, what their columns hold, and which level keeps them.

Integers are Int32 except team ids and event values (Int64); codes become words (an Enum), so that
``run.steps.filter(pl.col("mode") == "CHR")`` reads as it should. Polars is imported late: a mission
starts without it.
"""

from __future__ import annotations

from functools import cache
from typing import TYPE_CHECKING, Any

from swarmscout.core.enums import ACTIONS, CAUSES, EVENTS, MODES
from swarmscout.core.errors import RunError, did_you_mean

if TYPE_CHECKING:
    import polars as pl
    from numpy.typing import NDArray

__all__ = [
    "CONTACTS",
    "FORMAT",
    "LEVELS",
    "OWN_MAPS",
    "PART_STEPS",
    "TABLES",
    "check_level",
    "empty_table",
    "schema_of",
    "words",
]

FORMAT = 1
"""Number of the run folder's layout; a reader refuses folders with a higher one."""

PART_STEPS = 50
"""Steps in one part of a table: a killed mission loses fewer than these."""

TABLES = (
    "steps",
    "map_changes",
    "evidence",
    "links",
    "decisions",
    "attempts",
    "events",
    "timing",
    "coverage",
)
"""Every table. ``coverage`` is last: its part is written after the others and vouches for them.

``attempts`` is kept by missions that ask a language model, ``evidence`` and ``links`` by missions
whose robots have maps of their own (:data:`OWN_MAPS`), and by no others.
"""

OWN_MAPS = ("evidence", "links")
"""Tables from which each robot's own map follows."""

LEVELS: dict[str, tuple[str, ...]] = {
    "full": TABLES,
    "curves": ("decisions", "attempts", "timing", "coverage"),
    "summary": (),
}
"""What each recording level keeps, beside the scenario, the final map and the summary."""

CONTACTS = ("none", "wall", "robot")
"""Words for what a body felt when it tried to move (``core.codes``: NO_CONTACT and so on)."""


def check_level(level: str) -> str:
    """Return a recording level unchanged.

    Raises:
        RunError: there is no such level.
    """
    if level not in LEVELS:
        near = did_you_mean(level, LEVELS)
        raise RunError(f"recording level '{level}' is unknown: {near}")
    return level


@cache
def schema_of(table: str) -> dict[str, Any]:
    """Columns and Polars types of a table, as far as they are fixed.

    ``coverage`` has a column ``step`` and whatever the mission reports; ``timing`` has ``step`` and
    a column ``<phase>_s`` for whatever the clock measured, in seconds.

    Args:
        table: one of :data:`TABLES`.

    Returns:
        Column names and types; the same object for everybody, so do not write into it.
    """
    import polars as pl

    if table == "steps":
        return {
            "step": pl.Int32,
            "robot": pl.Int32,
            "x_m": pl.Float64,
            "y_m": pl.Float64,
            "heading_rad": pl.Float64,
            "charge": pl.Float64,
            "mode": pl.Enum(MODES),
            "action": pl.Enum(ACTIONS),
            "contact": pl.Enum(CONTACTS),
            "alive": pl.Boolean,
            "team": pl.Int64,
            "leader": pl.Int32,
            "desired": pl.Int32,
            "destination": pl.Int32,
            "target": pl.Int32,
        }
    if table == "map_changes":
        return {"step": pl.Int32, "cell": pl.Int32, "log_odds": pl.Int32}
    if table == "evidence":
        return {"step": pl.Int32, "robot": pl.Int32, "cell": pl.Int32, "increment": pl.Int32}
    if table == "links":
        return {"step": pl.Int32, "listener": pl.Int32, "speaker": pl.Int32, "hears": pl.Boolean}
    if table == "decisions":
        return {
            "step": pl.Int32,
            "team": pl.Int64,
            "leader": pl.Int32,
            "cause": pl.Enum(CAUSES),
            "selector": pl.String,
            "cell": pl.Int32,
            "x_m": pl.Float64,
            "y_m": pl.Float64,
            "distance_m": pl.Float64,
            "frontiers": pl.Int32,
            "frontier_neighbours": pl.Int32,
            "obstacle_neighbours": pl.Int32,
            "reason": pl.String,
            "details": pl.String,
        }
    if table == "attempts":
        return {
            "step": pl.Int32,
            "team": pl.Int64,
            "leader": pl.Int32,
            "attempt": pl.Int32,
            "model": pl.String,
            "encoding": pl.String,
            "prompt_version": pl.String,
            "prompt": pl.String,
            "candidates": pl.Int32,
            "dropped": pl.Int32,
            "answer": pl.String,
            "verdict": pl.String,
            "cell": pl.Int32,
            "reason": pl.String,
            "note": pl.String,
            "tries": pl.Int32,
            "latency_s": pl.Float64,
            "tokens_in": pl.Int32,
            "tokens_out": pl.Int32,
            "cost_usd": pl.Float64,
        }
    if table == "events":
        return {
            "step": pl.Int32,
            "kind": pl.Enum(EVENTS),
            "robot": pl.Int32,
            "other": pl.Int32,
            "value": pl.Int64,
        }
    return {"step": pl.Int32}


def empty_table(table: str) -> pl.DataFrame:
    """A table without rows."""
    import polars as pl

    return pl.DataFrame(schema=schema_of(table))


def words(codes: NDArray[Any], names: tuple[str, ...]) -> pl.Series:
    """Codes [n] as a column of their names (an Enum of ``names``)."""
    import polars as pl

    return pl.Series(names, dtype=pl.Enum(names)).gather(codes)
