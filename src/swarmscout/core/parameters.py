"""Parameters that users set: records checked by pydantic where they are declared.

A section of a scenario is a :class:`Parameters` record. The parameters of a plug-in (a selector, a
policy, …) are the fields of its class, a :func:`checked_dataclass`. A user's plug-in may be any
class: its arguments are checked by :func:`check_arguments`.
"""

from __future__ import annotations

import inspect
import reprlib
from collections.abc import Callable, Mapping, Sequence
from functools import wraps
from typing import (
    TYPE_CHECKING,
    Annotated,
    Any,
    TypeVar,
    dataclass_transform,
    get_args,
    get_type_hints,
)

from pydantic import BaseModel, ConfigDict, Field, Tag, TypeAdapter, ValidationError
from pydantic.dataclasses import dataclass

from swarmscout.core.errors import ScenarioError, SwarmscoutError, did_you_mean

__all__ = [
    "HIDDEN",
    "STRICT",
    "Amount",
    "Metres",
    "Parameters",
    "Probability",
    "Share",
    "Steps",
    "check_arguments",
    "checked_dataclass",
    "describe_invalid_arguments",
    "describe_invalid_keys",
    "key_of",
]

STRICT = ConfigDict(strict=True, extra="forbid", allow_inf_nan=False)
"""Configuration of plug-ins' dataclasses: no unknown names, no conversion of types."""

HIDDEN = "hidden"
"""Type of a validation error whose message must not show the value: it may hold a secret."""

T = TypeVar("T")
Amount = Annotated[float, Field(ge=0.0, le=1e6)]
Metres = Amount
Steps = Annotated[int, Field(ge=0, le=1_000_000_000)]
Share = Annotated[float, Field(ge=0.0, le=1.0)]
Probability = Annotated[float, Field(gt=0.0, lt=1.0)]

_UNKNOWN = ("extra_forbidden", "unexpected_keyword_argument")
_CHECKED = (bool, int, float, str)


class Parameters(BaseModel):
    """Base class of a scenario and of its sections: frozen, and without unknown keys.

    Raises:
        ScenarioError: a key is unknown or has a bad value; the message is one line.
    """

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)

    if not TYPE_CHECKING:  # Type checkers take the fields for the arguments.

        def __init__(self, *wrong: Any, **keys: Any) -> None:
            name = type(self).__name__
            if wrong:
                raise ScenarioError(
                    f"{name}: give keys by name, as {name}({next(iter(type(self).model_fields))}=…)"
                )
            try:
                super().__init__(**keys)
            except ValidationError as error:
                raise ScenarioError(f"{name}: {describe_invalid_keys(error, type(self))}") from None

        # Sections inside a scenario are checked together with it, not by calling this.
        __init__.__pydantic_base_init__ = True


def describe_invalid_keys(error: ValidationError, model: type[BaseModel]) -> str:
    """The first thing that is wrong with a scenario's keys, in one line.

    Args:
        error: what pydantic says.
        model: what was validated, a scenario or a section of it.
    """
    problems = error.errors(include_url=False)
    first = problems[0]
    key, section = key_of(first, model)
    more = f" (and {len(problems) - 1} more)" if len(problems) > 1 else ""
    if first["type"] in _UNKNOWN:
        name = str(first["loc"][-1])
        return f"unknown key '{key}': {did_you_mean(name, section.model_fields)}{more}"
    message, given = _message(first["msg"]), first["input"]
    if first["type"] == HIDDEN:
        return f"key '{key}': {message}{more}"
    if first["type"] in ("model_type", "dict_type"):
        return f"key '{key}' = {reprlib.repr(given)}: it is a section, give its keys{more}"
    if isinstance(given, dict | BaseModel):
        return f"section '{key}': {message}{more}" if key else f"{message}{more}"
    return f"key '{key}' = {_brief(given)}: {message}{more}"


