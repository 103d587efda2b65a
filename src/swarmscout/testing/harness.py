"""What the conformance checks of selectors and of policies share."""

from __future__ import annotations

import inspect
from collections.abc import Sequence
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

from swarmscout.core.registry import Registry
from swarmscout.mission.mission import Mission

__all__ = ["how_it_went", "instance_of", "report_text"]

R = TypeVar("R")

_COUNTS = {1: "one argument", 2: "two arguments", 3: "three arguments"}


def instance_of(kind: Registry[R], given: Any) -> tuple[R, str]:
    """The rule to be checked, and its name.

    Args:
        kind: of which kind it shall be.
        given: an instance, a class that needs no arguments, a registered name, or
            ``path/to/file.py:ClassName``.

    Raises:
        SwarmscoutError: the kind's own error: there is no such rule, or it cannot be asked.
    """
    rule: Any
    if isinstance(given, Path):
        given = str(given)
    if isinstance(given, str):
        rule, name = kind.make(given), given
    elif inspect.isclass(given):
        name = given.__name__
        try:
            rule = given()
        except TypeError as error:
            raise kind.error(
                f"{kind.noun} '{name}' cannot be made without arguments ({error}): give an instance"
            ) from None
    else:
        rule, name = given, type(given).__name__
    asked, _, arguments = kind.method.rstrip(")").partition("(")
    names = arguments.split(", ")
    method = getattr(rule, asked, None)
    if not callable(method):
        raise kind.error(f"'{name}' is no {kind.noun}: it has no method {kind.method}")
    try:
        inspect.signature(method).bind(*names)
    except TypeError:
        raise kind.error(
            f"{kind.noun} '{name}' cannot be asked: its {asked}{inspect.signature(method)} does "
            f"not take {_COUNTS[len(names)]}, {kind.method}"
        ) from None
    return rule, name


def how_it_went(kind: Registry[Any], mission: Mission, *, guarded: bool) -> tuple[Any, ...]:
    """Run a mission to its end; whatever two equal missions have in common.

    Args:
        kind: of the rule that is checked; mission: that it decides in.
        guarded: its errors are a guard's, which come wrapped into the mission's own words.
    """
    try:
        mission.run()
    except kind.error as error:
        if guarded and isinstance(error.__cause__, kind.error):
            raise error.__cause__ from error.__cause__.__cause__
        raise
    return (
        mission.step_number,
        mission.end_reason,
        mission.explored_m2,
        mission.bodies.pose.tobytes(),
        np.array(mission.minds.state).tobytes(),
    )


def report_text(sound: str, checks: Sequence[str], situations: Sequence[str]) -> str:
    """A report as text: what is sound, what was checked, and what it was tried with."""
    lines = [f"{sound}:", *(f"  {check}" for check in checks)]
    lines += ["tried with:", *(f"  {words}" for words in situations)]
    return "\n".join(lines)
