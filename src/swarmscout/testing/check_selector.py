"""The conformance check of selectors: run it in the tests of your own.

It tries a selector in the situations of :mod:`swarmscout.testing.situations` and in short missions,
and says in one error which part of the contract of
:class:`swarmscout.destinations.selector.Selector` is broken, and how.
"""

from __future__ import annotations

import dataclasses
import json
import operator
import sys
from collections.abc import Mapping
from typing import Any

import numpy as np

from swarmscout.core.errors import SelectorError
from swarmscout.destinations.registry import SELECTORS
from swarmscout.destinations.selector import Choice
from swarmscout.destinations.view import LeaderView
from swarmscout.mission.mission import Mission
from swarmscout.testing.fingerprints import fingerprint, kind_of
from swarmscout.testing.harness import Guard, Report, note_private_read
from swarmscout.testing.situations import situations
from swarmscout.testing.small_worlds import short_mission

__all__ = ["check_selector"]

_GIVEN_ARRAYS = ("frontiers", "frontiers_m", "members", "members_m")
_OWN = {LeaderView.__module__, "functools", __name__, Guard.__module__}


def check_selector(selector: Any, *, missions: int = 2, seed: int = 0) -> Report:
    """Check that a selector keeps to its contract.

    Args:
        selector: an instance, a class that needs no arguments, a registered name, or
            ``path/to/file.py:ClassName``.
        missions: number of short missions in small caves, each run to its end twice; in every
            second one each robot has a map of its own.
        seed: of the situations and the caves.

    Returns:
        What was checked; it can be printed.

    Raises:
        SelectorError: which part of the contract is broken, in which situation.

    Example:
        >>> from swarmscout.destinations.nearest import Nearest
        >>> check_selector(Nearest()).checks[0]
        'has choose(view, memory)'
    """
    guard = _SelectorGuard(selector)
    tried = []
    for situation in situations(seed):
        guard.where = f"with {situation.words}"
        first = guard.choose(situation.view, None)
        # Once more, with what it remembers of another place.
        guard.choose(situation.view, first.memory)
        tried.append(situation.words)
    tried += guard.fly(_mission, missions, seed)
    return guard.report(tried)


def _mission(guard: _SelectorGuard, seed: int) -> Mission:
    return short_mission(seed, own_maps=seed % 2 == 1, selector=guard)


class _WatchedView(LeaderView):
    def __getattribute__(self, name: str) -> Any:
        note_private_read(self, name, sys._getframe(1), _OWN)
        return object.__getattribute__(self, name)


class _SelectorGuard(Guard[LeaderView]):
    registry = SELECTORS
    checks = (
        "has choose(view, memory)",
        "returns a Choice with a frontier cell of its view, in whole numbers",
        "reason is text, details are plain data",
        "changes neither its view nor the memory it is handed, nor itself",
        "reads nothing private of its view",
        "neither draws from nor depends on the global generators of random and numpy.random",
        "gives the same answer to the same view and memory, independent of the clock",
    )
    draw_from = "draw from view.rng (or view.character) instead"
    remember_in = "remember through Choice.memory, and draw from view.rng (or view.character)"

    def choose(self, view: LeaderView, memory: Any) -> Choice:
        choice: Choice = self.answer(view, memory)
        return choice

    def ask(self, view: LeaderView, memory: Any) -> Any:
        return self.rule.choose(view, memory)

    def watched(self, view: LeaderView) -> LeaderView:
        return _WatchedView(**_given(view))

    def look(self, view: LeaderView) -> list[Any]:
        others = view.others
        arrays = [getattr(view, name) for name in _GIVEN_ARRAYS]
        arrays += [others.leaders, others.sizes, others.positions_m, others.destinations_m]
        return [fingerprint(array) for array in arrays]

    def spoilt(self, view: LeaderView, shown: LeaderView) -> bool:
        given, inside = _given(view), vars(shown)
        if any(inside[name] is not value for name, value in given.items()):
            return True
        # What the view worked out while it was asked, against the same worked out anew.
        return any(
            fingerprint(value) != fingerprint(getattr(view, name))
            for name, value in inside.items()
            if isinstance(value, np.ndarray) and name not in given
        )

    def checked(self, answer: Any, view: LeaderView) -> Choice:
        if not isinstance(answer, Choice):
            raise SelectorError(f"returned {kind_of(answer)}, not a Choice")
        _check_cell(answer.cell, view)
        if not isinstance(answer.reason, str):
            raise SelectorError(f"gave {kind_of(answer.reason)} as its reason, not text")
        if not isinstance(answer.details, Mapping):
            raise SelectorError(f"gave {kind_of(answer.details)} as its details, not a mapping")
        try:
            json.dumps(dict(answer.details), default=_unwrapped)
        except (TypeError, ValueError) as error:
            raise SelectorError(
                f"gave details that cannot be kept as JSON ({error}): use numbers, text, lists, "
                "dicts"
            ) from None
        return answer


def _given(view: LeaderView) -> dict[str, Any]:
    return {field.name: getattr(view, field.name) for field in dataclasses.fields(LeaderView)}


def _check_cell(cell: Any, view: LeaderView) -> None:
    try:
        row, col = cell
    except (TypeError, ValueError):
        raise SelectorError(f"chose {cell!r}, which is not a cell (row, col)") from None
    try:
        numbers = operator.index(row), operator.index(col)
    except TypeError:
        raise SelectorError(
            f"chose {cell!r}: rows and columns are whole numbers, not {kind_of(row)}; convert "
            "with int() or .tolist()"
        ) from None
    if isinstance(row, bool | np.bool_) or not (view.frontiers == numbers).all(axis=1).any():
        raise SelectorError(
            f"chose {cell!r}, which is not among view.frontiers ({len(view.frontiers)} cells)"
        )


def _unwrapped(value: Any) -> Any:
    """Recording unwraps NumPy's numbers and arrays."""
    if isinstance(value, np.generic | np.ndarray):
        return value.tolist()
    raise TypeError(f"{type(value).__name__} is not plain data")