def key_of(problem: Mapping[str, Any], model: type[BaseModel]) -> tuple[str, type[BaseModel]]:
    """The dotted key that one of pydantic's problems is about, and the section it is in.

    Args:
        problem: of ``ValidationError.errors()``.
        model: what was validated.
    """
    parts: list[str] = []
    section = model
    records: dict[str, type[BaseModel]] = {}
    for part in map(str, problem["loc"]):
        if part in records:  # Which record of a section that has several; no part of the key.
            section, records = records[part], {}
            continue
        parts.append(part)
        field = section.model_fields.get(part)
        annotation = None if field is None else field.annotation
        if isinstance(annotation, type) and issubclass(annotation, BaseModel):
            section = annotation
        else:
            records = {
                tag.tag: get_args(member)[0]
                for member in get_args(annotation)
                for tag in getattr(member, "__metadata__", ())
                if isinstance(tag, Tag)
            }
    return ".".join(parts), section


def describe_invalid_arguments(error: ValidationError, names: Sequence[str] = ()) -> str:
    """The first thing that is wrong with a plug-in's parameters, in one line.

    Args:
        error: what pydantic says of the plug-in's class.
        names: of the parameters, in order.
    """
    first = error.errors(include_url=False)[0]
    message = _message(first["msg"])
    if not first["loc"]:
        return message
    key = first["loc"][0]
    key = names[key] if isinstance(key, int) and key < len(names) else key
    return f"{key} = {_brief(first['input'])}: {message}"


@dataclass_transform(frozen_default=True)
def checked_dataclass(kind: type[T]) -> type[T]:
    """Make a class a frozen pydantic dataclass whose constructor raises errors of one line.

    Example:
        >>> @checked_dataclass
        ... class Far:
        ...     reach_m: Metres = 3.0
        >>> Far(-1.0)
        Traceback (most recent call last):
        ValueError: reach_m = -1.0: should be greater than or equal to 0
    """
    made: Any = dataclass(kind, frozen=True, config=STRICT)
    names = list(made.__dataclass_fields__)
    constructor = made.__init__

    @wraps(constructor)
    def __init__(self: Any, *given: Any, **named: Any) -> None:
        try:
            constructor(self, *given, **named)
        except ValidationError as error:
            raise ValueError(describe_invalid_arguments(error, names)) from None

    made.__init__ = __init__
    return made  # type: ignore[no-any-return]


def check_arguments(
    subject: str, kind: Callable[..., Any], given: Mapping[str, Any], error: type[SwarmscoutError]
) -> None:
    """Check keyword arguments for a plug-in's class before it is called.

    An argument's type is its annotation or that of its default; ``bool``, ``int``, ``float`` and
    ``str`` are checked, and every number has to be finite.

    Args:
        subject: what the plug-in is called in errors: "selector 'mine'".
        kind: its class, or a function that makes one.
        given: the keyword arguments.
        error: raised if something is wrong.

    Raises:
        SwarmscoutError: of the given class: an argument is unknown, or of another type.
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
            known = did_you_mean(key, accepted) if accepted else "it takes none"
            raise error(f"{subject} has no parameter '{key}': {known}")
        expected = hints.get(key, type(accepted[key].default))
        if expected not in _CHECKED:
            if isinstance(value, bool) or not isinstance(value, int | float):
                continue
            expected = float
        try:
            TypeAdapter(expected, config=STRICT).validate_python(value)
        except ValidationError as wrong:
            message = _message(wrong.errors(include_url=False)[0]["msg"])
            raise error(f"{subject}: {key} = {_brief(value)}: {message}") from None


def _message(text: str) -> str:
    return text.removeprefix("Value error, ").removeprefix("Input ")


def _brief(value: Any) -> str:
    """A value in a few words: the repr of an array or a frame would fill the screen."""
    if isinstance(value, str):
        return repr(value if len(value) <= 100 else f"{value[:100]}…")
    plain = value is None or isinstance(value, bool | int | float | list | tuple)
    return reprlib.repr(value) if plain else f"a {type(value).__name__}"


def _hints(kind: Callable[..., Any]) -> dict[str, Any]:
    """Annotations of a class's fields and of its constructor, as far as they can be resolved."""
    hints: dict[str, Any] = {}
    for where in (kind, getattr(kind, "__init__", None)):
        try:
            hints |= get_type_hints(where)
        except Exception:  # For example a name that exists for type checkers only.
            continue
    return hints
