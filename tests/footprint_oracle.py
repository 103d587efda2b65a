"""Where a body has room on a map, by SciPy's distance transform and a search in plain Python."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import distance_transform_edt

from swarmscout.core.enums import FREE, OCCUPIED

__all__ = ["entry_of", "room_of"]

Mask = NDArray[np.bool_]


def room_of(occupied: Mask, cell_m: float, radius_m: float, depth_m: float) -> tuple[Mask, Mask]:
    """bool[rows, columns] each: cells in which a body has no room, and in which it may touch."""
    if not occupied.any():
        return occupied.copy(), occupied.copy()
    away_m = distance_transform_edt(~occupied, sampling=cell_m)
    touch_m = radius_m + depth_m
    tight = occupied | (away_m < touch_m - 0.5 * cell_m - 1e-9 * cell_m)
    return tight, away_m < touch_m + 0.5 * cell_m + 0.1 - 1e-9 * cell_m


def entry_of(
    tight: Mask, beside: Mask, labels: NDArray[np.uint8], cell: tuple[int, int], reach: float
) -> tuple[int, int] | None:
    """Where a body drives that is to get to a cell, within `reach` cells of it; None: nowhere."""
    occupied, not_free = labels == OCCUPIED, labels != FREE
    if occupied[cell]:
        return None
    for bad in (beside | not_free, tight | not_free, tight):
        found, seen, todo = [], {cell}, [cell]
        while todo:
            row, col = todo.pop()
            if not bad[row, col]:
                found.append(((row - cell[0]) ** 2 + (col - cell[1]) ** 2, row, col))
                continue
            for near in ((row + 1, col), (row - 1, col), (row, col + 1), (row, col - 1)):
                inside = 0 <= near[0] < tight.shape[0] and 0 <= near[1] < tight.shape[1]
                off2 = (near[0] - cell[0]) ** 2 + (near[1] - cell[1]) ** 2
                if inside and near not in seen and not occupied[near] and off2 <= reach**2 + 1e-9:
                    seen.add(near)
                    todo.append(near)
        if found:
            _, row, col = min(found)
            return row, col
    return None
