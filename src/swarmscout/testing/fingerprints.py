"""Plain data that shows whether something has changed, and what a check puts back afterwards."""

from __future__ import annotations

import dataclasses
import random
import time
import types
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from functools import cached_property
from typing import Any

import numpy as np

__all__ = [
    "drawn_from",
    "fingerprint",
    "global_states",
    "held_by",
    "kind_of",
    "seeded_globals",
    "shifted_clocks",
    "writes_read_only",
]

_DEPTH = 6
_CLOCKS = ("time", "monotonic", "perf_counter", "process_time")


def fingerprint(value: Any, depth: int = 0) -> Any:
    """Plain data that is equal for equal values, for noticing changes."""
    if isinstance(value, np.ndarray):
        inside = value.tolist() if value.dtype.hasobject else value.tobytes()
        return "array", value.shape, value.dtype.str, inside
    if isinstance(value, np.random.Generator | np.random.RandomState):
        state = value.bit_generator if isinstance(value, np.random.Generator) else value
        inside = state.state if isinstance(state, np.random.BitGenerator) else state.get_state()
        return "generator", repr(inside)
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
        inner_fields = [(name, fingerprint(inner, depth + 1)) for name, inner in fields.items()]
        return type(value).__qualname__, inner_fields
    return type(value).__name__, id(value)


def held_by(rule: Any) -> dict[str, Any]:
    """What a plug-in and its classes hold: the fingerprint of each attribute, by its name."""
    held = {name: fingerprint(value) for name, value in _fields(rule).items()}
    for kind in type(rule).__mro__:
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
    # A cached property changes nothing.
    return {
        k: v for k, v in held.items() if not isinstance(getattr(kind, k, None), cached_property)
    }


def global_states() -> dict[str, Any]:
    """The global generators' states, for comparing."""
    return {"random": random.getstate(), "numpy.random": fingerprint(np.random.get_state())}  # noqa: NPY002


def drawn_from(before: Mapping[str, Any]) -> list[str]:
    """Names of the global generators whose states are no longer those of :func:`global_states`."""
    return [name for name, state in global_states().items() if state != before[name]]


@contextmanager
def seeded_globals(seed: int) -> Iterator[None]:
    """Seed the global generators, and put them back afterwards."""
    theirs = random.getstate(), np.random.get_state()  # noqa: NPY002 (what is being watched)
    try:
        random.seed(seed)
        np.random.seed(seed)  # noqa: NPY002
        yield
    finally:
        random.setstate(theirs[0])
        np.random.set_state(theirs[1])  # noqa: NPY002


@contextmanager
def shifted_clocks(later_s: float) -> Iterator[None]:
    """Put the clocks of :mod:`time` forward, and back afterwards."""
    clocks = {name: getattr(time, name) for name in _CLOCKS}
    try:
        for name, clock in clocks.items():
            setattr(time, name, _later(clock, later_s))
        yield
    finally:
        for name, clock in clocks.items():
            setattr(time, name, clock)


def _later(clock: Callable[[], float], by_s: float) -> Callable[[], float]:
    return lambda: clock() + by_s


def writes_read_only(error: Exception) -> bool:
    """Whether an error comes from writing into a read-only array, or from making it writeable."""
    return isinstance(error, ValueError) and (
        "read-only" in str(error) or "writeable" in str(error).lower()
    )


def kind_of(value: Any) -> str:
    """What a value is, in one word."""
    return "None" if value is None else type(value).__name__
