"""Errors that a user can meet, each one clear line.

``SwarmscoutError``
├── ``ScenarioError``   a scenario key is unknown, of a wrong type or impossible
├── ``WorldError``      a world cannot be loaded, generated or used
├── ``SelectorError``   a selector is unknown, cannot be loaded, or answered wrongly
├── ``PolicyError``     a policy is unknown, cannot be loaded, or answered wrongly
├── ``TaskError``       a task is unknown, cannot be loaded, or answered wrongly
├── ``ModelError``      a language model is not configured, or a cassette lacks an answer
├── ``RunError``        a run folder cannot be written or read
├── ``ViewError``       a mission cannot be shown: a port, a file's name, a missing program
└── ``StudyError``      a study's file or folder cannot be used, or its engine is lost
"""

from __future__ import annotations

from collections.abc import Iterable
from difflib import get_close_matches

__all__ = [
    "ModelError",
    "PolicyError",
    "RunError",
    "ScenarioError",
    "SelectorError",
    "SensorError",
    "StudyError",
    "SwarmscoutError",
    "TaskError",
    "ViewError",
    "WorldError",
    "did_you_mean",
    "kind_in_words",
]


class SwarmscoutError(Exception):
    """Base class: the message says in one line what is wrong, where, and what would be right."""


class ScenarioError(SwarmscoutError):
    """A scenario key is unknown, of a wrong type, or has an impossible value."""


class WorldError(SwarmscoutError):
    """A world cannot be loaded or generated, or no mission can run in it."""


class SelectorError(SwarmscoutError):
    """A selector is unknown, cannot be loaded, or gave an answer outside its contract."""


class SensorError(SwarmscoutError):
    """A sensor is unknown, cannot be loaded, or gave a scan outside its contract."""


class PolicyError(SwarmscoutError):
    """A policy is unknown, cannot be loaded, or gave an answer outside its contract."""


class TaskError(SwarmscoutError):
    """A task is unknown, cannot be loaded, or gave an answer outside its contract."""


class ModelError(SwarmscoutError):
    """A language model is not configured or not installed, or a cassette lacks an answer."""


class RunError(SwarmscoutError):
    """A run folder cannot be written or read."""


class ViewError(SwarmscoutError):
    """A mission cannot be shown as asked."""


class StudyError(SwarmscoutError):
    """A study's file or folder cannot be used, or what it runs on is lost."""


def did_you_mean(given: str, known: Iterable[str]) -> str:
    """Say which known name is nearest to one that is not known.

    Args:
        given: the unknown name.
        known: all names that would work.

    Returns:
        ``"did you mean 'x'?"``, or a list of what is known if nothing is near.
    """
    names = sorted(known)
    near = get_close_matches(given, names, n=1, cutoff=0.55)
    if near:
        return f"did you mean '{near[0]}'?"
    return f"known: {', '.join(names)}" if names else "none are known"


def kind_in_words(thing: object) -> str:
    """What a plug-in returned instead of what it should: "an array of float32"."""
    # A command that only prints its help needs no arrays.
    import numpy as np

    if isinstance(thing, np.ndarray):
        return f"an array of {thing.dtype}"
    return "None" if thing is None else f"a {type(thing).__name__}"
