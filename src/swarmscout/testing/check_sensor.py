"""A conformance check for range sensors: run it in the tests of your own sensor.

It tries a sensor in situations and in short missions, and says in one error which part of the
contract of :class:`swarmscout.robots.sensors.sensor.Sensor` is broken, and how.
"""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np

from swarmscout.core.scan import Scan
from swarmscout.robots.bodies import Bodies
from swarmscout.robots.sensors.registry import SENSORS
from swarmscout.robots.sensors.sensor import checked_scan
from swarmscout.testing.harness import Report
from swarmscout.testing.small_worlds import short_mission
from swarmscout.testing.truth_guard import TruthGuard
from swarmscout.worlds.world import World

__all__ = ["check_sensor"]

CHECKS = (
    "has scan(bodies, world, step)",
    "returns a Scan: ranges float64[N, beams], each from 0 to max_range_m or inf; directions "
    "int64[beams]",
    "has the same beams in every step, in every world and for any number of robots",
    "a robot that is not alive measures inf, and others measure the same as before",
    "changes neither the bodies nor the world",
    "neither draws from nor depends on the global generators of random and numpy.random",
    "gives the same scan for the same bodies, world and step, in any order of steps",
)


def check_sensor(sensor: Any, *, missions: int = 1, seed: int = 0) -> Report:
    """Check that a range sensor keeps to its contract.

    Args:
        sensor: an instance, a class that needs no arguments, a registered name, or
            ``path/to/file.py:ClassName``.
        missions: number of short missions in small caves, each run twice.
        seed: names the situations and the caves.

    Returns:
        What was checked; print it if you like.

    Raises:
        SensorError: which rule was broken, in which situation.

    Example:
        >>> check_sensor("lidar", missions=0).checks[0]
        'has scan(bodies, world, step)'
    """
    return _Asking(sensor).tried(
        lambda asking, k: short_mission(k, sensor=asking.rule), missions, seed
    )


class _Asking(TruthGuard):
    """Asks a sensor while watching what it draws and changes."""

    registry = SENSORS
    checks = CHECKS
    answer_noun = "scans"
    before: Scan | None = None

    def check(self, bodies: Bodies, world: World) -> None:
        """Check all that shows in one place."""
        first = self.steady(
            lambda step, globals_seed: self._scan(bodies, world, step, globals_seed), (0, 1, 60)
        )
        dead = dataclasses.replace(bodies, alive=bodies.alive.copy())
        dead.alive[::2] = False
        scan = self._scan(dead, world, 1)
        if np.isfinite(scan.ranges[::2]).any():
            self.blame("measures with a robot that is not alive: its ranges have to be inf")
        if (scan.ranges[1::2] != first[1].ranges[1::2]).any():
            self.blame("measures something else with one robot when another is not alive")

    def _scan(self, bodies: Bodies, world: World, step: int, globals_seed: int = 1) -> Scan:
        def question() -> Scan:
            return checked_scan(self.rule, self.name, bodies, world, step, self.before)

        scan = self.call(question, bodies, world, globals_seed)
        self.before = self.before or scan
        # A sensor may hand out the same array again: keep what it held.
        return dataclasses.replace(scan, ranges=scan.ranges.copy())
