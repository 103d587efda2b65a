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

    def read(self, bodies: Bodies, step: int, own: NDArray[np.void]) -> None:
        """Write the believed poses of a step.

        Args:
            bodies: where robots are.
            step: the current step.
            own: MIND[N], written: x_m, y_m and heading.
        """
        own["x_m"], own["y_m"] = bodies.position[:, 0], bodies.position[:, 1]
        own["heading"] = bodies.heading
        if self._position_noise_m == 0.0 and self._heading_noise_ticks == 0:
            return
        noise = self._noise.at(bodies.seed, (len(own), 3), step)
        own["x_m"] += noise[:, 0] * self._position_noise_m
        own["y_m"] += noise[:, 1] * self._position_noise_m
        turned = np.rint(noise[:, 2] * self._heading_noise_ticks).astype(np.int64)
        own["heading"] = (own["heading"] + turned) % TICKS
