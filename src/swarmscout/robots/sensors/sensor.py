"""The interface of a range sensor, and how a mission uses one."""

from __future__ import annotations

from typing import Protocol, runtime_checkable

import numpy as np

from swarmscout.core.errors import SensorError, kind_in_words
from swarmscout.core.scan import Scan
from swarmscout.core.tracebacks import describe_error
from swarmscout.robots.bodies import TICKS, Bodies
from swarmscout.worlds.world import World

__all__ = ["LONGEST_M", "Scan", "Sensing", "Sensor", "checked_scan"]

LONGEST_M = 100.0
"""The longest range that a sensor may have, in metres."""


@runtime_checkable
class Sensor(Protocol):
    """Measures ranges, for all robots at once.

    The scan depends on the arguments and on the sensor's own parameters alone: the same bodies,
    world and step give the same scan. Noise comes from ``stream(bodies.seed, purpose, step)`` of
    :mod:`swarmscout.core.streams`. Neither bodies nor world may be changed.
    ``swarmscout.testing.check_sensor`` checks all this.
    """

    def scan(self, bodies: Bodies, world: World, step: int) -> Scan:
        """Measure once with every robot.

        Args:
            bodies: the truth about N robots.
            world: what their beams meet.
            step: the current step; 0 before the mission starts.

        Returns:
            The scan. Beams, longest range and opening are the same in every step, and a robot that
            is not alive measures inf.
        """
        ...


class Sensing:
    """A sensor in a mission: each scan is checked before minds get it.

    The sensor is asked once for step 0, so that one that fails does so before the mission starts.

    Attributes:
        sensor: what measures.
        name: what it is called in errors.
        last: the last scan.

    Args:
        sensor, name: see above.
        bodies: the mission's robots.
        world: what their beams meet.

    Raises:
        SensorError: the sensor failed, or its scan cannot be used.
    """

    def __init__(self, sensor: Sensor, name: str, bodies: Bodies, world: World) -> None:
        self.sensor = sensor
        self.name = name
        self._world = world
        self._trusted = type(sensor).__module__.startswith("swarmscout.")
        self.last = checked_scan(sensor, name, bodies, world, 0)

    def scan(self, bodies: Bodies, step: int) -> Scan:
        """Measure once with all robots.

        Raises:
            SensorError: as above.
        """
        if self._trusted:
            self.last = self.sensor.scan(bodies, self._world, step)
        else:
            self.last = checked_scan(self.sensor, self.name, bodies, self._world, step, self.last)
        return self.last


def checked_scan(
    sensor: Sensor, name: str, bodies: Bodies, world: World, step: int, before: Scan | None = None
) -> Scan:
    """Ask a sensor, and check what it returns.

    Args:
        sensor: what is asked; name: what it is called in errors.
        bodies, world, step: see :meth:`Sensor.scan`.
        before: an earlier scan, whose beams the new one has to have.

    Raises:
        SensorError: the sensor failed, or the scan cannot be used; the message says why.
    """
    where = f"sensor '{name}' in step {step}"
    try:
        scan = sensor.scan(bodies, world, step)
    except (Exception, SystemExit) as error:
        raise SensorError(f"{where} failed: {describe_error(error)}") from error
    wrong = _wrong_with(scan, len(bodies.heading))
    if wrong is None and before is not None:
        same = (
            np.array_equal(scan.directions, before.directions)
            and scan.max_range_m == before.max_range_m
            and scan.opening == before.opening
        )
        if not same:
            wrong = "directions, max_range_m or opening differ from the scan before; they may not"
    if wrong is not None:
        raise SensorError(f"{where}: {wrong}")
    return scan


def _wrong_with(scan: object, robots: int) -> str | None:
    """What is wrong with a scan in itself, or None."""
    if not isinstance(scan, Scan):
        return f"scan returned {kind_in_words(scan)}, expected a swarmscout.core.scan.Scan"
    ranges, directions = scan.ranges, scan.directions
    if not (isinstance(directions, np.ndarray) and directions.dtype == np.int64):
        return f"directions are {kind_in_words(directions)}, expected int64[beams] in ticks of 0.1°"
    if directions.ndim != 1 or not len(directions):
        return f"directions have shape {directions.shape}, expected one number for each beam"
    if not (isinstance(ranges, np.ndarray) and ranges.dtype == np.float64):
        return f"ranges are {kind_in_words(ranges)}, expected float64[{robots}, {len(directions)}]"
    if ranges.shape != (robots, len(directions)):
        return f"ranges have shape {ranges.shape}, expected ({robots}, {len(directions)})"
    if not (ranges.flags.c_contiguous and directions.flags.c_contiguous):
        return "ranges and directions have to be C-contiguous: use np.ascontiguousarray"
    longest = scan.max_range_m
    if not isinstance(longest, int | float) or not 0.0 < longest <= LONGEST_M:
        return f"max_range_m = {longest!r}, expected more than 0 and at most {LONGEST_M:g}"
    if not isinstance(scan.opening, int) or not 0 <= scan.opening <= TICKS // 2:
        return f"opening = {scan.opening!r}, expected a whole number from 0 to {TICKS // 2}"
    bad = ~((ranges >= 0.0) & (ranges <= longest) | (ranges == np.inf))
    if bad.any():
        robot, beam = np.argwhere(bad)[0].tolist()
        return (
            f"robot {robot}'s beam {beam} measured {ranges[robot, beam]:g}, expected 0 to "
            f"max_range_m = {longest:g}, or inf where nothing was met"
        )
    return None
