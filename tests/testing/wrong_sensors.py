"""Sensors that are wrong on purpose, each in one way, and what the check says of it."""

from __future__ import annotations

import random
from typing import Any

import numpy as np

from swarmscout.core.scan import Scan

AHEAD = np.array([-300, 0, 300])


def blind(bodies: Any, beams: int = 3) -> Any:
    return np.full((len(bodies.heading), beams), np.inf)


class NoScan:
    pass


class TwoArguments:
    def scan(self, bodies: Any, world: Any) -> Any:
        return Scan(blind(bodies), AHEAD, 1.0)


class ReturnsRanges:
    def scan(self, bodies: Any, world: Any, step: int) -> Any:
        return blind(bodies)


class ReturnsNothing:
    def scan(self, bodies: Any, world: Any, step: int) -> Any:
        return None


class OneRowShort:
    def scan(self, bodies: Any, world: Any, step: int) -> Any:
        return Scan(blind(bodies)[1:], AHEAD, 1.0)


class Transposed:
    def scan(self, bodies: Any, world: Any, step: int) -> Any:
        return Scan(np.asfortranarray(np.full((len(bodies.heading), 3), np.inf)), AHEAD, 1.0)


class SinglePrecision:
    def scan(self, bodies: Any, world: Any, step: int) -> Any:
        return Scan(blind(bodies).astype(np.float32), AHEAD, 1.0)


class Degrees:
    def scan(self, bodies: Any, world: Any, step: int) -> Any:
        return Scan(blind(bodies), np.array([-30.0, 0.0, 30.0]), 1.0)


class NoBeams:
    def scan(self, bodies: Any, world: Any, step: int) -> Any:
        return Scan(blind(bodies, 0), AHEAD[:0], 1.0)


class Negative:
    def scan(self, bodies: Any, world: Any, step: int) -> Any:
        return Scan(np.full((len(bodies.heading), 3), -0.1), AHEAD, 1.0)


class BeyondItsRange:
    def scan(self, bodies: Any, world: Any, step: int) -> Any:
        return Scan(np.where(bodies.alive[:, None], 1.2, blind(bodies)), AHEAD, 1.0)


class NotANumber:
    def scan(self, bodies: Any, world: Any, step: int) -> Any:
        return Scan(np.full((len(bodies.heading), 3), np.nan), AHEAD, 1.0)


class EndlessRange:
    def scan(self, bodies: Any, world: Any, step: int) -> Any:
        return Scan(blind(bodies), AHEAD, np.inf)


class OpeningInDegrees:
    def scan(self, bodies: Any, world: Any, step: int) -> Any:
        return Scan(blind(bodies), AHEAD, 1.0, 22.5)


class Turning:
    def scan(self, bodies: Any, world: Any, step: int) -> Any:
        return Scan(blind(bodies), AHEAD + step, 1.0)


class DeadStillSee:
    def scan(self, bodies: Any, world: Any, step: int) -> Any:
        return Scan(np.full((len(bodies.heading), 3), 0.5), AHEAD, 1.0)


class ShiftedByTheDead:
    def scan(self, bodies: Any, world: Any, step: int) -> Any:
        ranges = blind(bodies)
        ranges[bodies.alive] = 0.01 * np.arange(bodies.alive.sum())[:, None]
        return Scan(ranges, AHEAD, 1.0)


class MovesRobots:
    def scan(self, bodies: Any, world: Any, step: int) -> Any:
        bodies.position += 0.1
        return Scan(blind(bodies), AHEAD, 1.0)


class DigsTunnels:
    def scan(self, bodies: Any, world: Any, step: int) -> Any:
        world.free[:] = 1
        return Scan(blind(bodies), AHEAD, 1.0)


class DrawsFromNumpy:
    def scan(self, bodies: Any, world: Any, step: int) -> Any:
        ranges = np.where(bodies.alive[:, None], np.random.random(), blind(bodies))  # noqa: NPY002
        return Scan(ranges, AHEAD, 1.0)


class DependsOnGlobalState:
    def scan(self, bodies: Any, world: Any, step: int) -> Any:
        noise = random.getstate()[1][1] / 2**32
        return Scan(np.where(bodies.alive[:, None], noise, blind(bodies)), AHEAD, 1.0)


class FreshGenerator:
    def scan(self, bodies: Any, world: Any, step: int) -> Any:
        noise = np.random.default_rng().random()
        return Scan(np.where(bodies.alive[:, None], noise, blind(bodies)), AHEAD, 1.0)


class CountsItsCalls:
    def __init__(self) -> None:
        self.calls = 0

    def scan(self, bodies: Any, world: Any, step: int) -> Any:
        self.calls += 1
        ranges = np.where(bodies.alive[:, None], 1.0 / self.calls, blind(bodies))
        return Scan(ranges, AHEAD, 1.0)


class NeedsTwoRobots:
    def scan(self, bodies: Any, world: Any, step: int) -> Any:
        return Scan(blind(bodies) + bodies.charge[1], AHEAD, 1.0)


MISTAKES: list[tuple[type, str]] = [
    (NoScan, "has no method scan(bodies, world, step)"),
    (TwoArguments, "does not take three arguments"),
    (ReturnsRanges, "scan returned an array of float64, expected a swarmscout.core.scan.Scan"),
    (ReturnsNothing, "scan returned None"),
    (OneRowShort, "ranges have shape (8, 3), expected (9, 3)"),
    (Transposed, "have to be C-contiguous"),
    (SinglePrecision, "ranges are an array of float32, expected float64[9, 3]"),
    (Degrees, "directions are an array of float64, expected int64[beams] in ticks of 0.1°"),
    (NoBeams, "expected one number for each beam"),
    (Negative, "measured -0.1, expected 0 to max_range_m = 1, or inf"),
    (BeyondItsRange, "measured 1.2, expected 0 to max_range_m = 1, or inf"),
    (NotANumber, "measured nan"),
    (EndlessRange, "max_range_m = inf, expected more than 0 and at most 100"),
    (OpeningInDegrees, "opening = 22.5, expected a whole number from 0 to 1800"),
    (Turning, "differ from the scan before"),
    (DeadStillSee, "measures with a robot that is not alive"),
    (ShiftedByTheDead, "when another is not alive"),
    (MovesRobots, "changed the bodies"),
    (DigsTunnels, "read-only"),
    (DrawsFromNumpy, "draws from the global generator of numpy.random"),
    (DependsOnGlobalState, "depends on global randomness"),
    (FreshGenerator, "stream(bodies.seed, PURPOSE, step)"),
    (CountsItsCalls, "stream(bodies.seed, PURPOSE, step)"),
    (NeedsTwoRobots, "(with one robot)"),
]
