"""The interface of every radio, and what a mission makes of it."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from swarmscout.core.errors import ScenarioError
from swarmscout.core.links import Links
from swarmscout.core.tracebacks import describe_error
from swarmscout.robots.bodies import Bodies
from swarmscout.worlds.world import World

__all__ = ["Radio", "ScriptedRadio", "links_now"]


@runtime_checkable
class Radio(Protocol):
    """Says who hears whom.

    Example:
        >>> from dataclasses import dataclass
        >>> @dataclass(frozen=True)
        ... class EvenSteps:
        ...     '''Robots hear each other in every second step.'''
        ...     def links(self, step, bodies, world):
        ...         robots = len(bodies.position)
        ...         return np.full((robots, robots), step % 2 == 0)
    """

    def links(self, step: int, bodies: Bodies, world: World) -> Links | NDArray[np.bool_]:
        """Who is in whose range in a step.

        Args:
            step: the current step, from 1.
            bodies: the truth about N robots: ``bodies.position`` is float64[N, 2] in metres.
            world: the truth about the world.

        Returns:
            :class:`~swarmscout.core.links.Links`, or bool[N, N]: element (i, j) says whether robot
            i hears robot j.
        """
        ...


class ScriptedRadio:
    """Links that a function of the step gives, for tests and trials by hand.

    Args:
        function: a step to bool[N, N].

    Raises:
        ScenarioError: it is not a function.
    """

    def __init__(self, function: Callable[[int], Any]) -> None:
        if not callable(function):
            raise ScenarioError(
                f"links is a {type(function).__name__}, expected a function of the step that "
                "returns bool[N, N]: for the same links in every step, links=lambda step: matrix"
            )
        self._function = function

    def links(self, step: int, bodies: Bodies, world: World) -> Links:
        """Who hears whom, as the function says."""
        return Links.of_matrix(self._function(step), len(bodies.alive), f"links({step})")


def links_now(radio: Radio, name: str, step: int, bodies: Bodies, world: World) -> Links:
    """Ask a radio, and check what it answers.

    Args:
        radio: which one. name: what it is called in errors.
        step: the current step. bodies, world: the truth.

    Raises:
        ScenarioError: the radio failed, or answered something else than links of N robots.
    """
    if isinstance(radio, ScriptedRadio):
        return radio.links(step, bodies, world)
    try:
        answer = radio.links(step, bodies, world)
    except ScenarioError:
        raise
    except (Exception, SystemExit) as error:
        raise ScenarioError(
            f"radio '{name}' failed in step {step}: {describe_error(error)}"
        ) from error
    robots = len(bodies.alive)
    if not isinstance(answer, Links):
        return Links.of_matrix(answer, robots, f"radio '{name}' in step {step}")
    if answer.robots != robots:
        raise ScenarioError(
            f"radio '{name}' returned links of {answer.robots} robots in step {step}, "
            f"expected {robots}"
        )
    return answer
