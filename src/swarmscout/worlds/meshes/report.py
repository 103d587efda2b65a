"""The report of an import: what was found, decided and left out."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

__all__ = ["ImportReport", "passage_widths_m"]

_COARSE_M = 0.2
_SHARES = (0.05, 0.5, 0.95)


@dataclass(frozen=True)
class ImportReport:
    """What was made of a mesh.

    Attributes:
        file: its name.
        size_m: extent along x, y and z, in metres.
        triangles: how many were used.
        cleaned: what was taken out → how many triangles.
        decisions: what was decided → what, and why.
        floor_m2: area of the cells that have a floor of the selected kind.
        free_m2: area of the world's free cells.
        reachable_m2: area that the body of a robot can cover from the start.
        passages_m: widths of passages: 5 %, 50 % and 95 % of the floor is in narrower ones.
        left_out_m2: why floor is not free → its area.
        start_m: ``(x, y, z)`` in the world's frame, on the ground.
        start_proposed: whether the start was found rather than given.
        notes: properties of the mesh that may be unintended, one line each.
        seconds: how long the import took.
    """

    file: str
    size_m: tuple[float, float, float]
    triangles: int
    cleaned: dict[str, int]
    decisions: dict[str, str]
    floor_m2: float
    free_m2: float
    reachable_m2: float
    passages_m: tuple[float, float, float]
    left_out_m2: dict[str, float]
    start_m: tuple[float, float, float]
    start_proposed: bool
    notes: tuple[str, ...] = ()
    seconds: float = field(default=0.0, compare=False)

    def lines(self) -> list[str]:
        """The report for people, a line for each thing."""
        size = " × ".join(f"{length:,.1f}" for length in self.size_m)
        dirt = ", ".join(f"{count:,} {what}" for what, count in self.cleaned.items() if count)
        narrow, usual, wide = self.passages_m
        left_out = ", ".join(
            f"{area:,.0f} m² {why}" for why, area in self.left_out_m2.items() if area >= 0.5
        )
        x, y, z = self.start_m
        how = "proposed: a roomy place" if self.start_proposed else "as given"
        return [
            f"mesh: {self.file}, {size} m, {self.triangles:,} triangles"
            + (f"; taken out: {dirt}" if dirt else ""),
            *(f"{what}: {how}" for what, how in self.decisions.items()),
            f"floor: {self.floor_m2:,.0f} m², of which free: {self.free_m2:,.0f} m², reachable for "
            f"a robot: {self.reachable_m2:,.0f} m²",
            f"left out: {left_out or 'nothing'}",
            f"passages: half of the floor is in those narrower than {usual:.1f} m, 5 % below "
            f"{narrow:.1f} m, 5 % above {wide:.1f} m",
            f"start: {x:.2f},{y:.2f},{z:.2f} m ({how})",
            *(f"note: {note}" for note in self.notes),
            f"time: {self.seconds:.1f} s",
        ]


def passage_widths_m(free: NDArray[np.bool_], cell_m: float) -> tuple[float, float, float]:
    """Widths of passages: 5 %, 50 % and 95 % of the floor is in narrower ones.

    Args:
        free: bool[rows, cols].
        cell_m: edge of a cell, in metres.
    """
    from skimage.morphology import skeletonize

    if not free.any():
        return 0.0, 0.0, 0.0
    fine = math.floor(_COARSE_M / cell_m + 1e-6)
    if fine > 1:  # A few times quicker, and as good for a report.
        free, cell_m = free[::fine, ::fine], cell_m * fine
    room = ndimage.distance_transform_edt(free)
    # From a cell's centre to that of the nearest wall cell: the wall begins half a cell earlier.
    widths = np.sort((2.0 * room[skeletonize(free)] - 1.0) * cell_m)
    # Weighted by width, as the floor is; unweighted, the short branches beside pebbles would count.
    share = np.cumsum(widths) / widths.sum()
    narrow, usual, wide = (float(widths[np.searchsorted(share, part)]) for part in _SHARES)
    return narrow, usual, wide
