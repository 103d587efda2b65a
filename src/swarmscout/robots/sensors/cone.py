"""A sonar: one cone ahead, in which it measures the nearest obstacle."""

from __future__ import annotations

import math

import numpy as np

from swarmscout.core.scan import Scan, rays_in
from swarmscout.robots.bodies import Bodies, to_ticks
from swarmscout.robots.sensors.parameters import ConeParameters
from swarmscout.robots.sensors.ray_sensor import RaySensor
from swarmscout.worlds.world import World

__all__ = ["Cone"]

_AHEAD = np.zeros(1, dtype=np.int64)


class Cone(ConeParameters, RaySensor):
    """The nearest obstacle in a cone ahead, as a sonar measures it; by default 30° wide.

    Where on its arc the obstacle lies is unknown: the whole arc counts as occupied, and the cone in
    front of it as free.

    Source: Thrun, Burgard, Fox (2005), *Probabilistic Robotics*, table 9.2.
    """

    def angles_deg(self) -> list[float]:
        """The cone's outline, a ray for each 2° or so, for pictures."""
        rays = math.ceil(self.opening_deg / 2.0) + 1
        angles: list[float] = np.linspace(
            -0.5 * self.opening_deg, 0.5 * self.opening_deg, rays
        ).tolist()
        return angles

    def scan(self, bodies: Bodies, world: World, step: int) -> Scan:
        """See :class:`swarmscout.robots.sensors.sensor.Sensor`."""
        opening = to_ticks(self.opening_deg)
        # Rays so close that at the longest range at least one meets each wall cell in the cone.
        rays, _ = rays_in(opening, self.range_m, world.resolution_m)
        bundle = np.rint(np.linspace(-opening / 2, opening / 2, rays)).astype(np.int64)
        nearest = self._cast(bodies, world, bundle).min(axis=1, keepdims=True)
        return Scan(self._measured(nearest, bodies, step), _AHEAD, self.range_m, opening)
