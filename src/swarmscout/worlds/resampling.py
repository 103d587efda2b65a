"""Rasters at another resolution, never freer than they were."""

from __future__ import annotations

import math
import reprlib

import numpy as np
from numpy.typing import NDArray

from swarmscout.core.errors import WorldError

__all__ = ["FINEST_CELLS", "refined", "resampled", "turned"]

FINEST_CELLS = 64_000_000
"""A raster with more cells than this is taken for a mistake: 800 m × 800 m at 0.1 m."""
_COARSEST_M = 0.1
_LONGEST_M = 1e6
FINEST_M = 0.005
"""Finer cells are taken for a mistake in the unit: a robot would cover thousands of them."""


def resampled(free: NDArray[np.uint8], cell_m: float, resolution_m: float) -> NDArray[np.uint8]:
    """The same place with cells of another size: one is free if all that it overlaps is.

    Args:
        free: uint8[rows, cols], 1 is free.
        cell_m: its cell's edge, in metres.
        resolution_m: the wanted cell's edge, in metres.

    Returns:
        uint8[rows', cols'] with the same lower left corner; a rest at the far ends is left out.

    Raises:
        WorldError: the result would be too large or empty.
    """
    if resolution_m == cell_m:
        return free
    ratio = resolution_m / cell_m
    shape = tuple(math.floor(length / ratio + 1e-6) for length in free.shape)
    check_size(shape, f"resolution_m = {resolution_m:g}")
    if not min(shape):
        raise WorldError(
            f"resolution_m = {resolution_m:g} is coarser than the whole raster of "
            f"{free.shape[0]} × {free.shape[1]} cells of {cell_m:g} m: take a smaller one"
        )
    rows = _all_free(free, ratio, shape[0])
    return np.ascontiguousarray(_all_free(rows.T, ratio, shape[1]).T)


def refined(
    free: NDArray[np.uint8], cell_m: float, resolution_m: float | None
) -> tuple[NDArray[np.uint8], float]:
    """A raster for missions: at the wanted resolution, or cut up until a cell is at most 0.1 m.

    Args:
        free: uint8[rows, cols], 1 is free.
        cell_m: its cell's edge, in metres.
        resolution_m: the wanted edge, in metres, or None.

    Returns:
        The raster and its cell's edge, in metres.

    Raises:
        WorldError: the raster would be too large or empty.
    """
    if resolution_m is not None:
        check_length("resolution_m", resolution_m)
        return resampled(free, cell_m, resolution_m), resolution_m
    pieces = math.ceil(cell_m / _COARSEST_M - 1e-6)
    if pieces <= 1:
        return free, cell_m
    check_size((free.shape[0] * pieces, free.shape[1] * pieces), f"cells of {cell_m:g} m")
    return free.repeat(pieces, axis=0).repeat(pieces, axis=1), cell_m / pieces


def check_length(name: str, metres: float) -> None:
    """Refuse an edge that is not a finite length, or too short for a raster cell.

    Raises:
        WorldError: with the name, the value and what would be right.
    """
    if not (isinstance(metres, int | float) and 0.0 < metres <= _LONGEST_M):
        value = reprlib.repr(metres)
        raise WorldError(f"{name} = {value}: expected metres above 0, for example 0.05")
    if metres < FINEST_M:
        raise WorldError(
            f"{name} = {metres:g}: cells that small are not supported (a robot would be "
            f"{0.3 / metres:,.0f} of them wide): expected at least {FINEST_M:g} m, for example 0.05"
        )


def check_size(shape: tuple[int, ...], why: str) -> None:
    """Refuse a raster that would fill the memory.

    Raises:
        WorldError: with the size and its cause.
    """
    if math.prod(shape) > FINEST_CELLS:
        # Of an absurd number all digits would fill the screen.
        size = " × ".join(f"{length:,}" if length < 10**12 else "10¹² or more" for length in shape)
        raise WorldError(
            f"{why}: a raster of {size} cells is too large (limit {FINEST_CELLS:,} cells); "
            "take coarser or fewer cells"
        )


def _all_free(free: NDArray[np.uint8], ratio: float, count: int) -> NDArray[np.uint8]:
    """Join (or cut) rows: row i is free where rows ``i * ratio … (i + 1) * ratio`` all are."""
    edges = np.arange(count + 1) * ratio
    first = np.floor(edges[:-1] + 1e-6).astype(np.int64)
    last = np.minimum(np.ceil(edges[1:] - 1e-6).astype(np.int64), free.shape[0])
    walls = np.zeros((free.shape[0] + 1, free.shape[1]), dtype=np.int32)
    np.cumsum(free == 0, axis=0, out=walls[1:])
    unbroken: NDArray[np.uint8] = (walls[last] == walls[first]).astype(np.uint8)
    return unbroken


def turned(
    free: NDArray[np.uint8], cell_m: float, origin_m: tuple[float, float], yaw_rad: float
) -> tuple[NDArray[np.uint8], tuple[float, float], bool]:
    """A raster that lies turned about its lower left corner, as one along the axes.

    Args:
        free: uint8[rows, cols], 1 is free.
        cell_m: edge of a cell, in metres.
        origin_m: ``(x, y)`` of its lower left corner, in metres.
        yaw_rad: counter-clockwise turn of the raster about that corner, in radians.

    Returns:
        The raster, the lower left corner of it, and whether it is exact. It is exact where the turn
        is a multiple of 90° but for less than half a cell at the far end; otherwise a new cell is
        free where all that it overlaps is.

    Raises:
        WorldError: the raster would be too large.
    """
    quarters = round(yaw_rad / (math.pi / 2.0))
    rest = yaw_rad - quarters * (math.pi / 2.0)
    rows, columns = free.shape
    if abs(rest) * math.hypot(rows, columns) < 0.5:
        moves = ((0.0, 0.0), (-rows, 0.0), (-columns, -rows), (0.0, -columns))
        across, up = moves[quarters % 4]
        corner = origin_m[0] + across * cell_m, origin_m[1] + up * cell_m
        # Rows count upward: what turns counter-clockwise on the map turns clockwise in the array.
        return np.ascontiguousarray(np.rot90(free, -(quarters % 4))), corner, True
    cos, sin = math.cos(yaw_rad), math.sin(yaw_rad)
    x = np.array([0.0, columns * cos, -rows * sin, columns * cos - rows * sin])
    y = np.array([0.0, columns * sin, rows * cos, columns * sin + rows * cos])
    left, bottom = math.floor(x.min()), math.floor(y.min())
    shape = math.ceil(y.max()) - bottom, math.ceil(x.max()) - left
    check_size(shape, "the turned map")
    known = np.ones(shape, dtype=np.bool_)
    for down in (0.01, 0.5, 0.99):
        for aside in (0.01, 0.5, 0.99):
            px = left + np.arange(shape[1])[None, :] + aside
            py = bottom + np.arange(shape[0])[:, None] + down
            col = np.floor(px * cos + py * sin).astype(np.int64)
            row = np.floor(py * cos - px * sin).astype(np.int64)
            inside = (row >= 0) & (row < rows) & (col >= 0) & (col < columns)
            known &= inside & (free[row.clip(0, rows - 1), col.clip(0, columns - 1)] != 0)
    corner = origin_m[0] + left * cell_m, origin_m[1] + bottom * cell_m
    return known.astype(np.uint8), corner, False
