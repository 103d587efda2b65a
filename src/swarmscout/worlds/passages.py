"""Passages: a centre line with a width, and the walk that draws one through free rock."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

__all__ = ["Passage", "Rock", "smooth_noise", "walk"]

_TURNS = (0.0, 0.05, -0.05, 0.11, -0.11, 0.19, -0.19)
"""Turns in radians per metre that a walk may add to its own winding to keep out of others' way."""


@dataclass(frozen=True, eq=False)
class Passage:
    """A tube's centre line, one point per metre or so.

    Attributes:
        kind: ``"trunk"``, ``"braid"`` (both ends join others) or ``"branch"`` (a blind end).
        points_m: float64[n, 2], in metres.
        half_widths_m: float64[n], distance from the centre line to the walls, in metres.
    """

    kind: Literal["trunk", "braid", "branch"]
    points_m: NDArray[np.float64]
    half_widths_m: NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Rock:
    """What a walk keeps away from: passages that are there already, and the border.

    Attributes:
        points_m: float64[n, 2] of other centre lines, in metres.
        needs_m: float64[n], the distance to keep from each, in metres.
        grace: bool[n], points of the parent passage, whose distance is required gradually.
        size_m: the walk stays in the square from 0 to this, in metres.
    """

    points_m: NDArray[np.float64]
    needs_m: NDArray[np.float64]
    grace: NDArray[np.bool_]
    size_m: float

    def lack_m(
        self, at_m: NDArray[np.float64], walked_m: NDArray[np.float64]
    ) -> NDArray[np.float64]:
        """float64[k], by how many metres points [k, 2] are too near, by distance walked [k]."""
        border = 0.0 - np.minimum(at_m, self.size_m - at_m).min(axis=1)
        lack: NDArray[np.float64] = np.maximum(border, 0.0)
        if len(self.points_m):
            across = at_m[:, None, 0] - self.points_m[None, :, 0]
            up = at_m[:, None, 1] - self.points_m[None, :, 1]
            needs = np.where(
                self.grace[None, :],
                np.minimum(self.needs_m[None, :], 0.6 * walked_m[:, None]),
                self.needs_m[None, :],
            )
            lack = np.maximum(lack, (needs - np.sqrt(across * across + up * up)).max(axis=1))
        return lack


def smooth_noise(rng: np.random.Generator, count: int, wavelength: float) -> NDArray[np.float64]:
    """float64[count], smooth noise in (−1, 1) along a line, one value per unit of length."""
    at = np.arange(count) / wavelength + rng.uniform()
    knots = rng.uniform(-1.0, 1.0, size=int(at[-1]) + 2 if count else 2)
    below = at.astype(np.int64)
    part = at - below
    part = part * part * (3.0 - 2.0 * part)
    noise: NDArray[np.float64] = knots[below] * (1.0 - part) + knots[below + 1] * part
    return noise


def walk(
    rng: np.random.Generator,
    start_m: tuple[float, float],
    heading_rad: float,
    length_m: float,
    winding: float,
    rock: Rock,
    own_need_m: float,
    look_m: float = 16.0,
) -> NDArray[np.float64]:
    """Walk through free rock, winding, and turn away from what is near; end where nothing helps.

    Args:
        rng: shapes the winding.
        start_m: first point, in metres.
        heading_rad: first direction, counter-clockwise from +x.
        length_m: at most this long.
        winding: 0 (straight) … 2.
        rock: what to keep away from.
        own_need_m: the distance to keep from one's own earlier course, in metres.
        look_m: how far ahead to look, in metres.

    Returns:
        float64[n, 2], one point per metre.
    """
    count = max(int(length_m), 2)
    turn = winding * (
        0.075 * smooth_noise(rng, count, 22.0)
        + 0.11 * smooth_noise(rng, count, 9.0)
        + 0.06 * smooth_noise(rng, count, 4.0)
    )
    ahead = np.array([1.0, 3.0, 6.0, 10.0, look_m])
    extra = np.array(_TURNS)
    points = np.empty((count, 2))
    x, y, heading = start_m[0], start_m[1], heading_rad
    recent = int(own_need_m * 2.2) + 6
    for number in range(count):
        points[number] = x, y
        # Each candidate is a curve that straightens out: its chord turns half as much.
        bend = turn[number] + extra
        chord = heading + bend[:, None] * np.minimum(ahead, 7.0)[None, :] * 0.5
        at = np.empty((len(extra) * len(ahead), 2))
        at[:, 0] = x + (np.cos(chord) * ahead).ravel()
        at[:, 1] = y + (np.sin(chord) * ahead).ravel()
        walked = np.tile(number + ahead, len(extra))
        lack = rock.lack_m(at, walked)
        if number > recent:
            past = points[: number - recent]
            across = at[:, None, 0] - past[None, :, 0]
            up = at[:, None, 1] - past[None, :, 1]
            lack = np.maximum(lack, own_need_m - np.sqrt((across * across + up * up).min(axis=1)))
        lack = lack.reshape(len(extra), len(ahead))
        cost = (lack * lack / (1.0 + 0.1 * ahead)).sum(axis=1) + 4.0 * np.abs(extra)
        best = int(np.argmin(np.round(cost, 9)))
        if lack[best, 0] > 1.5 or lack[best, 1] > 4.0:
            return points[: number + 1]
        heading = round(heading + float(bend[best]), 9)
        x = round(x + math.cos(heading), 6)
        y = round(y + math.sin(heading), 6)
    return points
