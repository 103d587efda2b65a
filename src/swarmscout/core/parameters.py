"""A rule's parameters, checked before it is made: known, of the right type, possible."""

from __future__ import annotations

import inspect
import reprlib
import sys
from collections.abc import Callable, Mapping
from typing import Any, get_type_hints

from swarmscout.core.errors import SwarmscoutError, did_you_mean

__all__ = ["check_parameters"]

_KINDS = {bool: "true or false", int: "a whole number", float: "a number", str: "a text"}
_LENGTHS = ("_m", "_m2", "_m3", "_per_m")
_LONGEST = 1e6


def check_parameters(
    subject: str,
    kind: Callable[..., Any],
    given: Mapping[str, Any],
    error: type[SwarmscoutError],
    *,
    lengths: bool = False,
) -> None:
    """Check what a user gives to a rule's class.

    A parameter's type is its annotation, or else that of its default; others are not checked.

    Args:
        subject: what the rule is called in errors: "selector 'mine'".
        kind: its class, or a function that makes one.
        given: parameters.
        error: raised if something is wrong.
        lengths: also expect 0 to a million where a name says metres (``reach_m``).

    Raises:
        SwarmscoutError: of the given kind: a parameter is unknown, of another type, or impossible.
    """
    try:
        accepted = inspect.signature(kind).parameters
    except (TypeError, ValueError):
        return
    if any(p.kind is inspect.Parameter.VAR_KEYWORD for p in accepted.values()):
        return
    hints = _hints(kind)
    for key, value in given.items():
        if key not in accepted:
            raise error(
                f"{subject} has no parameter '{key}': "
                f"{did_you_mean(key, accepted) if accepted else 'it takes none'}"
            )
        default = accepted[key].default
        expected = hints.get(key, type(default))
        shown = f"{subject}: {key} = {reprlib.repr(value)}"
        if expected in _KINDS and not _fits(value, expected):
            example = "" if default is inspect.Parameter.empty else f", such as {default!r}"
            raise error(f"{shown}: expected {_KINDS[expected]}{example}")
        if not isinstance(value, int | float) or isinstance(value, bool):
            continue
        if not abs(value) <= sys.float_info.max:
            raise error(f"{shown}: expected a finite number")
        if lengths and key.endswith(_LENGTHS) and not 0 <= value <= _LONGEST:
            raise error(f"{shown}: expected 0 to {_LONGEST:,.0f}")


def _fits(value: Any, expected: type) -> bool:
    if expected is float:
        return isinstance(value, int | float) and not isinstance(value, bool)
    if expected is int:
        return isinstance(value, int) and not isinstance(value, bool)
    return isinstance(value, expected)


def _hints(kind: Callable[..., Any]) -> dict[str, Any]:
    """Annotations of a class's fields and of its constructor, as far as they can be resolved."""
    hints: dict[str, Any] = {}
    for where in (kind, getattr(kind, "__init__", None)):
        try:
            hints |= get_type_hints(where)
        except Exception:  # A name that exists for type checkers only, or whatever else.
            continue
    return hints
