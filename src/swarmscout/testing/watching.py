"""Asking a selector while watching what it reads, draws and changes."""

from __future__ import annotations

import dataclasses
import json
import operator
import random
import sys
import types
from collections.abc import Mapping
from functools import cached_property
from typing import Any

import numpy as np

from swarmscout.core.errors import SelectorError
from swarmscout.destinations.selector import Choice, Selector
from swarmscout.minds.view import LeaderView

__all__ = ["asked", "checked_answer", "fingerprint"]

_GIVEN_ARRAYS = ("frontiers", "frontiers_m", "members", "members_m")
_OF_THE_VIEW = {LeaderView.__module__, "functools", __name__}
_DEPTH = 6


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
    seen, handed, itself = _look(view), fingerprint(memory), _state(selector)
    theirs = random.getstate(), np.random.get_state()  # noqa: NPY002 (what is being watched)
    try:
        random.seed(globals_seed)
        np.random.seed(globals_seed)  # noqa: NPY002
        before = _global_states()
        try:
            answer = selector.choose(shown, memory)
        except Exception as error:
            if _is_change_of_view(error):
                raise SelectorError(
                    f"tries to change its view, which is read-only ({error}); work on a copy"
                ) from error
            raise SelectorError(f"failed: {type(error).__name__}: {error}") from error
        drawn = [name for name, state in _global_states().items() if state != before[name]]
    finally:
        random.setstate(theirs[0])
        np.random.set_state(theirs[1])  # noqa: NPY002
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
    changed = sorted(name for name, value in _state(selector).items() if itself.get(name) != value)
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
        raise SelectorError(f"returned {_kind(answer)}, not a Choice")
    try:
        row, col = answer.cell
    except (TypeError, ValueError):
        raise SelectorError(f"chose {answer.cell!r}, which is no cell (row, col)") from None
    try:
        cell = operator.index(row), operator.index(col)
    except TypeError:
        raise SelectorError(
            f"chose {answer.cell!r}: rows and columns are whole numbers, not "
            f"{_kind(row)}; convert with int() or .tolist()"
        ) from None
    if isinstance(row, bool | np.bool_) or not (view.frontiers == cell).all(axis=1).any():
        raise SelectorError(
            f"chose {answer.cell!r}, which is not among view.frontiers "
            f"({len(view.frontiers)} cells)"
        )
    if not isinstance(answer.reason, str):
        raise SelectorError(f"gave {_kind(answer.reason)} as its reason, not text")
    if not isinstance(answer.details, Mapping):
        raise SelectorError(f"gave {_kind(answer.details)} as its details, not a mapping")
    try:
        json.dumps(dict(answer.details), default=_unwrapped)
    except (TypeError, ValueError) as error:
        raise SelectorError(
            f"gave details that cannot be kept as JSON ({error}): use numbers, text, lists, dicts"
        ) from None
    return answer


def fingerprint(value: Any, depth: int = 0) -> Any:
    """Plain data that is equal for equal values, for noticing changes."""
    if isinstance(value, np.ndarray):
        inside = value.tolist() if value.dtype.hasobject else value.tobytes()
        return "array", value.shape, value.dtype.str, inside
    if isinstance(value, np.random.Generator | np.random.RandomState):
        state = value.bit_generator if isinstance(value, np.random.Generator) else value
        told = state.state if isinstance(state, np.random.BitGenerator) else state.get_state()
        return "generator", repr(told)
    if isinstance(value, random.Random):
        return "generator", value.getstate()
    if value is None or isinstance(value, bool | int | float | complex | str | bytes | np.generic):
        # As text, so that NaN equals itself.
        return type(value).__name__, repr(value)
    if depth >= _DEPTH or isinstance(
        value, type | types.ModuleType | types.FunctionType | types.BuiltinFunctionType
    ):
        return type(value).__name__, id(value)
    if isinstance(value, Mapping):
        return "mapping", [
            (fingerprint(k, depth + 1), fingerprint(v, depth + 1)) for k, v in value.items()
        ]
    if isinstance(value, list | tuple):
        return type(value).__name__, [fingerprint(inner, depth + 1) for inner in value]
    if isinstance(value, set | frozenset):
        return "set", sorted(repr(fingerprint(inner, depth + 1)) for inner in value)
    fields = _fields(value)
    if fields or dataclasses.is_dataclass(value):
        told_fields = [(name, fingerprint(inner, depth + 1)) for name, inner in fields.items()]
        return type(value).__qualname__, told_fields
    return type(value).__name__, id(value)


def _look(view: LeaderView) -> list[Any]:
    others = view.others
    arrays = [getattr(view, name) for name in _GIVEN_ARRAYS]
    arrays += [others.leaders, others.sizes, others.positions_m, others.destinations_m]
    return [fingerprint(array) for array in arrays]


def _state(selector: Any) -> dict[str, Any]:
    """What a selector and its classes hold."""
    held = {name: fingerprint(value) for name, value in _fields(selector).items()}
    for kind in type(selector).__mro__:
        if kind.__module__ in ("builtins", "typing", "abc"):
            continue
        for name, value in vars(kind).items():
            if not name.startswith(("__", "_abc_")) and not hasattr(value, "__get__"):
                held[f"{kind.__name__}.{name}"] = fingerprint(value)
    return held


def _fields(value: Any) -> dict[str, Any]:
    kind = type(value)
    held: dict[str, Any] = {}
    for parent in kind.__mro__:
        slots = vars(parent).get("__slots__", ())
        for name in (slots,) if isinstance(slots, str) else slots:
            if hasattr(value, name):
                held[name] = getattr(value, name)
    held.update(getattr(value, "__dict__", {}))
    # What is worked out once and kept changes nothing.
    return {
        k: v for k, v in held.items() if not isinstance(getattr(kind, k, None), cached_property)
    }


def _global_states() -> dict[str, str]:
    return {"random": repr(random.getstate()), "numpy.random": repr(np.random.get_state())}  # noqa: NPY002


def _is_change_of_view(error: Exception) -> bool:
    if isinstance(error, dataclasses.FrozenInstanceError):
        return True
    return isinstance(error, ValueError) and (
        "read-only" in str(error) or "writeable" in str(error).lower()
    )


def _unwrapped(value: Any) -> Any:
    """NumPy's numbers and arrays are unwrapped by whoever records."""
    if isinstance(value, np.generic | np.ndarray):
        return value.tolist()
    raise TypeError(f"{type(value).__name__} is no plain data")


def _kind(value: Any) -> str:
    return "None" if value is None else type(value).__name__
