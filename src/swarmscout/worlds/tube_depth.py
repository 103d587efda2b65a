"""How deep the points of a coarse lattice lie inside the tubes of a plan."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from swarmscout.core.jit import kernel
from swarmscout.worlds.noise import Lattice
from swarmscout.worlds.passages import Passage

__all__ = ["depth_and_core"]

OUTSIDE_M = -3.0
ROUND_M = 1.6
"""Radius of the rounded corner where tubes meet."""
_CORE_M = 1.0


def depth_and_core(
    lattice: Lattice, passages: list[Passage]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """How deep lattice points lie inside tubes, and inside the core of tubes.

    Args:
        lattice: where to give it.
        passages: the tubes.

    Returns:
        float64 each, one per lattice point, in metres.
    """
    depth = np.full(lattice.shape, OUTSIDE_M)
    core = np.full(lattice.shape, OUTSIDE_M)
    own = np.full(lattice.shape, OUTSIDE_M)
    x, y = lattice.coordinates()
    for passage in passages:
        touched = []
        for (px, py), half in zip(*_denser(passage), strict=True):
            window = lattice.window(px, py, half - OUTSIDE_M)
            touched.append(window)
            across, up = x[:, window[1]] - px, y[window[0]] - py
            distance = np.sqrt(across * across + up * up)
            np.maximum(own[window], half - distance, out=own[window])
            np.maximum(core[window], _CORE_M - distance, out=core[window])
        join_passage(depth, own)
        for window in touched:
            own[window] = OUTSIDE_M
    return depth, core


@kernel
def join_passage(depth, own):  # type: ignore[no-untyped-def]
    """The larger of two depths, with a rounded corner where tubes meet.

    Args:
        depth: float64[rows, cols], written: of the tubes so far.
        own: float64[rows, cols], of one more.
    """
    for row in range(depth.shape[0]):
        for col in range(depth.shape[1]):
            one = depth[row, col]
            other = own[row, col]
            blend = ROUND_M - abs(one - other)
            # Nearly all points of a large plan lie far inside rock, or far inside one tube.
            if blend > 0.0:
                depth[row, col] = max(one, other) + blend * blend / (4.0 * ROUND_M)
            elif other > one:
                depth[row, col] = other


def _denser(passage: Passage) -> tuple[list[list[float]], list[float]]:
    """Points every half metre or so, and their half widths."""
    points, widths = passage.points_m, passage.half_widths_m
    halfway = (points[1:] + points[:-1]) / 2
    return (
        np.concatenate((points, halfway)).tolist(),
        np.concatenate((widths, (widths[1:] + widths[:-1]) / 2)).tolist(),
    )
