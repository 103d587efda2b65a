"""Features of frontiers, worked out when a rule asks for them, and once for all who share a map."""

from __future__ import annotations

import math
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from swarmscout.core.grid import GridFrame
from swarmscout.destinations.grid_kernels import (
    count_around,
    count_within,
    label_clusters,
    locate,
    walk,
)
from swarmscout.destinations.walking import FAR
from swarmscout.mapping.occupancy import OccupancyGrids

__all__ = ["Features", "Frontiers", "Scratch", "disc_half_widths"]

GATE_MM = 1000
"""Which way a walk leads is read off where it has gone this far."""


KINDS = ("unknown", "free", "occupied", "frontier")
"""Kinds of cells, in the order in which they are counted."""


class Scratch:
    """Scratch memory of the kernels in ``grid_kernels``, allocated once per mission.

    Attributes:
        field: int64[C, 2]; queues: int64[2, 2 C]; places: int32[C].
        edge: bool[rows, columns], whether a cell lies at the grid's edge.
        lengths: int64[2], of an orthogonal and a diagonal move, in mm.
    """

    def __init__(self, frame: GridFrame) -> None:
        self.field = np.full((frame.size, 2), FAR, dtype=np.int64)
        # A cell waits at most once in each queue; sources wait besides.
        self.queues = np.zeros((2, 2 * frame.size), dtype=np.int64)
        self.places = np.full(frame.size, -1, dtype=np.int32)
        self.edge = np.ones(frame.shape, dtype=np.bool_)
        self.edge[1:-1, 1:-1] = False
        mm = 1000.0 * frame.cell_m
        self.lengths = np.array([round(mm), round(mm * math.sqrt(2.0))], dtype=np.int64)


class Frontiers:
    """The task's candidates in one map and step, made once for all leaders that see it.

    Attributes:
        flat: int64[F], ascending; cells: int64[F, 2]; centres_m: float64[F, 2].

    Args:
        grids: the maps. m: which of them. flat: see above. scratch: memory of the kernels.
    """

    def __init__(
        self, grids: OccupancyGrids, m: int, flat: NDArray[np.int64], scratch: Scratch
    ) -> None:
        self.flat = flat
        frame = grids.frame
        self.cells = np.empty((len(self.flat), 2), dtype=np.int64)
        self.centres_m = np.empty((len(self.flat), 2))
        locate(
            self.flat, frame.origin_x_m, frame.origin_y_m, frame.cell_m, frame.columns,
            self.cells, self.centres_m,
        )  # fmt: skip
        self.cells.flags.writeable = False
        self.centres_m.flags.writeable = False
        self.frame = frame
        self.grids, self.m = grids, m
        self.status = grids.status[m]
        self.scratch = scratch
        self._around: NDArray[np.int64] | None = None
        self._clusters: NDArray[np.int64] | None = None
        self._nearest: dict[bytes, NDArray[np.int64]] = {}
        self._areas: dict[float, NDArray[np.float64]] = {}

    def around(self) -> NDArray[np.int64]:
        """int64[2, F], frontier and occupied cells among the 8 neighbours."""
        if self._around is None:
            self._around = np.empty((2, len(self.flat)), dtype=np.int64)
            count_around(self.status, self.flat, self.frame.rows, self.frame.columns, self._around)
        return self._around

    def clusters(self) -> NDArray[np.int64]:
        """int64[F], which group of touching frontier cells each belongs to."""
        if self._clusters is None:
            self._clusters = np.empty(len(self.flat), dtype=np.int64)
            label_clusters(self.flat, self.frame.columns, self.scratch.places, self._clusters)
        return self._clusters

    def areas_m2(self, reach_m: float) -> NDArray[np.float64]:
        """float64[4, F], area of each of KINDS in a disc round each."""
        if reach_m not in self._areas:
            cell_m = self.frame.cell_m
            widths = disc_half_widths(reach_m, cell_m)
            counts = np.empty((len(KINDS), len(self.flat)), dtype=np.int64)
            count_within(
                self.status, self.flat, widths, self.frame.rows, self.frame.columns, counts,
            )  # fmt: skip
            self._areas[reach_m] = counts * np.float64(cell_m**2)
        return self._areas[reach_m]

    @cached_property
    def entries(self) -> NDArray[np.int64]:
        """int64[F], the flat cells where a body that is to get to each drives; -1: none."""
        return self.grids.entries(self.m, self.flat)

    def walks(
        self,
        sources: NDArray[np.int64],
        keep: NDArray[np.int64] | None = None,
        gate_mm: int = GATE_MM,
    ) -> NDArray[np.int64]:
        """int64[2, n], see :func:`swarmscout.destinations.grid_kernels.walk`.

        Args:
            sources: int64[S], flat cells. keep: int64[n], to which of F; None for all.
            gate_mm: see there.
        """
        targets = self.entries if keep is None else self.entries[keep]
        found = np.empty((2, len(targets)), dtype=np.int64)
        scratch = self.scratch
        walk(
            self.status, sources, targets, scratch.edge, scratch.lengths, gate_mm, scratch.field,
            scratch.queues, found,
        )  # fmt: skip
        # Nowhere leads the way to what has none.
        flat = self.flat if keep is None else self.flat[keep]
        np.copyto(found[1], flat, where=found[0] < 0)
        return found

    def nearest_of(self, places: NDArray[np.int64]) -> NDArray[np.int64]:
        """int64[F], from which of some cells (flat, ascending) the way is shortest; -1: none."""
        key = places.tobytes()
        if key not in self._nearest:
            length, source = self.walks(places, gate_mm=0)
            self._nearest[key] = np.where(length < 0, -1, source)
        return self._nearest[key]


