"""A lidar that turns: rays all around."""

from __future__ import annotations

from swarmscout.robots.sensors.parameters import LidarParameters
from swarmscout.robots.sensors.ray_sensor import RaySensor

__all__ = ["Lidar"]


class Lidar(LidarParameters, RaySensor):
    """Rays evenly spread over the full circle, the first straight ahead; by default 360."""

    def angles_deg(self) -> list[float]:
        """Where the rays point, counter-clockwise from the heading."""
        return [360.0 * ray / self.rays for ray in range(self.rays)]
