"""The part of the conformance harness for plug-ins that read the truth: sensors and radios."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable
from typing import ClassVar, NoReturn, Self, TypeVar

from swarmscout.mission.mission import Mission
from swarmscout.robots.bodies import Bodies
from swarmscout.testing.fingerprints import (
    drawn_from,
    fingerprint,
    global_states,
    seeded_globals,
)
from swarmscout.testing.harness import PlugInCheck, Report
from swarmscout.testing.small_worlds import places_with_robots
from swarmscout.worlds.world import World

__all__ = ["TruthGuard"]

R = TypeVar("R")


class TruthGuard(PlugInCheck, ABC):
    """Calls a plug-in that reads the truth (a sensor, a radio), and checks that it changes nothing.

    Attributes:
        answer_noun: what its answers are called in errors.
    """

    answer_noun: ClassVar[str]

    @abstractmethod
    def check(self, bodies: Bodies, world: World) -> None:
        """Check all that shows in one place."""

    def tried(self, make: Callable[[Self, int], Mission], missions: int, seed: int) -> Report:
        """Check in many places and in missions.

        Args:
            make, missions: see :meth:`fly`.
            seed: of the places and the missions.

        Raises:
            SwarmscoutError: the kind's own error: which rule was broken, and where.
        """
        places = []
        for words, bodies, world in places_with_robots(seed):
            self.where = f"with {words}"
            self.check(bodies, world)
            places.append(words)
        return self.report(places + self.fly(make, missions, seed))

    def steady(self, ask: Callable[[int, int], R], steps: tuple[int, int, int]) -> list[R]:
        """Ask for three steps in two orders, and once with other seeds of the global generators.

        Args:
            ask: the answer of a step, with a seed of the global generators; see :meth:`call`.
            steps: which.

        Returns:
            The answers to the three steps.
        """
        first, second, third = steps
        answers = [ask(step, 1) for step in (first, second, third)]
        again = [ask(step, 1) for step in (third, first, second)]
        if fingerprint(ask(second, 2)) != fingerprint(again[2]):
            self.blame("depends on global randomness: draw from stream(bodies.seed, PURPOSE, step)")
        if fingerprint(answers) != fingerprint(again[1:] + again[:1]):
            self.blame(
                f"is not deterministic: it gave two different {self.answer_noun} for the same "
                "bodies, world and step; draw from stream(bodies.seed, PURPOSE, step)"
            )
        return answers

    def call(
        self, question: Callable[[], R], bodies: Bodies, world: World, globals_seed: int = 1
    ) -> R:
        """Ask, and look afterwards at everything that it may not change.

        Args:
            question: asks the plug-in.
            bodies, world: what it is shown.
            globals_seed: seed of the global generators meanwhile.
        """
        self.answers += 1
        held = fingerprint(bodies), world.free.tobytes()
        with seeded_globals(globals_seed):
            states = global_states()
            try:
                answer = question()
            except self.registry.error as error:
                raise self._error(f"{error} ({self.where})") from error.__cause__
            drawn = drawn_from(states)
        if drawn:
            self.blame(
                f"draws from the global generator of {drawn[0]}: draw from "
                "stream(bodies.seed, PURPOSE, step)"
            )
        if fingerprint(bodies) != held[0]:
            self.blame("changed the bodies")
        if world.free.tobytes() != held[1]:
            self.blame("changed the world")
        return answer

    def blame(self, what: str) -> NoReturn:
        """Raise the kind's error: which part of the contract is broken, and where."""
        raise self._error(f"{self._subject} {what} ({self.where})")
