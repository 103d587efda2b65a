"""A leader's memory between decisions: its rule's memory, and its last choices."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from swarmscout.destinations.llm.prompt_data import cell_name
from swarmscout.destinations.view import LeaderView

__all__ = ["Remembered"]

_OUTCOMES = {
    "reached": "reached",
    "no frontier any more": "explored before you came there",
    "unreachable": "no way led there",
    "overdue": "not reached in time",
}


@dataclass(frozen=True, slots=True)
class Remembered:
    """A leader's memory.

    Attributes:
        rule: memory of the rule that decides without a model.
        past: ``(step, cell, reason, outcome)`` of the last decisions, the latest last; the outcome
            of the latest is not known yet.
    """

    rule: Any = None
    past: tuple[tuple[int, tuple[int, int], str, str], ...] = ()

    @classmethod
    def of(cls, memory: Any) -> Remembered:
        """A memory as the mission passes it: None at first, or another rule's."""
        return memory if isinstance(memory, cls) else cls()

    def known(self, view: LeaderView) -> tuple[tuple[int, tuple[int, int], str, str], ...]:
        """The past, with the outcome of the latest decision."""
        if not self.past:
            return ()
        step, cell, reason, outcome = self.past[-1]
        if not outcome:
            # Another leader may have chosen in between: then the outcome is not known.
            same = view.previous in (None, cell)
            outcome = _OUTCOMES.get(view.cause, "given up") if same else "given up"
        return (*self.past[:-1], (step, cell, reason, outcome))

    def lines(self, view: LeaderView, decisions: int) -> str:
        """The last decisions as lines of a prompt."""
        if decisions == 0:
            return ""
        said = []
        for step, cell, reason, outcome in self.known(view)[-decisions:]:
            why = f" because {reason}" if reason else ""
            said.append(f"step {step}: ({cell_name(cell)}){why}: {outcome}")
        return "\n".join(said)

    def after(
        self, view: LeaderView, rule: Any, cell: tuple[int, int], reason: str, decisions: int
    ) -> Remembered:
        """The memory after a decision."""
        if decisions == 0:
            return Remembered(rule)
        past = (*self.known(view), (view.step, cell, reason[:80], ""))
        return Remembered(rule, past[-decisions:])
