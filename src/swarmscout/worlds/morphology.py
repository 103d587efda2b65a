"""Discs on rasters: where a round body fits, what it covers, and connected regions.

A disc is a union of horizontal runs, one half width for each row offset. That takes a few passes
over the raster, where an exact distance transform of a large one takes seconds.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

__all__ = ["covered_by", "fits", "parts"]

_SLACK_M = 1e-9
"""A body that exactly touches a wall fits; rounding must not decide."""


def fits(free: NDArray[np.uint8], resolution_m: float, radius_m: float) -> NDArray[np.bool_]:
    """Cells at whose centre a disc meets no wall.

    Args:
        free: uint8[rows, cols], 1 is free; outside is wall.
        resolution_m: edge of a cell, in metres.
        radius_m: the disc's radius, in metres.

    Returns:
        bool[rows, cols]: the centre is at least ``radius_m`` from every wall cell's square.
    """
    half_widths = [0]  # A centre in a wall never fits, however small the disc.
    for down in range(math.ceil(radius_m / resolution_m) + 1):
        below = max(down - 0.5, 0.0) * resolution_m
        if below >= radius_m - _SLACK_M:
            break
        side = math.sqrt(max((radius_m - _SLACK_M) ** 2 - below**2, 0.0))
        # The largest column offset whose square (half a cell nearer than its centre) is hit.
        half_widths[down:] = [max(math.ceil(side / resolution_m + 0.5) - 1, 0)]
    return ~_union_of_runs(free == 0, half_widths, outside=True)


def covered_by(
    centres: NDArray[np.bool_], resolution_m: float, radius_m: float
) -> NDArray[np.bool_]:
    """Cells whose centre a disc covers when it stands at one of the marked cells.

    Args:
        centres: bool[rows, cols], where the disc stands.
        resolution_m: edge of a cell, in metres.
        radius_m: the disc's radius, in metres.

    Returns:
        bool[rows, cols]: the centre is at most ``radius_m`` from a marked cell's centre.
    """
    reach = (radius_m + _SLACK_M) / resolution_m
    half_widths = [
        math.floor(math.sqrt(reach**2 - down**2)) for down in range(math.floor(reach) + 1)
    ]
    return _union_of_runs(centres, half_widths, outside=False)


def parts(open_cells: NDArray[np.bool_]) -> NDArray[np.int32]:
    """Number the parts that are connected through edges: int32[rows, cols], 0 where closed."""
    labels: NDArray[np.int32] = np.empty(open_cells.shape, dtype=np.int32)
    ndimage.label(open_cells, output=labels)
    return labels


def _union_of_runs(
    marked: NDArray[np.bool_], half_widths: list[int], *, outside: bool
) -> NDArray[np.bool_]:
    """Grow marked cells by a shape with one half width per row offset, from 0."""
    rows, columns = marked.shape
    high, wide = len(half_widths) - 1, max(half_widths, default=0)
    padded = np.full((rows + 2 * high, columns + 2 * wide), outside)
    padded[high : high + rows, wide : wide + columns] = marked
    grown = np.zeros((rows, columns), dtype=np.bool_)
    run, width = padded, 0
    # The shape narrows with the row offset, so the run can grow from its tip to its middle.
    for down in range(high, -1, -1):
        while width < half_widths[down]:
            step = min(half_widths[down] - width, max(width, 1))
            wider = run.copy()
            wider[:, step:] |= run[:, :-step]
            wider[:, :-step] |= run[:, step:]
            run, width = wider, width + step
        across = slice(wide, wide + columns)
        grown |= run[high + down : high + down + rows, across]
        if down:
            grown |= run[high - down : high - down + rows, across]
    return grown