class Features:
    """What one leader's view tells of its frontiers; the view hands it on.

    Args:
        frontiers: of the leader's map.
        keep: int64[n], those of F that the leader may choose from; None for all.
        place_m: where the leader is.
    """

    def __init__(
        self,
        frontiers: Frontiers,
        keep: NDArray[np.int64] | None,
        place_m: tuple[float, float],
    ) -> None:
        self._frontiers = frontiers
        self._keep = keep
        self._place_m = place_m

    @cached_property
    def _flat(self) -> NDArray[np.int64]:
        flat = self._frontiers.flat
        return flat if self._keep is None else flat[self._keep]

    @cached_property
    def _place(self) -> int:
        frame = self._frontiers.frame
        row, col = frame.cell_of(*self._place_m)
        cell = frame.flat(min(max(row, 0), frame.rows - 1), min(max(col, 0), frame.columns - 1))
        return int(self._exits(np.array([cell]))[0])

    def has(self, cell: int) -> bool:
        """Whether the leader may choose a flat cell."""
        at = _find(self._frontiers.flat, cell)
        return at >= 0 and (self._keep is None or _find(self._keep, at) >= 0)

    def among(self, keep: NDArray[np.bool_]) -> Features:
        """The same with fewer frontiers: bool[n], those to keep."""
        index = keep.nonzero()[0] if self._keep is None else self._keep[keep]
        return Features(self._frontiers, index, self._place_m)

    def around(self) -> NDArray[np.int64]:
        """int64[2, n], frontier and occupied cells among the 8 neighbours."""
        counts = self._frontiers.around()
        return counts.copy() if self._keep is None else counts[:, self._keep]

    def clusters(self) -> NDArray[np.int64]:
        """int64[n], which group of touching frontier cells each belongs to, 0, 1, …."""
        labels = self._frontiers.clusters()
        if self._keep is None:
            return labels.copy()
        numbers: NDArray[np.int64] = np.unique(labels[self._keep], return_inverse=True)[1]
        return numbers

    def area_m2(self, kind: str, reach_m: float) -> NDArray[np.float64]:
        """float64[n], area of cells of a kind of KINDS in a disc round each."""
        areas: NDArray[np.float64] = self._frontiers.areas_m2(reach_m)[KINDS.index(kind)]
        return areas.copy() if self._keep is None else areas[self._keep]

    def walk(self) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
        """Ways from the leader: float64[n] in metres (inf: none), and int64[n], first cells.

        The latter are flat cells: where each way has come to after about a metre.
        """
        found = self._frontiers.walks(np.array([self._place]), self._keep)
        return _in_metres(found[0]), found[1]

    def walk_from(self, places_m: NDArray[np.float64]) -> NDArray[np.float64]:
        """float64[n], the shortest way from any of some places, in metres (inf: none)."""
        return _in_metres(self._frontiers.walks(self._flat_cells(places_m), self._keep)[0])

    def in_own_voronoi_cell(self, others_m: NDArray[np.float64]) -> NDArray[np.bool_]:
        """bool[n], whether the leader's way is shorter than those from other places.

        The search is shared: whoever has heard of the same teams has the same places in all.
        """
        places = np.append(self._flat_cells(others_m), self._place)
        nearest = self._frontiers.nearest_of(np.unique(places))
        own: NDArray[np.bool_] = nearest == self._place
        return own if self._keep is None else own[self._keep]

    def centres_m(self, cells: NDArray[np.int64]) -> NDArray[np.float64]:
        """float64[n, 2], centres of flat cells."""
        frame = self._frontiers.frame
        return frame.centres_of(frame.unflat_many(cells))

    def _flat_cells(self, places_m: NDArray[np.float64]) -> NDArray[np.int64]:
        frame = self._frontiers.frame
        places = frame.cells_of(places_m)
        row = np.minimum(np.maximum(places[:, 0], 0), frame.rows - 1)
        col = np.minimum(np.maximum(places[:, 1], 0), frame.columns - 1)
        cells: NDArray[np.int64] = row * frame.columns + col
        return self._exits(cells)

    def _exits(self, cells: NDArray[np.int64]) -> NDArray[np.int64]:
        return self._frontiers.grids.exits(self._frontiers.m, cells)


def disc_half_widths(reach_m: float, cell_m: float) -> NDArray[np.int64]:
    """int64[r + 1]: half the width, in cells, of a disc 0 … r rows off its centre."""
    rows_off = np.arange(int(reach_m / cell_m) + 1)
    widths = np.sqrt(np.maximum((reach_m / cell_m) ** 2 - rows_off**2, 0.0))
    half_widths: NDArray[np.int64] = widths.astype(np.int64)
    return half_widths


def _find(ascending: NDArray[np.int64], value: int) -> int:
    at = int(ascending.searchsorted(value))
    return at if at < len(ascending) and int(ascending[at]) == value else -1


def _in_metres(length_mm: NDArray[np.int64]) -> NDArray[np.float64]:
    length_m = length_mm / 1000.0
    length_m[length_mm < 0] = np.inf
    return length_m
