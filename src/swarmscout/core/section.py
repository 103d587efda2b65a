"""Sections of a scenario: frozen records whose errors name the key, the value and what fits."""

from __future__ import annotations

import reprlib
from typing import TYPE_CHECKING, Any

from pydantic import BaseModel, ConfigDict, ValidationError

from swarmscout.core.errors import ScenarioError, did_you_mean

__all__ = ["HIDDEN", "Section", "what_is_wrong"]

HIDDEN = "hidden"
"""Type of a validation error whose message must not show the value: it may hold a secret."""


class Section(BaseModel):
    """A frozen record of checked keys; a wrong one raises :class:`ScenarioError`."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False, strict=False)

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
                raise ScenarioError(f"{name}: {what_is_wrong(error, type(self))}") from None

        # Sections inside a scenario are checked together with it, not by calling this.
        __init__.__pydantic_base_init__ = True


def what_is_wrong(error: ValidationError, model: type[BaseModel]) -> str:
    """The first error in a scenario's keys, in one line.

    Args:
        error: pydantic's.
        model: the scenario's class, or that of one of its sections.
    """
    problems = error.errors(include_url=False)
    first = problems[0]
    key = ".".join(str(part) for part in first["loc"])
    more = f" (and {len(problems) - 1} more)" if len(problems) > 1 else ""
    if first["type"] == "extra_forbidden":
        section = model
        for part in first["loc"][:-1]:
            annotation = section.model_fields[str(part)].annotation
            if isinstance(annotation, type) and issubclass(annotation, BaseModel):
                section = annotation
        name = str(first["loc"][-1])
        return f"unknown key '{key}': {did_you_mean(name, section.model_fields)}{more}"
    if first["type"] == HIDDEN:
        return f"key '{key}': {first['msg']}{more}"
    message = first["msg"].removeprefix("Value error, ").removeprefix("Input ")
    given = first["input"]
    if first["type"] in ("model_type", "dict_type"):
        return f"key '{key}' = {reprlib.repr(given)}: it is a section, give its keys{more}"
    if isinstance(given, dict | BaseModel):
        return f"section '{key}': {message}{more}" if key else f"{message}{more}"
    return f"key '{key}' = {_brief(given)}: {message}{more}"


def _brief(value: Any) -> str:
    """A value in a few words: an array's or a frame's repr would fill the screen."""
    if isinstance(value, str):
        return repr(value if len(value) <= 100 else f"{value[:100]}…")
    plain = value is None or isinstance(value, bool | int | float | list | tuple)
    return reprlib.repr(value) if plain else f"a {type(value).__name__}"
