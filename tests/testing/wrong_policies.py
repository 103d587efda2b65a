"""Policies that are wrong on purpose, each in one way, and what the check says of it."""

from __future__ import annotations

import random
import time
from typing import Any

import numpy as np


class NoDesired:
    pass


class TwoArguments:
    def desired(self, view: Any, memory: Any) -> Any:
        return np.ones(len(view), dtype=int)


class ReturnsNone:
    def desired(self, view: Any) -> Any:
        return None


class ReturnsOne:
    def desired(self, view: Any) -> Any:
        return 3


class ReturnsFloats:
    def desired(self, view: Any) -> Any:
        return view.frontiers / 7 + 1


class TooShort:
    def desired(self, view: Any) -> Any:
        return np.ones(len(view) - 1, dtype=int)


class OnlyLeaders:
    def desired(self, view: Any) -> Any:
        return view.team_size[view.leads] + 1


class Nothing:
    def desired(self, view: Any) -> Any:
        return view.frontiers_within(2.0)


class Negative:
    def desired(self, view: Any) -> Any:
        return 3 - view.robots_within(30.0)


class Endless:
    def desired(self, view: Any) -> Any:
        return np.full(len(view), np.iinfo(np.int64).max)


class WritesCharge:
    def desired(self, view: Any) -> Any:
        view.charge[:] = 1.0
        return np.ones(len(view), dtype=int)


class SortsFrontiers:
    def desired(self, view: Any) -> Any:
        view.frontiers.sort()
        return np.ones(len(view), dtype=int)


class WritesStep:
    def desired(self, view: Any) -> Any:
        view.step = 3
        return np.ones(len(view), dtype=int)


class UnlocksCharge:
    def desired(self, view: Any) -> Any:
        charge = view.charge
        charge.flags.writeable = True
        charge[:] = 1.0
        return np.ones(len(view), dtype=int)


class CountsInItself:
    def __init__(self) -> None:
        self.calls = 0

    def desired(self, view: Any) -> Any:
        self.calls += 1
        return np.ones(len(view), dtype=int)


class ReadsMinds:
    def desired(self, view: Any) -> Any:
        return np.maximum(view._minds.own["size"], 1)


class DrawsFromRandom:
    def desired(self, view: Any) -> Any:
        return np.full(len(view), random.randint(1, 5))


class DrawsFromNumpy:
    def desired(self, view: Any) -> Any:
        return np.random.randint(1, 5, len(view))  # noqa: NPY002


class DependsOnGlobalState:
    def desired(self, view: Any) -> Any:
        return np.full(len(view), 1 + random.getstate()[1][1] % 5)


class FreshGenerator:
    def desired(self, view: Any) -> Any:
        return np.random.default_rng().integers(1, 1000, len(view))


class LooksAtTheClock:
    def desired(self, view: Any) -> Any:
        return np.full(len(view), 1 + int(time.time()) // 1000 % 7)


class MeanCharge:
    def desired(self, view: Any) -> Any:
        return np.full(len(view), 1 + int(1000 * view.charge.mean()))


class Ranks:
    def desired(self, view: Any) -> Any:
        return 1 + np.argsort(np.argsort(view.charge))


class Shifted:
    def desired(self, view: Any) -> Any:
        return 1 + np.roll(view.robots_within(2.0), 1)


class NeedsAFrontier:
    def desired(self, view: Any) -> Any:
        return np.array([1 + 30 // n for n in view.frontiers.tolist()])


class NeedsTwoRobots:
    def desired(self, view: Any) -> Any:
        assert len(view) > 1
        return np.ones(len(view), dtype=int)


class NeedsOthers:
    def desired(self, view: Any) -> Any:
        return np.array([int(distance_m) + 1 for distance_m in view.nearest_stranger_m])


MISTAKES: list[tuple[type, str]] = [
    (NoDesired, "has no method desired(view)"),
    (TwoArguments, "does not take one argument, desired(view)"),
    (ReturnsNone, "returned None, expected int64[8], a size for each robot"),
    (ReturnsOne, "the same for all is np.full(len(view), 3)"),
    (ReturnsFloats, "returned float64[8], expected int64[8]"),
    (TooShort, "returned int64[7], expected int64[8]"),
    (OnlyLeaders, "expected int64[8], a size for each robot"),
    (Nothing, "answered 0 for robot"),
    (Negative, "expected 1 to 100,000"),
    (Endless, "expected 1 to 100,000"),
    (WritesCharge, "tries to change its view"),
    (SortsFrontiers, "tries to change its view"),
    (WritesStep, "tries to change its view"),
    (UnlocksCharge, "changed its view"),
    (CountsInItself, "changed itself (attribute 'calls')"),
    (ReadsMinds, "reads '_minds' of its view, which is private"),
    (DrawsFromRandom, "draws from the global generator of random"),
    (DrawsFromNumpy, "draws from the global generator of numpy.random"),
    (DependsOnGlobalState, "depends on global randomness"),
    (FreshGenerator, "is not deterministic"),
    (LooksAtTheClock, "depends on the clock"),
    (MeanCharge, "looks at other rows"),
    (Ranks, "looks at other rows"),
    (Shifted, "looks at other rows"),
    (NeedsAFrontier, "ZeroDivisionError"),
    (NeedsTwoRobots, "(with one robot)"),
    (NeedsOthers, "(with one robot)"),
]
