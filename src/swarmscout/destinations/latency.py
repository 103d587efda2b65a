"""Answers that take a while: robots drive on by the rule until the model's choice arrives.

Beyond the paper, which lets the world stand still while a model thinks; off by default.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from swarmscout.destinations.selector import Choice
from swarmscout.destinations.view import LeaderView

__all__ = ["Waiting"]


class Waiting:
    """Choices that are under way.

    Args:
        steps: how long a choice takes; 0: it is there at once.
    """

    def __init__(self, steps: int) -> None:
        self._steps = steps
        self._under_way: dict[int, tuple[int, Choice]] = {}

    def arriving(self, step: int) -> list[int]:
        """Robots whose answer arrives in a step."""
        return sorted(robot for robot, (due, _) in self._under_way.items() if due <= step)

    def holds(self, robot: int) -> bool:
        """Whether a robot waits for an answer."""
        return robot in self._under_way

    def take(self, view: LeaderView) -> Choice | None:
        """The choice that arrives for a robot now, if it can still be followed."""
        due, choice = self._under_way.get(view.robot, (view.step + 1, None))
        if choice is None or due > view.step:
            return None
        del self._under_way[view.robot]
        if not (view.frontiers == choice.cell).all(axis=1).any():
            return None
        details = {**choice.details, "asked_in_step": due - self._steps}
        return replace(choice, details=details, attempts=())

    def drop(self, robot: int) -> None:
        """Forget what a robot waits for: it leads no team any more."""
        self._under_way.pop(robot, None)

    def put(self, view: LeaderView, choice: Choice, rule: Callable[[], Choice]) -> Choice:
        """Let a choice wait.

        Args:
            view: of the robot that asked now.
            choice: what it will learn.
            rule: chooses without a model.

        Returns:
            What counts until then, with the attempts on record.
        """
        if self._steps == 0 or not choice.attempts or choice.details.get("fallback"):
            return choice
        self._under_way[view.robot] = (view.step + self._steps, choice)
        meanwhile = rule()
        details = {**meanwhile.details, "answer_in_step": view.step + self._steps}
        return replace(meanwhile, details=details, attempts=choice.attempts)
