"""What stands and lies in a tube: pillars of rock, and blocks fallen from the ceiling."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from swarmscout.core.streams import stream
from swarmscout.worlds.noise import Lattice
from swarmscout.worlds.passages import Passage
from swarmscout.worlds.tube_parameters import TubeParameters

__all__ = ["fallen_blocks", "pillars"]

_PILLARS, _PILES = 5, 6
_PASSAGE_M = 1.15
"""Width that pillars and piles leave open beside a centre line."""
_START_CLEAR_M = 9.0
_FAR_M = 100.0
_CHOICES = 40


def pillars(
    lattice: Lattice, passages: list[Passage], parameters: TubeParameters
) -> NDArray[np.float64]:
    """Distance from the walls of pillars, negative inside.

    A pillar stands in a wide place, off the centre line, so that one can pass it on both sides.

    Args:
        lattice: where to give it.
        passages: the tubes.
        parameters: says how many pillars.

    Returns:
        float64, one per lattice point, in metres.
    """
    rng = stream(parameters.seed, "world", _PILLARS)
    outline = np.full(lattice.shape, _FAR_M)
    x, y = lattice.coordinates()
    standing: list[tuple[float, float]] = []
    for _ in range(parameters.pillars):
        for draw in rng.uniform(size=(_CHOICES, 5)):
            point, side, half, _ = _beside(passages, draw)
            radius = 0.5 + 0.9 * float(draw[2])
            inner, outer = radius + _PASSAGE_M + 0.3, half - radius - _PASSAGE_M
            if outer < inner:
                continue
            cx, cy = np.round(point + side * (inner + float(draw[3]) * (outer - inner)), 6).tolist()
            if not _is_clear(passages, (cx, cy), radius + _PASSAGE_M) or any(
                (cx - a) ** 2 + (cy - b) ** 2 < 16.0 for a, b in standing
            ):
                continue
            standing.append((cx, cy))
            # Two overlapping discs look less like a pole.
            ox, oy = 0.5 * radius * (2.0 * rng.uniform(size=2) - 1.0)
            for px, py, r in ((cx, cy, radius), (cx + ox, cy + oy, 0.8 * radius)):
                distance = np.sqrt((x - px) ** 2 + (y - py) ** 2) - r
                np.minimum(outline, distance, out=outline)
            break
    return outline


def fallen_blocks(
    lattice: Lattice, passages: list[Passage], parameters: TubeParameters
) -> NDArray[np.float64]:
    """Height of breakdown piles above the ground.

    Piles lie against the walls, and at blind ends.

    Args:
        lattice: where to give it.
        passages: the tubes.
        parameters: says how many piles.

    Returns:
        float64, one per lattice point, in metres.
    """
    rng = stream(parameters.seed, "world", _PILES)
    height = np.zeros(lattice.shape)
    x, y = lattice.coordinates()
    for _ in range(parameters.piles):
        for draw in rng.uniform(size=(_CHOICES, 5)):
            point, side, half, is_end = _beside(passages, draw)
            if is_end:
                radius = 0.8 * half
                centre = point
            else:
                centre = point + side * half * (0.75 + 0.35 * float(draw[3]))
                radius = min(half - _PASSAGE_M, 1.0 + 1.8 * float(draw[2]))
            cx, cy = np.round(centre, 6).tolist()
            away = 0.0 if is_end else radius + _PASSAGE_M - 0.3
            if radius < 0.7 or not _is_clear(passages, (cx, cy), away):
                continue
            rise = 0.5 + 0.9 * float(draw[4])
            near = np.maximum(1.0 - ((x - cx) ** 2 + (y - cy) ** 2) / (1.25 * radius) ** 2, 0.0)
            np.maximum(height, rise * near, out=height)
            break
    return height


def _beside(
    passages: list[Passage], draw: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64], float, bool]:
    """A point of a centre line, the way to one wall, the half width, and if the tube ends."""
    lengths = np.cumsum([len(passage.points_m) for passage in passages])
    flat = int(draw[0] * lengths[-1])
    which = int(np.searchsorted(lengths, flat, side="right"))
    passage = passages[which]
    count = len(passage.points_m)
    index = flat - int(lengths[which]) + count
    before, after = max(index - 2, 0), min(index + 2, count - 1)
    along = passage.points_m[after] - passage.points_m[before]
    along = along / max(float(np.sqrt((along * along).sum())), 1e-9)
    hand = 1.0 if draw[1] < 0.5 else -1.0
    side = hand * np.array([-along[1], along[0]])
    is_end = passage.kind == "branch" and index >= count - 2
    return passage.points_m[index], side, float(passage.half_widths_m[index]), is_end


def _is_clear(passages: list[Passage], at: tuple[float, float], distance_m: float) -> bool:
    """Whether a point keeps its distance from every centre line and from the mouth."""
    mouth = passages[0].points_m[4]
    if (at[0] - mouth[0]) ** 2 + (at[1] - mouth[1]) ** 2 < _START_CLEAR_M**2:
        return False
    for passage in passages:
        away = passage.points_m - np.array(at)
        if float((away * away).sum(axis=1).min()) < distance_m**2:
            return False
    return True
