"""Cells and metres: the one module that converts between them.

Frames: metres, x to the right, y up. A grid's row index grows with y and its column index with x,
so row 0 is the lowest row. A cell is ``(row, col)`` in arrays and ``(x_m, y_m)`` (its centre)
at public faces. ``flat = row * columns + col`` names a cell with one integer.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

__all__ = ["GRID", "GridFrame"]

GRID = np.dtype(
    [
        ("origin_x_m", "f8"),
        ("origin_y_m", "f8"),
        ("cell_m", "f8"),
        ("rows", "i8"),
        ("columns", "i8"),
    ],
    align=True,
)
"""A frame as an argument of kernels."""


@dataclass(frozen=True, slots=True)
class GridFrame:
    """Where a grid lies in the world.

    Attributes:
        origin_x_m: x of the lower left corner of cell (0, 0), in metres.
        origin_y_m: y of that corner, in metres.
        cell_m: edge of a (square) cell, in metres.
        rows: number of rows.
        columns: number of columns.
    """

    origin_x_m: float
    origin_y_m: float
    cell_m: float
    rows: int
    columns: int

    @property
    def shape(self) -> tuple[int, int]:
        """``(rows, columns)``."""
        return self.rows, self.columns

    @property
    def size(self) -> int:
        """Number of cells."""
        return self.rows * self.columns

    def write_into(self, record: np.void) -> None:
        """Write the frame into a record that has the fields of ``GRID``, and others."""
        for name in GRID.names or ():
            record[name] = getattr(self, name)

    @property
    def record(self) -> NDArray[np.void]:
        """GRID[1], for kernels."""
        values = self.origin_x_m, self.origin_y_m, self.cell_m, self.rows, self.columns
        return np.array([values], dtype=GRID)

    @property
    def extent(self) -> tuple[float, float, float, float]:
        """``(left, right, bottom, top)`` in metres, as Matplotlib's ``imshow`` takes it."""
        return (
            self.origin_x_m,
            self.origin_x_m + self.columns * self.cell_m,
            self.origin_y_m,
            self.origin_y_m + self.rows * self.cell_m,
        )

    @staticmethod
    def covering(extent: tuple[float, float, float, float], cell_m: float) -> GridFrame:
        """The smallest grid that covers an extent with one cell to spare on each side.

        Args:
            extent: ``(left, right, bottom, top)`` in metres.
            cell_m: edge of a cell, in metres.
        """
        left, right, bottom, top = extent
        # A sliver of a cell (rounding of the extent) does not deserve a row of its own.
        columns = math.ceil((right - left) / cell_m - 1e-6) + 2
        rows = math.ceil((top - bottom) / cell_m - 1e-6) + 2
        return GridFrame(left - cell_m, bottom - cell_m, cell_m, rows, columns)

    def cell_of(self, x_m: float, y_m: float) -> tuple[int, int]:
        """The cell ``(row, col)`` that holds a point; it may lie outside the grid."""
        return (
            math.floor((y_m - self.origin_y_m) / self.cell_m),
            math.floor((x_m - self.origin_x_m) / self.cell_m),
        )

    def cells_of(self, points_m: ArrayLike) -> NDArray[np.int64]:
        """Cells ``(row, col)`` [..., 2] that hold points ``(x, y)`` [..., 2]; not clipped."""
        points = np.asarray(points_m, dtype=np.float64)
        cells = np.empty(points.shape, dtype=np.int64)
        cells[..., 0] = np.floor((points[..., 1] - self.origin_y_m) / self.cell_m)
        cells[..., 1] = np.floor((points[..., 0] - self.origin_x_m) / self.cell_m)
        return cells

    def centre_of(self, row: int, col: int) -> tuple[float, float]:
        """The centre ``(x_m, y_m)`` of a cell."""
        return (
            self.origin_x_m + (col + 0.5) * self.cell_m,
            self.origin_y_m + (row + 0.5) * self.cell_m,
        )

    def centres_of(self, cells: ArrayLike) -> NDArray[np.float64]:
        """Centres ``(x, y)`` [..., 2] in metres of cells ``(row, col)`` [..., 2]."""
        rows_cols = np.asarray(cells)
        points = np.empty(rows_cols.shape, dtype=np.float64)
        points[..., 0] = self.origin_x_m + (rows_cols[..., 1] + 0.5) * self.cell_m
        points[..., 1] = self.origin_y_m + (rows_cols[..., 0] + 0.5) * self.cell_m
        return points

    def flat(self, row: int, col: int) -> int:
        """One integer for a cell: ``row * columns + col``."""
        return row * self.columns + col

    def unflat(self, flat: int) -> tuple[int, int]:
        """The cell ``(row, col)`` behind a flat index."""
        return flat // self.columns, flat % self.columns

    def unflat_many(self, flat: NDArray[np.integer]) -> NDArray[np.int64]:
        """Cells ``(row, col)`` [n, 2] behind flat indices [n]."""
        cells = np.empty((len(flat), 2), dtype=np.int64)
        np.floor_divide(flat, self.columns, out=cells[:, 0])
        np.remainder(flat, self.columns, out=cells[:, 1])
        return cells

    def contains(self, row: int, col: int) -> bool:
        """Whether a cell lies in the grid."""
        return 0 <= row < self.rows and 0 <= col < self.columns
