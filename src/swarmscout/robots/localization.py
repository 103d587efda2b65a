"""Localization: where robots believe that they are (paper, "Robot model": poses are known).

With noise, each step's belief is off by numbers of its own; errors do not add up.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from swarmscout.robots.bodies import TICKS, Bodies, to_ticks
from swarmscout.robots.noise import Noise

__all__ = ["Localization"]


class Localization:
    """Poses as robots believe them.

    Args:
        position_noise_m: standard deviation of x and of y, in metres.
        heading_noise_deg: standard deviation of the heading, in degrees.
    """

    def __init__(self, position_noise_m: float, heading_noise_deg: float) -> None:
        self._noise = Noise("pose")
        self._position_noise_m = position_noise_m
        self._heading_noise_ticks = to_ticks(heading_noise_deg)

    def read(self, bodies: Bodies, step: int, pose: NDArray[np.float64]) -> None:
        """Write the believed poses of a step.

        Args:
            bodies: where robots are.
            step: the current step.
            pose: float64[N, 3 or more], written: x and y in metres, heading in ticks of 0.1°.
        """
        pose[:, :2] = bodies.position
        pose[:, 2] = bodies.heading
        if self._position_noise_m == 0.0 and self._heading_noise_ticks == 0:
            return
        noise = self._noise.at(bodies.seed, (len(pose), 3), step)
        pose[:, :2] += noise[:, :2] * self._position_noise_m
        pose[:, 2] = (pose[:, 2] + np.rint(noise[:, 2] * self._heading_noise_ticks)) % TICKS
