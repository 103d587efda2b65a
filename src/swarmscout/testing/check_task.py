"""The conformance check of tasks: run it in the tests of your own.

It asks a task about made-up maps and in short missions, and says in one error which part of the
contract of :class:`swarmscout.tasks.task.Task` is broken, and how.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from swarmscout.core.enums import FREE, UNKNOWN
from swarmscout.core.errors import TaskError
from swarmscout.core.streams import stream
from swarmscout.mapping.occupancy import BeliefView
from swarmscout.mission.mission import Mission
from swarmscout.tasks.checked_task import wrong_candidates, wrong_reason, wrong_score
from swarmscout.tasks.registry import TASKS
from swarmscout.testing.fingerprints import fingerprint
from swarmscout.testing.harness import Guard, Report, note_private_read
from swarmscout.testing.situations import made_up_swarm, patchy_map
from swarmscout.testing.small_worlds import short_mission

__all__ = ["check_task"]

_OWN = {BeliefView.__module__, __name__, Guard.__module__}


def check_task(task: Any, *, missions: int = 2, seed: int = 0) -> Report:
    """Check that a task keeps to its contract.

    Args:
        task: an instance, a class that needs no arguments, a registered name, or
            ``path/to/file.py:ClassName``.
        missions: number of short missions in small caves, each run to its end twice; in every
            second one each robot has a map of its own.
        seed: of the maps and the caves.

    Returns:
        What was checked; it can be printed.

    Raises:
        TaskError: which part of the contract is broken, in which situation.

    Example:
        >>> check_task("exploration", missions=0).checks[0]
        'has candidates(map, step)'
    """
    guard = _TaskGuard(task)
    tried = []
    for words, map in _maps(seed):
        guard.where = f"with {words}"
        for step in (1, 200):
            guard.candidates(map, step)
        tried.append(words)
    tried += guard.fly(_mission, missions, seed)
    return guard.report(tried)


def _mission(guard: _TaskGuard, seed: int) -> Mission:
    return short_mission(seed, own_maps=seed % 2 == 1, task=guard)


def _maps(seed: int) -> Iterator[tuple[str, BeliefView]]:
    patchy = patchy_map(stream(seed, "check task"), 30, 40)
    labels = {
        "a map in parts": patchy,
        "a map of which nothing is known": np.full((30, 40), UNKNOWN, dtype=np.uint8),
        "a map without a frontier": np.full((12, 9), FREE, dtype=np.uint8),
        "a map of few cells": patchy[13:17, 18:21].copy(),
    }
    for words, given in labels.items():
        knowledge = made_up_swarm(given, [(1, 1)], seed=seed)[1]
        yield words, knowledge.grids.view(0)


class _WatchedMap(BeliefView):
    """A map with the step in which it is shown."""

    def __init__(self, map: BeliefView, step: int) -> None:
        super().__init__(map._grids, map._m)
        self.step = step

    def __getattribute__(self, name: str) -> Any:
        note_private_read(self, name, sys._getframe(1), _OWN)
        return object.__getattribute__(self, name)


class _TaskGuard(Guard[_WatchedMap]):
    registry = TASKS
    checks = (
        "has candidates(map, step)",
        "returns bool[rows, columns] for any map",
        "done returns a reason in words, or None; score returns a number",
        "changes neither the map nor itself",
        "reads nothing private of the map",
        "neither draws from nor depends on the global generators of random and numpy.random",
        "gives the same answers to the same map and step, independent of the clock",
    )
    draw_from = "a task draws nothing"
    remember_in = "its answers depend on the map, the step and its own parameters alone"
    spread = 10

    def __init__(self, given: Any) -> None:
        super().__init__(given)
        self.reach_m = self.rule.reach_m

    def candidates(self, map: BeliefView, step: int) -> NDArray[np.bool_]:
        found: NDArray[np.bool_] = self.answer(_WatchedMap(map, step))[0]
        return found

    def done(self, map: BeliefView, explored_m2: float, reachable_m2: float) -> str | None:
        reason: str | None = self.rule.done(map, explored_m2, reachable_m2)
        return reason

    def score(self, map: BeliefView, explored_m2: float) -> float:
        score: float = self.rule.score(map, explored_m2)
        return score

    def ask(self, view: _WatchedMap, memory: Any) -> Any:
        candidates = self.rule.candidates(view, view.step)
        return candidates, self.rule.done(view, 30.0, 120.0), self.rule.score(view, 30.0)

    def watched(self, view: _WatchedMap) -> _WatchedMap:
        return _WatchedMap(view, view.step)

    def look(self, view: _WatchedMap) -> list[Any]:
        return [fingerprint(view.evidence), fingerprint(view.labels), fingerprint(view.frontiers())]

    def checked(self, answer: Any, view: _WatchedMap) -> Any:
        candidates, reason, score = answer
        wrong = wrong_candidates(candidates, view) or wrong_reason(reason) or wrong_score(score)
        if wrong:
            raise TaskError(wrong)
        return answer
