"""Errors that a user can meet, each one clear line.

``SwarmscoutError``
├── ``ScenarioError``   a scenario key is unknown, of a wrong type or impossible
├── ``WorldError``      a world cannot be loaded, generated or used
├── ``SelectorError``   a selector is unknown, cannot be loaded, or answered wrongly
├── ``ModelError``      a language model is not configured, or a cassette lacks an answer
└── ``RunError``        a run folder cannot be written or read
"""

from __future__ import annotations

from collections.abc import Iterable
from difflib import get_close_matches

__all__ = [
    "ModelError",
    "RunError",
    "ScenarioError",
    "SelectorError",
    "SwarmscoutError",
    "WorldError",
    "did_you_mean",
]


class SwarmscoutError(Exception):
    """What a user did or gave is wrong; the message says what, where and what would be right."""


class ScenarioError(SwarmscoutError):
    """A scenario key is unknown, of a wrong type, or has an impossible value."""


class WorldError(SwarmscoutError):
    """A world cannot be loaded or generated, or no mission can run in it."""


class SelectorError(SwarmscoutError):
    """A selector is unknown, cannot be loaded, or gave an answer outside its contract."""


class ModelError(SwarmscoutError):
    """A language model is not configured or not installed, or a cassette lacks an answer."""


class RunError(SwarmscoutError):
    """A run folder cannot be written or read."""


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
