"""The conformance check of policies for the desired team size: run it in the tests of your own.

It tries a policy in situations of short missions, and says in one error which part of the contract
of :class:`swarmscout.teams.policy.DesiredSizePolicy` is broken, and how.
"""

from __future__ import annotations

import sys
from typing import Any

import numpy as np
from numpy.typing import NDArray

from swarmscout.core.errors import PolicyError
from swarmscout.mission.mission import Mission
from swarmscout.teams.desired_size import checked_sizes
from swarmscout.teams.policy import LARGEST
from swarmscout.teams.registry import POLICIES
from swarmscout.teams.robots_view import RobotsView
from swarmscout.testing.fingerprints import fingerprint
from swarmscout.testing.harness import Guard, Report, note_private_read
from swarmscout.testing.policy_situations import PolicySituation, policy_situations
from swarmscout.testing.small_worlds import short_mission

__all__ = ["check_policy"]

_OWN = {RobotsView.__module__, __name__, Guard.__module__}


def check_policy(policy: Any, *, missions: int = 2, seed: int = 0) -> Report:
    """Check that a policy keeps to its contract.

    Args:
        policy: an instance, a class that needs no arguments, a registered name, or
            ``path/to/file.py:ClassName``.
        missions: number of short missions in small caves, each run to its end twice; in every
            second one each robot has a map of its own.
        seed: of the situations and the caves.

    Returns:
        What was checked; it can be printed.

    Raises:
        PolicyError: which part of the contract is broken, in which situation.

    Example:
        >>> from swarmscout.teams.by_mode import ByMode
        >>> check_policy(ByMode()).checks[0]
        'has desired(view)'
    """
    guard = _PolicyGuard(policy)
    tried = []
    for situation in policy_situations(seed):
        guard.where = f"with {situation.words}"
        guard.check_rows(situation)
        tried.append(situation.words)
    tried += guard.fly(_mission, missions, seed)
    return guard.report(tried)


def _mission(guard: _PolicyGuard, seed: int) -> Mission:
    return short_mission(seed, own_maps=seed % 2 == 1, policy=guard)


class _WatchedView(RobotsView):
    """May show another view's rows, but for one robot's."""

    def __init__(self, view: RobotsView, mixed: tuple[int, RobotsView] | None) -> None:
        super().__init__(
            view._minds, view._knowledge, view.step, view.desired_size, view._silence_steps
        )
        self.mixed = mixed

    def __getattribute__(self, name: str) -> Any:
        foreign = note_private_read(self, name, sys._getframe(1), _OWN)
        value = object.__getattribute__(self, name)
        mixed = object.__getattribute__(self, "__dict__").get("mixed")
        if mixed is None or not foreign or name.startswith("_"):
            return value
        robot, other = mixed
        elsewhere = getattr(other, name)
        if callable(value):
            return lambda *given, **named: _mix(
                value(*given, **named), elsewhere(*given, **named), robot
            )
        return _mix(value, elsewhere, robot)


def _mix(mine: Any, theirs: Any, robot: int) -> Any:
    if not isinstance(mine, np.ndarray):
        return mine
    rows = np.array(theirs)
    rows[robot] = mine[robot]
    rows.flags.writeable = False
    return rows


class _PolicyGuard(Guard[RobotsView]):
    registry = POLICIES
    checks = (
        "has desired(view)",
        f"returns a size for each robot, in whole numbers from 1 to {LARGEST:,}",
        "changes neither its view nor itself",
        "reads nothing private of its view",
        "neither draws from nor depends on the global generators of random and numpy.random",
        "gives the same answer to the same view, independent of the clock",
        "robot i's size depends on row i of the view alone",
    )
    draw_from = "a policy draws nothing: robots that know the same desire the same"
    remember_in = "what a policy may remember is view.previous"
    # Asking four times and looking at everything takes longer than a mission.
    spread = 5

    def __init__(self, given: Any) -> None:
        super().__init__(given)
        self._mixed: tuple[int, RobotsView] | None = None

    def desired(self, view: RobotsView) -> NDArray[np.int64]:
        sizes: NDArray[np.int64] = self.answer(view)
        return sizes

    def check_rows(self, situation: PolicySituation) -> None:
        """Ask in a situation; then again for each robot, with all other rows replaced."""
        sizes = self.answer(situation.view)
        for robot in range(len(situation.view)):
            self._mixed = robot, situation.other
            mixed = self.answer(situation.view, once=True)
            self._mixed = None
            if mixed[robot] != sizes[robot]:
                raise PolicyError(
                    f"policy '{self.name}' looks at other rows: it gives robot {robot} the size "
                    f"{sizes[robot]}, and {mixed[robot]} where only other robots' rows differ; "
                    f"element i may depend on row i alone ({self.where})"
                )

    def ask(self, view: RobotsView, memory: Any) -> Any:
        return self.rule.desired(view)

    def watched(self, view: RobotsView) -> RobotsView:
        return _WatchedView(view, self._mixed)

    def look(self, view: RobotsView) -> list[Any]:
        minds, knowledge = view._minds, view._knowledge
        held = (minds.own, knowledge.heard, knowledge.still)
        return [fingerprint(array) for array in held]

    def checked(self, answer: Any, view: RobotsView) -> NDArray[np.int64]:
        sizes = checked_sizes(answer, len(view))
        wrong = np.flatnonzero((sizes < 1) | (sizes > LARGEST))
        if len(wrong):
            raise PolicyError(
                f"answered {sizes[wrong[0]]} for robot {wrong[0]}: expected 1 to {LARGEST:,}"
            )
        return sizes.copy()
