"""Where flat cells of a grid lie, inside kernels."""

from __future__ import annotations

from swarmscout.core.jit import inlined

__all__ = ["offset"]


@inlined
def offset(cell, x, y, grid):  # type: ignore[no-untyped-def]
    """From a point to the centre of a flat cell, in metres.

    Args:
        cell: the cell; x, y: the point.
        grid: any record with the fields of ``GRID``.
    """
    return (
        grid.origin_x_m + (cell % grid.columns + 0.5) * grid.cell_m - x,
        grid.origin_y_m + (cell // grid.columns + 0.5) * grid.cell_m - y,
    )
