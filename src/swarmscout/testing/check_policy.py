"""A conformance check for policies of the desired team size: run it in the tests of your own.

It tries a policy in situations of short missions, and says in one error which part of the contract
of :class:`swarmscout.teams.policy.DesiredSizePolicy` is broken, and how.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from swarmscout.core.errors import PolicyError
from swarmscout.teams.policy import LARGEST, DesiredSizePolicy
from swarmscout.teams.registry import POLICIES
from swarmscout.teams.robots_view import RobotsView
from swarmscout.testing.harness import how_it_went, instance_of, report_text
from swarmscout.testing.instrumented_policy import answered
from swarmscout.testing.policy_situations import PolicySituation, policy_situations, short_mission

__all__ = ["PolicyReport", "check_policy"]

CHECKS = (
    "has desired(view)",
    f"returns a size for each robot, in whole numbers from 1 to {LARGEST:,}",
    "changes neither its view nor itself",
    "reads nothing private of its view",
    "neither draws from nor depends on the global generators of random and numpy.random",
    "gives the same answer to the same view, whatever the clock says",
    "robot i's size depends on row i of the view alone",
)

EACH = 5
"""In missions, answers of every so many steps are asked for again."""


@dataclass(frozen=True, slots=True)
class PolicyReport:
    """What was checked, and held.

    Attributes:
        name: the policy's.
        checks: one line for each part of the contract.
        situations: in words, what the policy was confronted with.
        answers: how often it was asked in all.
    """

    name: str
    checks: tuple[str, ...]
    situations: tuple[str, ...]
    answers: int

    def __str__(self) -> str:
        """All of it as text."""
        sound = f"policy '{self.name}' is sound ({self.answers} answers)"
        return report_text(sound, self.checks, self.situations)


def check_policy(policy: Any, *, missions: int = 2, seed: int = 0) -> PolicyReport:
    """Check that a policy keeps to its contract.

    Args:
        policy: an instance, a class that needs no arguments, a registered name, or
            ``path/to/file.py:ClassName``.
        missions: so many short missions in small caves are run to their end (each twice); in every
            second one each robot has a map of its own.
        seed: makes the situations and the caves.

    Returns:
        What was checked; print it if you like.

    Raises:
        PolicyError: which rule was broken, in which situation.

    Example:
        >>> from swarmscout.teams.by_mode import ByMode
        >>> check_policy(ByMode()).checks[0]
        'has desired(view)'
    """
    rule, name = instance_of(POLICIES, policy)
    guard = _Guard(rule, name)
    tried = []
    for situation in policy_situations(seed):
        guard.where = f"with {situation.words}"
        guard.check(situation)
        tried.append(situation.words)
    guard.where = ""
    for k in range(missions):
        if _mission(guard, seed + k, alone=False) != _mission(rule, seed + k, alone=True):
            raise PolicyError(
                f"policy '{name}' is not deterministic: the same mission in "
                f"small_world({seed + k}) went differently when it was run again"
            )
    if missions:
        tried.append(f"{missions} missions in small caves, to the end, each twice")
    return PolicyReport(name, CHECKS, tuple(tried), guard.answers)


class _Guard:
    """A policy that asks another one, several times, and checks each answer."""

    def __init__(self, rule: DesiredSizePolicy, name: str) -> None:
        self.rule = rule
        self.name = name
        self.where = ""
        self.answers = 0

    def desired(self, view: RobotsView) -> Any:
        """What the rule answers, if it keeps to the contract."""
        self.answers += 1
        # Asking four times and looking at everything takes longer than a mission.
        once = not self.where and view.step % EACH != 1
        try:
            return answered(self.rule, view, once=once)
        except PolicyError as error:
            where = self.where or f"in step {view.step} of a mission"
            raise PolicyError(f"policy '{self.name}' {error} ({where})") from error.__cause__

    def check(self, situation: PolicySituation) -> None:
        """Ask in a situation; then again for each robot, with all other rows replaced."""
        told = self.desired(situation.view)
        for robot in range(len(situation.view)):
            self.answers += 1
            try:
                mixed = answered(self.rule, situation.view, (robot, situation.other), once=True)
            except PolicyError as error:
                raise PolicyError(
                    f"policy '{self.name}' {error} ({self.where})"
                ) from error.__cause__
            if mixed[robot] != told[robot]:
                raise PolicyError(
                    f"policy '{self.name}' looks at other rows: it gives robot {robot} the size "
                    f"{told[robot]}, and {mixed[robot]} where only other robots' rows differ; "
                    f"element i may depend on row i alone ({self.where})"
                )


def _mission(rule: DesiredSizePolicy, seed: int, *, alone: bool) -> tuple[Any, ...]:
    """Run a short mission with a policy to its end; how it went."""
    mission = short_mission(seed, own_maps=seed % 2 == 1, policy=rule)
    return how_it_went(POLICIES, mission, guarded=not alone)
