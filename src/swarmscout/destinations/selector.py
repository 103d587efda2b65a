"""The face of every rule that chooses destinations.

A selector is a frozen record with one pure method: a view in, a choice out. What it remembers is a
value that it hands back, and that is handed to it the next time the same robot decides.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Protocol, runtime_checkable

from swarmscout.core.language_model import Attempt
from swarmscout.destinations.view import LeaderView

__all__ = ["Choice", "Selector"]


@dataclass(frozen=True, slots=True)
class Choice:
    """A selector's answer.

    Attributes:
        cell: the chosen frontier cell ``(row, col)``, one of ``view.frontiers``.
        reason: in a few words, why.
        memory: what the selector wants to be handed when this robot decides next.
        details: plain data for the record (kept as JSON).
        attempts: what a language model was asked, and what became of it.
    """

    cell: tuple[int, int]
    reason: str = ""
    memory: Any = None
    details: Mapping[str, Any] = field(default_factory=dict)
    attempts: tuple[Attempt, ...] = ()


@runtime_checkable
class Selector(Protocol):
    """Chooses the next destination of a leader's team.

    Example:
        >>> from dataclasses import dataclass
        >>> @dataclass(frozen=True)
        ... class First:
        ...     '''The first frontier of the list.'''
        ...     def choose(self, view, memory):
        ...         return Choice(tuple(view.frontiers[0]))
    """

    def choose(self, view: LeaderView, memory: Any) -> Choice:
        """Choose one of ``view.frontiers``.

        Args:
            view: what the leader knows; ``view.frontiers`` has at least one cell.
            memory: what the last :class:`Choice` of this robot carried, at first None.
        """
        ...
