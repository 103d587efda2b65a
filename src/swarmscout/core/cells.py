"""Where flat cells of a grid lie, inside kernels."""

from __future__ import annotations

import math

from swarmscout.core.jit import inlined

__all__ = ["cell_at", "cell_of", "centre", "offset"]


@inlined
def centre(cell, grid):  # type: ignore[no-untyped-def]
    """X and y of a flat cell's centre, as ``GridFrame`` computes them.

    Args:
        cell: the cell.
        grid: any record with the fields of ``GRID``.
    """
    row = cell // grid.columns
    col = cell - row * grid.columns
    return (
        grid.origin_x_m + (col + 0.5) * grid.cell_m,
        grid.origin_y_m + (row + 0.5) * grid.cell_m,
    )


@inlined
def offset(cell, x, y, grid):  # type: ignore[no-untyped-def]
    """From a point to the centre of a flat cell, in metres.

    Args:
        cell: the cell; x, y: the point.
        grid: any record with the fields of ``GRID``.
    """
    centre_x, centre_y = centre(cell, grid)
    return centre_x - x, centre_y - y


@inlined
def cell_at(x, y, grid):  # type: ignore[no-untyped-def]
    """Row and column of a point; they may lie outside the grid.

    Args:
        x, y: the point.
        grid: any record with the fields of ``GRID``.
    """
    return (
        int(math.floor((y - grid.origin_y_m) / grid.cell_m)),
        int(math.floor((x - grid.origin_x_m) / grid.cell_m)),
    )


@inlined
def cell_of(x, y, grid):  # type: ignore[no-untyped-def]
    """The flat cell of a point; of one outside the grid, the nearest at its edge.

    Args:
        x, y: the point.
        grid: any record with the fields of ``GRID``.
    """
    row, col = cell_at(x, y, grid)
    row = min(grid.rows - 1, max(0, row))
    col = min(grid.columns - 1, max(0, col))
    return row * grid.columns + col
