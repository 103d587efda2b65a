"""Asking a selector while watching what it reads, draws and changes."""

from __future__ import annotations

import dataclasses
import json
import operator
import sys
from collections.abc import Mapping
from typing import Any

import numpy as np

from swarmscout.core.errors import SelectorError
from swarmscout.destinations.selector import Choice, Selector
from swarmscout.destinations.view import LeaderView
from swarmscout.testing.fingerprints import (
    fingerprint,
    global_states,
    held_by,
    kind_of,
    seeded_globals,
    writes_read_only,
)

__all__ = ["asked", "checked_answer"]

_GIVEN_ARRAYS = ("frontiers", "frontiers_m", "members", "members_m")
_OF_THE_VIEW = {LeaderView.__module__, "functools", __name__}


class _WatchedView(LeaderView):
    """A view that notes who reads its private attributes."""

    def __getattribute__(self, name: str) -> Any:
        private = name.startswith("_") and (name == "__dict__" or not name.startswith("__"))
        if private and sys._getframe(1).f_globals.get("__name__") not in _OF_THE_VIEW:
            object.__getattribute__(self, "__dict__").setdefault("private_reads", []).append(name)
        return object.__getattribute__(self, name)


def asked(selector: Selector, view: LeaderView, memory: Any, *, globals_seed: int) -> Any:
    """Ask a selector once, from a fresh view that is equal to the one given.

    Args:
        selector: whom.
        view: what it shall see.
        memory: what it shall be handed.
        globals_seed: the global generators are seeded with this, and put back afterwards.

    Returns:
        Its answer, whatever it is.

    Raises:
        SelectorError: it failed, or changed or read what is not its own; the message starts with
            a verb.
    """
    given = {f.name: getattr(view, f.name) for f in dataclasses.fields(LeaderView)}
    shown = _WatchedView(**given)
    seen, handed, itself = _look(view), fingerprint(memory), held_by(selector)
    with seeded_globals(globals_seed):
        before = global_states()
        try:
            answer = selector.choose(shown, memory)
        except Exception as error:
            if _is_change_of_view(error):
                raise SelectorError(
                    f"tries to change its view, which is read-only ({error}); work on a copy"
                ) from error
            raise SelectorError(f"failed: {type(error).__name__}: {error}") from error
        drawn = [name for name, state in global_states().items() if state != before[name]]
    inside = vars(shown)
    if inside.get("private_reads"):
        raise SelectorError(
            f"reads '{inside['private_reads'][0]}' of its view, which is private: what is not "
            "public in a view cannot be used"
        )
    if drawn:
        raise SelectorError(
            f"draws from the global generator of {drawn[0]}: draw from view.rng instead"
        )
    spoilt = _look(view) != seen or any(inside[name] is not value for name, value in given.items())
    # What the view worked out while it was asked, against the same worked out anew.
    for name, value in inside.items():
        if isinstance(value, np.ndarray) and name not in given:
            spoilt = spoilt or fingerprint(value) != fingerprint(getattr(view, name))
    if spoilt:
        raise SelectorError("changed its view, which is read-only; work on a copy")
    if fingerprint(memory) != handed:
        raise SelectorError(
            "changed the memory that it was handed: hand a new value back in Choice.memory"
        )
    changed = sorted(name for name, value in held_by(selector).items() if itself.get(name) != value)
    if changed:
        raise SelectorError(
            f"changed itself (attribute '{changed[0]}'): a selector is one for all robots; "
            "remember through Choice.memory"
        )
    return answer


def checked_answer(answer: Any, view: LeaderView) -> Choice:
    """An answer that is a proper Choice for a view.

    Raises:
        SelectorError: what is wrong with it; the message starts with a verb.
    """
    if not isinstance(answer, Choice):
        raise SelectorError(f"returned {kind_of(answer)}, not a Choice")
    try:
        row, col = answer.cell
    except (TypeError, ValueError):
        raise SelectorError(f"chose {answer.cell!r}, which is no cell (row, col)") from None
    try:
        cell = operator.index(row), operator.index(col)
    except TypeError:
        raise SelectorError(
            f"chose {answer.cell!r}: rows and columns are whole numbers, not "
            f"{kind_of(row)}; convert with int() or .tolist()"
        ) from None
    if isinstance(row, bool | np.bool_) or not (view.frontiers == cell).all(axis=1).any():
        raise SelectorError(
            f"chose {answer.cell!r}, which is not among view.frontiers "
            f"({len(view.frontiers)} cells)"
        )
    if not isinstance(answer.reason, str):
        raise SelectorError(f"gave {kind_of(answer.reason)} as its reason, not text")
    if not isinstance(answer.details, Mapping):
        raise SelectorError(f"gave {kind_of(answer.details)} as its details, not a mapping")
    try:
        json.dumps(dict(answer.details), default=_unwrapped)
    except (TypeError, ValueError) as error:
        raise SelectorError(
            f"gave details that cannot be kept as JSON ({error}): use numbers, text, lists, dicts"
        ) from None
    return answer


def _look(view: LeaderView) -> list[Any]:
    others = view.others
    arrays = [getattr(view, name) for name in _GIVEN_ARRAYS]
    arrays += [others.leaders, others.sizes, others.positions_m, others.destinations_m]
    return [fingerprint(array) for array in arrays]


def _is_change_of_view(error: Exception) -> bool:
    return isinstance(error, dataclasses.FrozenInstanceError) or writes_read_only(error)


def _unwrapped(value: Any) -> Any:
    """NumPy's numbers and arrays are unwrapped by whoever records."""
    if isinstance(value, np.generic | np.ndarray):
        return value.tolist()
    raise TypeError(f"{type(value).__name__} is no plain data")
