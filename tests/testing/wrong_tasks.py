"""Tasks that are wrong on purpose, each in one way, and what the check says of it."""

from __future__ import annotations

import time
from typing import Any

import numpy as np

from swarmscout.tasks.exploration import Exploration


class NoCandidates:
    pass


class TwoMaps(Exploration):
    def candidates(self, map: Any, step: int, other: Any) -> Any:  # type: ignore[override]
        return super().candidates(map, step)


class Fails(Exploration):
    def candidates(self, map: Any, step: int) -> Any:
        return map.labels[40, 40]


class ReturnsCells(Exploration):
    def candidates(self, map: Any, step: int) -> Any:
        return map.frontiers()


class Transposed(Exploration):
    def candidates(self, map: Any, step: int) -> Any:
        return super().candidates(map, step).T


class SaysTrue(Exploration):
    def done(self, map: Any, explored_m2: float, reachable_m2: float) -> Any:
        return True


class ScoresNothing(Exploration):
    def score(self, map: Any, explored_m2: float) -> Any:
        return None


class ChangesTheMap(Exploration):
    def candidates(self, map: Any, step: int) -> Any:
        map.evidence[0, 0] = 1
        return super().candidates(map, step)


class ChangesItself(Exploration):
    def candidates(self, map: Any, step: int) -> Any:
        object.__setattr__(self, "asked_in", step)
        return super().candidates(map, step)


class LooksAtAllMaps(Exploration):
    def candidates(self, map: Any, step: int) -> Any:
        return super().candidates(map, step) & (map._grids.counts[:, 0] >= 0)


class DrawsFromNumpy(Exploration):
    def candidates(self, map: Any, step: int) -> Any:
        return super().candidates(map, step) | (np.random.random(map.frame.shape) < 0.5)  # noqa: NPY002


class DrawsAnew(Exploration):
    def candidates(self, map: Any, step: int) -> Any:
        return super().candidates(map, step) | (
            np.random.default_rng().random(map.frame.shape) < 0.5
        )


class LooksAtTheClock(Exploration):
    def candidates(self, map: Any, step: int) -> Any:
        return super().candidates(map, step) | (time.time() % 1e6 < 5e5) | (time.time() > 2e9)

    def done(self, map: Any, explored_m2: float, reachable_m2: float) -> Any:
        return f"it is {time.time() // 1000:.0f}"


MISTAKES = [
    (NoCandidates, "it has no method candidates(map, step)"),
    (TwoMaps, "does not take two arguments, candidates(map, step)"),
    (Fails, "failed: IndexError"),
    (ReturnsCells, "returned an array of int64 as candidates, expected bool[rows, columns]"),
    (Transposed, "returned candidates of shape (40, 30), expected map.frame.shape = (30, 40)"),
    (SaysTrue, "returned True in done, expected the reason in words, or None to go on"),
    (ScoresNothing, "returned None in score, expected a number"),
    (ChangesTheMap, "tries to change its view, which is read-only"),
    (ChangesItself, "changed itself (attribute 'asked_in')"),
    (LooksAtAllMaps, "reads '_grids' of its view, which is private"),
    (DrawsFromNumpy, "draws from the global generator of numpy.random; a task draws nothing"),
    (DrawsAnew, "is not deterministic"),
    (LooksAtTheClock, "depends on the clock"),
]
