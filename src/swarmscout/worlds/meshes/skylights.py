"""Skylights: places where a tube's roof has fallen in, up to the open sky."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from swarmscout.core.streams import stream
from swarmscout.worlds.tube import TubeFields, roof_height_m
from swarmscout.worlds.tube_parameters import TubeParameters

__all__ = ["Skylight", "place_skylights", "shaft"]

_SKYLIGHTS = 10
_APART_M = 8.0
_LEAST_RADIUS_M, _MOST_RADIUS_M = 0.8, 2.4
_ROCK_M = 2.0
"""Rock above the highest roof, in metres."""
_FUNNEL = 0.12
_CHOICES = 40


@dataclass(frozen=True)
class Skylight:
    """A shaft from the roof to the sky, a few metres wide.

    Attributes:
        x_m: its middle, in metres.
        y_m: its middle, in metres.
        radius_m: mean radius where it leaves the roof, in metres.
        from_m: height above the ground where it may begin, inside the tube, in metres.
        top_m: height above the ground where it is open, in metres.
        lobes: phases of its uneven outline, in radians.
    """

    x_m: float
    y_m: float
    radius_m: float
    from_m: float
    top_m: float
    lobes: tuple[float, float]

    @property
    def reach_m(self) -> float:
        """No part of it lies farther from its middle, in metres."""
        return 1.4 * self.radius_m + _FUNNEL * self.top_m


def place_skylights(fields: TubeFields, parameters: TubeParameters, count: int) -> list[Skylight]:
    """Choose where the roof has fallen in: over passages, some metres apart.

    Args:
        fields: what the tube's rasters are made of.
        parameters: the tube's looks; its seed says where.
        count: how many there should be; fewer where there is no room.
    """
    rng = stream(parameters.seed, "world", _SKYLIGHTS)
    lines = np.concatenate([passage.points_m for passage in fields.passages])
    highest = parameters.height_m * 1.2
    placed: list[Skylight] = []
    for _ in range(count):
        for draw in rng.uniform(size=(_CHOICES, 5)):
            x, y = lines[int(draw[0] * len(lines))]
            row, col = (int(part / parameters.resolution_m) for part in (y, x))
            depth = fields.depth_m[row : row + 1, col : col + 1]
            radius = min(
                _LEAST_RADIUS_M + float(draw[1]) * (_MOST_RADIUS_M - _LEAST_RADIUS_M),
                0.7 * float(depth[0, 0]),
            )
            near = any((x - s.x_m) ** 2 + (y - s.y_m) ** 2 < _APART_M**2 for s in placed)
            if radius < _LEAST_RADIUS_M or near:
                continue
            roof = roof_height_m(depth, fields.hills[row : row + 1, col : col + 1], parameters)
            placed.append(
                Skylight(
                    x_m=float(x),
                    y_m=float(y),
                    radius_m=radius,
                    from_m=0.7 * float(roof[0, 0]),
                    top_m=highest + _ROCK_M,
                    lobes=(6.28 * float(draw[2]), 6.28 * float(draw[3])),
                )
            )
            break
    return placed


def shaft(
    skylight: Skylight,
    x_m: NDArray[np.float64],
    y_m: NDArray[np.float64],
    level_m: NDArray[np.float32],
) -> NDArray[np.float64]:
    """How deep points lie inside a skylight's shaft, in metres; negative in the rock round it.

    Args:
        skylight: the skylight.
        x_m: float64[cols].
        y_m: float64[rows].
        level_m: float32[levels], heights above the ground.

    Returns:
        float64[rows, cols, levels].
    """
    across, up = x_m[None, :] - skylight.x_m, y_m[:, None] - skylight.y_m
    angle = np.arctan2(up, across)
    lobes = 0.14 * np.sin(2.0 * angle + skylight.lobes[0])
    lobes += 0.1 * np.sin(3.0 * angle + skylight.lobes[1])
    inside = skylight.radius_m * (1.0 + lobes) - np.sqrt(across**2 + up**2)
    widening = _FUNNEL * np.maximum(level_m - skylight.from_m, 0.0)
    depth: NDArray[np.float64] = np.minimum(
        inside[:, :, None] + widening, level_m - skylight.from_m
    )
    return depth
