"""All robots' bodies as a structure of arrays; row i belongs to robot i."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.typing import NDArray

from swarmscout.core.scan import TICKS

__all__ = ["CAPABILITIES", "TICKS", "TOUCH", "Bodies", "heading_table", "place_bodies", "to_ticks"]

CAPABILITIES = np.dtype(
    [("drive", "?"), ("sense", "?"), ("send", "?"), ("hear", "?"), ("think", "?")]
)
"""What a robot can do, each on its own; one without charge can only hear."""

TOUCH = np.dtype([("dx_m", "f8"), ("dy_m", "f8"), ("kind", "i8"), ("robot", "i8")], align=True)
"""What the last move touched: a code of contact, where from the centre (walls), and a robot."""


def to_ticks(angle_deg: float) -> int:
    """An angle in degrees as a whole number of heading ticks."""
    return round(angle_deg * TICKS / 360)


def heading_table() -> NDArray[np.float64]:
    """``(cos, sin)`` [3600, 2] of every heading.

    Rounded to 15 decimals, so that two machines whose C libraries differ in the last bit still
    compute the same mission.
    """
    return _heading_table().copy()


@cache
def _heading_table() -> NDArray[np.float64]:
    angles = [2.0 * math.pi * tick / TICKS for tick in range(TICKS)]
    return np.array([(round(math.cos(a), 15), round(math.sin(a), 15)) for a in angles])


@dataclass(slots=True)
class Bodies:
    """The truth about N robots.

    Attributes:
        position: float64[N, 2], x and y of the centres in metres.
        heading: int64[N], counter-clockwise from +x in ticks of 0.1°, in [0, 3600).
        charge: float64[N], charge left, in steps.
        alive: bool[N], False once the charge is gone: such a robot does nothing any more.
        can: CAPABILITIES[N], what works of each robot.
        touch: TOUCH[N], what the last move touched.
        seed: the mission's: noise comes from ``stream(bodies.seed, purpose, step)``.
        radius_m: of every robot, in metres.
    """

    position: NDArray[np.float64]
    heading: NDArray[np.int64]
    charge: NDArray[np.float64]
    alive: NDArray[np.bool_]
    can: NDArray[np.void]
    touch: NDArray[np.void]
    seed: int = 0
    radius_m: float = 0.15

    @property
    def contact(self) -> NDArray[np.int64]:
        """int64[N], what the last move touched: 0 nothing, 1 a wall, 2 a robot."""
        return self.touch["kind"]

    @property
    def pose(self) -> NDArray[np.float64]:
        """float64[N, 3]: x_m, y_m, heading_rad."""
        pose = np.empty((len(self.heading), 3))
        pose[:, :2] = self.position
        np.multiply(self.heading, 2.0 * math.pi / TICKS, out=pose[:, 2])
        return pose


def place_bodies(
    position: NDArray[np.float64],
    heading: NDArray[np.int64],
    charge: NDArray[np.float64],
    *,
    seed: int = 0,
    radius_m: float = 0.15,
) -> Bodies:
    """Robots at given places, all of them alive and sound.

    Args:
        position: float64[N, 2] centres in metres.
        heading: int64[N] headings in ticks.
        charge: float64[N] charge in steps.
        seed, radius_m: see :class:`Bodies`.
    """
    robots = len(position)
    return Bodies(
        position=np.ascontiguousarray(position, dtype=np.float64),
        heading=np.ascontiguousarray(heading, dtype=np.int64) % TICKS,
        charge=np.ascontiguousarray(charge, dtype=np.float64),
        alive=np.ones(robots, dtype=np.bool_),
        can=np.ones(robots, dtype=CAPABILITIES),
        touch=np.array([(0.0, 0.0, 0, -1)] * robots, dtype=TOUCH),
        seed=seed,
        radius_m=radius_m,
    )
