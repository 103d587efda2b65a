"""Rasters at another resolution, never freer than they were."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from swarmscout.core.errors import WorldError

__all__ = ["FINEST_CELLS", "refined", "resampled"]

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
    """A raster for missions: as asked, or else cut up until a cell is at most 0.1 m.

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
    """Complain about an edge that is no finite length, or too short for a raster cell.

    Raises:
        WorldError: with the name, the value and what would be right.
    """
    if not (isinstance(metres, int | float) and 0.0 < metres <= _LONGEST_M):
        raise WorldError(f"{name} = {metres}: expected metres above 0, for example 0.05")
    if metres < FINEST_M:
        raise WorldError(
            f"{name} = {metres:g}: cells that small are not supported (a robot would be "
            f"{0.3 / metres:,.0f} of them wide): expected at least {FINEST_M:g} m, for example 0.05"
        )


def check_size(shape: tuple[int, ...], why: str) -> None:
    """Complain about a raster that would fill the memory.

    Raises:
        WorldError: with the size and what asked for it.
    """
    if math.prod(shape) > FINEST_CELLS:
        size = " × ".join(f"{length:,}" for length in shape)
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
