"""The plan of a lava tube: a trunk, braids that rejoin it, and blind branches.

Each part draws from its own random stream, so that more branches leave the trunk as it is.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from swarmscout.core.streams import stream
from swarmscout.worlds.noise import as_floats
from swarmscout.worlds.passages import Passage, Rock, smooth_noise, walk
from swarmscout.worlds.tube_parameters import TubeParameters

__all__ = ["plan_tube"]

_TRUNK, _BRAIDS, _BRANCHES = 1, 2, 3
_ROCK_M = 2.5
"""Rock left between two tubes that do not meet, in metres."""
_MOUTH_M = 10.4
"""Width of the mouth, where missions start: room for a hundred robots."""


def plan_tube(parameters: TubeParameters) -> list[Passage]:
    """Plan the passages of a tube.

    Args:
        parameters: the tube's looks.

    Returns:
        The trunk first (its first point is the mouth), then braids, then branches.
    """
    passages = [_trunk(parameters)]
    for number in range(parameters.braids):
        passages += _braid(parameters, passages, number)
    for number in range(parameters.branches):
        passages += _branch(parameters, passages, number)
    return passages


def _trunk(parameters: TubeParameters) -> Passage:
    """The longest of a few walks from the border inwards."""
    size, half = parameters.size_m, parameters.width_m / 2
    rock = Rock(np.empty((0, 2)), np.empty(0), np.empty(0, dtype=np.bool_), size)
    best = np.empty((0, 2))
    for attempt in range(12):
        rng = stream(parameters.seed, "world", _TRUNK, attempt)
        along = float(rng.uniform(0.15, 0.85)) * size
        heading = float(rng.uniform(-0.7, 0.7))
        side = int(rng.integers(4))
        x, y = ((2.0, along), (along, 2.0), (size - 2.0, along), (along, size - 2.0))[side]
        heading += side * math.pi / 2
        # Wider apart than needed: braids and branches want to fit in between.
        points = walk(
            rng, (x, y), heading, parameters.length_m, parameters.winding, rock,
            own_need_m=max(4.0 * half, 0.17 * size), look_m=22.0,
        )  # fmt: skip
        if len(points) > len(best):
            best, widths = points, _widths(rng, parameters, len(points), half)
        if len(best) >= int(parameters.length_m):
            break
    mouth = _bump(np.arange(-4.0, len(best) - 4.0) / 11.0)
    wanted = max(_MOUTH_M / 2, half)
    return Passage("trunk", best, widths + np.maximum(wanted - widths, 0.0) * mouth)


def _braid(parameters: TubeParameters, passages: list[Passage], number: int) -> list[Passage]:
    """An arm beside the trunk, if one of some random ones has rock between the two."""
    rng = stream(parameters.seed, "world", _BRAIDS, number)
    trunk = passages[0]
    count = len(trunk.points_m)
    others, other_widths = _all_points(passages[1:])
    for _ in range(60):
        span = int(rng.integers(28, 52))
        side = float(rng.choice((-1.0, 1.0)))
        half = parameters.width_m / 2 * float(rng.uniform(0.6, 0.9))
        gap = float(rng.uniform(2.5, 6.0))
        wobble_rng = int(rng.integers(2**31))
        if count < span + 20:
            continue
        first = int(rng.integers(12, count - span - 4))
        noise = np.random.Generator(np.random.PCG64(wobble_rng))
        section = trunk.points_m[first : first + span + 1]
        inner = trunk.half_widths_m[first : first + span + 1]
        at = np.linspace(-1.0, 1.0, span + 1)
        away = (half + gap + float(inner[span // 3 : 2 * span // 3 + 1].max())) * (1.0 - at * at)
        away = away + 1.6 * smooth_noise(noise, span + 1, 8.0) * (1.0 - at**4)
        points = np.round(section + side * away[:, None] * _normals(section), 6)
        points = _evenly(points)
        middle = points[len(points) // 3 : 2 * len(points) // 3 + 1]
        if np.minimum(points, parameters.size_m - points).min() < 0.0:
            continue
        if _nearest(middle, trunk.points_m, trunk.half_widths_m) < half + 0.7 * gap:
            continue
        if len(others) and _nearest(points, others, other_widths) < half + _ROCK_M:
            continue
        # Beyond its own section the trunk must be as far away as any other tube.
        beyond = np.r_[0 : max(first - 6, 0), min(first + span + 7, count) : count]
        rest = trunk.points_m[beyond], trunk.half_widths_m[beyond]
        if len(beyond) and _nearest(middle, *rest) < half + _ROCK_M:
            continue
        widths = _widths(noise, parameters, len(points), half)
        return [Passage("braid", points, widths)]
    return []


def _branch(parameters: TubeParameters, passages: list[Passage], number: int) -> list[Passage]:
    """A blind side tube, if one of some random ones finds room for a good part of its length."""
    rng = stream(parameters.seed, "world", _BRANCHES, number)
    for _ in range(16):
        # Mostly from the trunk, sometimes a branch of a branch.
        which = 0 if rng.uniform() < 0.6 else int(rng.integers(len(passages)))
        place, turn = float(rng.uniform(0.1, 0.95)), float(rng.uniform(0.8, 1.4))
        turn *= float(rng.choice((-1.0, 1.0)))
        length = parameters.branch_length_m * float(rng.uniform(0.55, 1.45))
        half = parameters.width_m / 2 * float(rng.uniform(0.55, 0.85))
        shape = np.random.Generator(np.random.PCG64(int(rng.integers(2**31))))
        parent = passages[which]
        index = int(place * (len(parent.points_m) - 1))
        if which == 0 and index < 14:
            continue
        ahead = parent.points_m[min(index + 2, len(parent.points_m) - 1)]
        behind = parent.points_m[max(index - 2, 0)]
        heading = math.atan2(ahead[1] - behind[1], ahead[0] - behind[0]) + turn
        points_m, widths_m = _all_points(passages)
        is_parent = np.concatenate([np.full(len(p.points_m), p is parent) for p in passages])
        rock = Rock(points_m, widths_m + half + _ROCK_M, is_parent, parameters.size_m)
        x, y = parent.points_m[index]
        points = walk(
            shape, (float(x), float(y)), round(heading, 9), length, 1.2 * parameters.winding,
            rock, own_need_m=2.0 * half + _ROCK_M, look_m=12.0,
        )  # fmt: skip
        if len(points) < max(0.45 * parameters.branch_length_m, parent.half_widths_m[index] + 5.0):
            continue
        # Some end in a chamber, the others run out.
        end = _bump(np.arange(4.0 - len(points), 4.0) / 8.0)
        widths = _widths(shape, parameters, len(points), half)
        swell = float(shape.choice((-0.25, 0.6)))
        widest = parameters.widest_m / 2
        return [Passage("branch", points, np.clip(widths * (1.0 + swell * end), 1.2, widest))]
    return []


def _widths(
    rng: np.random.Generator, parameters: TubeParameters, count: int, half: float
) -> NDArray[np.float64]:
    """Half widths along a tube: slow swelling, with narrows and halls, within the limits."""
    vary = 0.75 * smooth_noise(rng, count, 17.0) + 0.35 * smooth_noise(rng, count, 6.0)
    widths: NDArray[np.float64] = half * (1.0 + parameters.width_variation * vary)
    return np.clip(widths, parameters.narrowest_m / 2, parameters.widest_m / 2)


def _bump(at: NDArray[np.float64]) -> NDArray[np.float64]:
    """A smooth hill: 1 at 0, 0 from ±1 on."""
    hill = np.maximum(1.0 - at * at, 0.0)
    return hill * hill


def _normals(points: NDArray[np.float64]) -> NDArray[np.float64]:
    """Unit normals to the left, smoothed over some metres so that offsets do not cross."""
    padded = np.pad(points, ((5, 5), (0, 0)), mode="edge")
    along = padded[10:] - padded[:-10]
    length = np.maximum(np.sqrt(along[:, 0] ** 2 + along[:, 1] ** 2), 1e-9)
    return np.column_stack((-along[:, 1] / length, along[:, 0] / length))


def _evenly(points: NDArray[np.float64]) -> NDArray[np.float64]:
    """The same line with a point per metre or so."""
    steps = np.sqrt(((points[1:] - points[:-1]) ** 2).sum(axis=1))
    along = np.concatenate(([0.0], np.cumsum(steps)))
    at = np.linspace(0.0, along[-1], max(int(along[-1]), 2) + 1)
    x, y = (np.interp(at, along, points[:, axis]) for axis in (0, 1))
    return as_floats(np.round(np.column_stack((x, y)), 6))


def _all_points(passages: list[Passage]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    if not passages:
        return np.empty((0, 2)), np.empty(0)
    return (
        np.concatenate([passage.points_m for passage in passages]),
        np.concatenate([passage.half_widths_m for passage in passages]),
    )


def _nearest(
    points: NDArray[np.float64], others: NDArray[np.float64], widths: NDArray[np.float64]
) -> float:
    """The least distance in metres from points to the walls round other points."""
    across = points[:, None, 0] - others[None, :, 0]
    up = points[:, None, 1] - others[None, :, 1]
    return float((np.sqrt(across * across + up * up) - widths[None, :]).min())
