"""A conformance check for range sensors: run it in the tests of your own sensor.

It tries a sensor in situations and in short missions, and says in one error which part of the
contract of :class:`swarmscout.robots.sensors.sensor.Sensor` is broken, and how.
"""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np

from swarmscout.core.scan import Scan
from swarmscout.core.streams import stream
from swarmscout.robots.bodies import TICKS, Bodies, place_bodies
from swarmscout.robots.sensors.registry import SENSORS
from swarmscout.robots.sensors.sensor import checked_scan
from swarmscout.testing.fingerprints import fingerprint
from swarmscout.testing.harness import Report, TruthGuard
from swarmscout.testing.small_worlds import short_mission, small_world
from swarmscout.worlds.world import World

__all__ = ["check_sensor", "sensed_places"]

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
    asking = _Asking(SENSORS, sensor)
    tried = []
    for words, bodies, world in sensed_places(seed):
        asking.where = f"with {words}"
        asking.check(bodies, world)
        tried.append(words)
    tried += asking.fly(lambda k: short_mission(k, sensor=asking.rule), missions, seed)
    return Report("sensor", asking.name, CHECKS, tuple(tried), asking.calls)


class _Asking(TruthGuard):
    """Asks a sensor while watching what it draws and changes."""

    before: Scan | None = None

    def check(self, bodies: Bodies, world: World) -> None:
        """Check all that shows in one place."""
        first = [self._scan(bodies, world, step) for step in (0, 1, 60)]
        again = [self._scan(bodies, world, step) for step in (60, 0, 1)]
        other_globals = self._scan(bodies, world, 1, globals_seed=2)
        if fingerprint(other_globals) != fingerprint(again[2]):
            self.blame("depends on global randomness: draw from stream(bodies.seed, PURPOSE, step)")
        if [fingerprint(scan) for scan in first] != [fingerprint(again[k]) for k in (1, 2, 0)]:
            self.blame(
                "is not deterministic: it gave two different scans for the same bodies, world and "
                "step; draw from stream(bodies.seed, PURPOSE, step)"
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


def sensed_places(seed: int) -> list[tuple[str, Bodies, World]]:
    """Places to sense in, in words, each with its robots."""
    cave = small_world(seed)
    room = World("room", np.ones((80, 80), dtype=np.uint8), 0.1, (-4.0, 3.0))
    cell = np.zeros((3, 3), dtype=np.uint8)
    cell[1, 1] = 1
    field = World("field", np.ones((3000, 3000), dtype=np.uint8), 0.1)
    return [
        ("robots all over a cave", _robots(cave, 9, seed), cave),
        ("one robot", _robots(cave, 1, seed), cave),
        ("robots in an empty room", _robots(room, 6, seed), room),
        ("a robot with walls all around", _robots(World("cell", cell, 0.5), 2, seed),
         World("cell", cell, 0.5)),
        ("nothing within reach", _robots(field, 3, seed, 150.0), field),
    ]  # fmt: skip


def _robots(world: World, robots: int, seed: int, place_m: float | None = None) -> Bodies:
    rng = stream(seed, "check sensor", robots)
    cells = np.argwhere(world.free)
    position = world.frame.centres_of(cells[rng.integers(len(cells), size=robots)])
    if place_m is not None:
        position = place_m + rng.uniform(-1.0, 1.0, (robots, 2))
    return place_bodies(position, rng.integers(0, TICKS, robots), np.full(robots, 9.0), seed=seed)
