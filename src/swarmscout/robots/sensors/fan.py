"""The paper's sensor: a fan of short rays ahead (paper, "Robot model", Fig. 1a)."""

from __future__ import annotations

import numpy as np

from swarmscout.robots.bodies import TICKS, to_ticks
from swarmscout.robots.sensors.parameters import FanParameters
from swarmscout.robots.sensors.ray_sensor import RaySensor

__all__ = ["Fan"]


class Fan(FanParameters, RaySensor):
    """Rays evenly spread from right to left, by default nine over ±70° (the paper's)."""

    def angles_deg(self) -> list[float]:
        """Where the rays point; a fan of ±180° is a full circle, and no ray stands twice in it."""
        if self.rays == 1:
            return [0.0]
        closed = 2 * to_ticks(self.fan_deg) == TICKS
        angles: list[float] = np.linspace(
            -self.fan_deg, self.fan_deg, self.rays, endpoint=not closed
        ).tolist()
        return angles
