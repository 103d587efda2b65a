"""What the package's sensors share: rays against raster or mesh, and noise."""

from __future__ import annotations

from collections.abc import Iterable
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from swarmscout.core.scan import Scan
from swarmscout.robots.bodies import Bodies, to_ticks
from swarmscout.robots.noise import Noise
from swarmscout.robots.sensors.mesh_rays import mesh_ranges
from swarmscout.robots.sensors.parameters import RayParameters
from swarmscout.robots.sensors.raster_rays import add_noise, raster_ranges
from swarmscout.worlds.world import World

__all__ = ["RaySensor", "directions_of"]


def directions_of(angles_deg: Iterable[float]) -> NDArray[np.int64]:
    """Directions of beams as a scan has them: int64[beams] in ticks of 0.1°.

    Args:
        angles_deg: counter-clockwise from the robot's heading, in degrees.
    """
    return np.array([to_ticks(angle) for angle in angles_deg], dtype=np.int64)


class RaySensor(RayParameters):
    """A sensor whose beams are rays: a subclass says where they point."""

    def angles_deg(self) -> list[float]:
        """Where the rays point, in degrees from the heading."""
        raise NotImplementedError

    def scan(self, bodies: Bodies, world: World, step: int) -> Scan:
        """See :class:`swarmscout.robots.sensors.sensor.Sensor`."""
        ranges = self._cast(bodies, world, self._directions)
        return Scan(self._measured(ranges, bodies, step), self._directions, self.range_m)

    @cached_property
    def _directions(self) -> NDArray[np.int64]:
        return directions_of(self.angles_deg())

    @cached_property
    def _noise(self) -> Noise:
        return Noise("sensor")

    def _cast(
        self, bodies: Bodies, world: World, directions: NDArray[np.int64]
    ) -> NDArray[np.float64]:
        if self.sensing == "mesh":
            return mesh_ranges(bodies, world, directions, self.range_m, self.height_m)
        return raster_ranges(bodies, world, directions, self.range_m)

    def _measured(
        self, ranges: NDArray[np.float64], bodies: Bodies, step: int
    ) -> NDArray[np.float64]:
        """The ranges with a step's noise (changed in place)."""
        if self.noise_m > 0.0:
            noise = self._noise.at(bodies.seed, ranges.shape, step)
            add_noise(ranges, noise, self.noise_m, self.range_m)
        return ranges
