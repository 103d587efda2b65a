"""A conformance check for radios: run it in the tests of your own radio.

It tries a radio in situations and in short missions, and says in one error which part of the
contract of :class:`swarmscout.robots.radio.radio.Radio` is broken, and how.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from swarmscout.robots.bodies import Bodies
from swarmscout.robots.radio.radio import links_now
from swarmscout.robots.radio.registry import RADIOS
from swarmscout.testing.harness import Report
from swarmscout.testing.small_worlds import short_mission
from swarmscout.testing.truth_guard import TruthGuard
from swarmscout.worlds.world import World

__all__ = ["check_radio"]

CHECKS = (
    "has links(step, bodies, world)",
    "returns Links of N robots, or bool[N, N], for any number of robots and any step",
    "changes neither the bodies nor the world",
    "neither draws from nor depends on the global generators of random and numpy.random",
    "gives the same links for the same bodies, world and step, in any order of steps",
)


def check_radio(radio: Any, *, missions: int = 1, seed: int = 0) -> Report:
    """Check that a radio keeps to its contract.

    Args:
        radio: an instance, a class that needs no arguments, a registered name, or
            ``path/to/file.py:ClassName``.
        missions: number of short missions in small caves, each run twice.
        seed: names the situations and the caves.

    Returns:
        What was checked; print it if you like.

    Raises:
        ScenarioError: which rule was broken, in which situation.

    Example:
        >>> check_radio("disc", missions=0).checks[0]
        'has links(step, bodies, world)'
    """
    return _Asking(radio).tried(
        lambda asking, k: short_mission(k, radio=asking.rule), missions, seed
    )


class _Asking(TruthGuard):
    """Asks a radio while watching what it draws and changes."""

    registry = RADIOS
    checks = CHECKS
    answer_noun = "answers"

    def check(self, bodies: Bodies, world: World) -> None:
        """Check all that shows in one place."""
        self.steady(
            lambda step, globals_seed: self._links(bodies, world, step, globals_seed), (1, 2, 60)
        )

    def _links(
        self, bodies: Bodies, world: World, step: int, globals_seed: int = 1
    ) -> NDArray[np.bool_]:
        def question() -> NDArray[np.bool_]:
            return links_now(self.rule, self.name, step, bodies, world).matrix()

        return self.call(question, bodies, world, globals_seed)
