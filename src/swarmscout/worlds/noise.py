"""Smooth fields on rasters: coarse lattices, interpolated with cubics.

Only sums, products and square roots are used, and results are rounded, so that a threshold falls
the same way on every machine.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

__all__ = ["Lattice", "as_floats", "noise_field"]

Field = NDArray[np.float64]


def as_floats(values: NDArray[np.floating[Any]]) -> Field:
    """The same array: rounding to decimals keeps the type, which NumPy's stubs do not know."""
    return values.astype(np.float64, copy=False)


class Lattice:
    """A coarse lattice of points that covers a raster; row 0 is the lowest.

    Args:
        width_m: the raster's width, in metres.
        height_m: the raster's height, in metres.
        step_m: distance of lattice points, in metres.
    """

    def __init__(self, width_m: float, height_m: float, step_m: float) -> None:
        self.step_m = step_m
        # One point before the raster and two behind it: a cubic looks that far.
        self.shape = (int(height_m / step_m) + 4, int(width_m / step_m) + 4)

    def coordinates(self) -> tuple[Field, Field]:
        """X of columns [1, cols] and y of rows [rows, 1], in metres."""
        rows, columns = self.shape
        x: Field = np.arange(-1.0, columns - 1.0) * self.step_m
        y: Field = np.arange(-1.0, rows - 1.0) * self.step_m
        return x[None, :], y[:, None]

    def window(self, x_m: float, y_m: float, reach_m: float) -> tuple[slice, slice]:
        """The lattice points within a square round a point."""
        row, col = y_m / self.step_m + 1.0, x_m / self.step_m + 1.0
        reach = reach_m / self.step_m
        return (
            slice(max(int(row - reach), 0), max(int(row + reach) + 2, 0)),
            slice(max(int(col - reach), 0), max(int(col + reach) + 2, 0)),
        )

    def at_cells(
        self, values: Field, shape: tuple[int, int], resolution_m: float, *, smooth: bool = False
    ) -> Field:
        """Interpolate lattice values at the centres of a raster's cells.

        Args:
            values: float64, one per lattice point.
            shape: the raster's rows and columns.
            resolution_m: edge of a raster cell, in metres.
            smooth: a cubic B-spline, which rounds off, instead of a curve through the values.

        Returns:
            float64[rows, cols].
        """
        rows = _along_rows(values, shape[0], resolution_m / self.step_m, smooth)
        return np.ascontiguousarray(
            _along_rows(
                np.ascontiguousarray(rows.T), shape[1], resolution_m / self.step_m, smooth
            ).T
        )


def noise_field(
    rng: np.random.Generator,
    width_m: float,
    height_m: float,
    wavelength_m: float,
    shape: tuple[int, int],
    resolution_m: float,
) -> Field:
    """Smooth noise of about unit size at the centres of a raster's cells.

    Args:
        rng: gives the noise.
        width_m: the raster's width, in metres.
        height_m: the raster's height, in metres.
        wavelength_m: size of its hills, in metres.
        shape: the raster's rows and columns.
        resolution_m: edge of a raster cell, in metres.

    Returns:
        float64[rows, cols], mostly in (−1, 1).
    """
    lattice = Lattice(width_m, height_m, wavelength_m / 2.0)
    values = rng.uniform(-1.0, 1.0, size=lattice.shape)
    # A B-spline halves the noise; this brings it back to unit size.
    return 1.7 * lattice.at_cells(values, shape, resolution_m, smooth=True)


def _along_rows(values: Field, count: int, ratio: float, smooth: bool) -> Field:
    """Interpolate between rows: row r of the result lies at (r + 0.5) * ratio + 1."""
    at = (np.arange(count) + 0.5) * ratio + 1.0
    below = np.minimum(at.astype(np.int64), values.shape[0] - 3)
    t = (at - below)[:, None]
    if smooth:
        weights = (
            (1.0 - t) ** 3 / 6.0,
            (3.0 * t * t * t - 6.0 * t * t + 4.0) / 6.0,
            (-3.0 * t * t * t + 3.0 * t * t + 3.0 * t + 1.0) / 6.0,
            t * t * t / 6.0,
        )
    else:  # Catmull and Rom's spline.
        weights = (
            ((2.0 - t) * t - 1.0) * t / 2.0,
            ((3.0 * t - 5.0) * t * t + 2.0) / 2.0,
            ((4.0 - 3.0 * t) * t + 1.0) * t / 2.0,
            (t - 1.0) * t * t / 2.0,
        )
    result: Field = weights[0] * values[below - 1]
    for offset, weight in enumerate(weights[1:]):
        result += weight * values[below + offset]
    return result
