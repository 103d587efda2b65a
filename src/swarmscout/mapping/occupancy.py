"""Occupancy grids: labels, prices for routes, frontiers and room for a body, kept cell by cell.

A frontier is a free cell with an unknown neighbour (paper, "Task description"; Yamauchi 1998). One
across a corner does not count where both cells between are occupied: nobody can look or drive round
it from there, and along a slanting wall every step of the staircase has one.
Whether a cell is one can change only when its own label or a neighbour's does, so each change of a
label looks at nine cells and no more.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from swarmscout.core.enums import FREE, OCCUPIED, UNKNOWN
from swarmscout.core.grid import GridFrame
from swarmscout.core.jit import inlined, kernel
from swarmscout.mapping.footprint import (
    FRONTIER,
    LABEL_BITS,
    Footprint,
    find_entries,
    find_exits,
    weigh,
)
from swarmscout.mapping.log_odds import InverseSensorModel

__all__ = [
    "FRONTIER",
    "LABEL_BITS",
    "TILE",
    "BeliefView",
    "OccupancyGrids",
    "apply_evidence",
    "collect_frontiers",
]

CLOSED = 0  # counts[CLOSED]: cells that became occupied or tight in the last update
KNOWN_FREE = 1  # counts[KNOWN_FREE]: cells that are free now
KNOWN_OCCUPIED = 2
FRONTIERS = 3

TILE = 32
"""Edge of the tiles, in cells, for which a map says when they changed last."""

_PER_MAP = ("evidence", "status", "price", "crowd", "counts", "bounds", "changed")
"""Arrays of ``OccupancyGrids`` with a row for each map."""


@inlined
def _is_frontier(status, row, col, rows, columns, neighbours):  # type: ignore[no-untyped-def]
    if status[row * columns + col] & LABEL_BITS != FREE:
        return False
    for near_row in range(max(0, row - 1), min(rows, row + 2)):
        for near_col in range(max(0, col - 1), min(columns, col + 2)):
            if status[near_row * columns + near_col] & LABEL_BITS != UNKNOWN:
                continue
            if near_row == row or near_col == col:
                return True
            if neighbours == 8 and (
                status[near_row * columns + col] & LABEL_BITS != OCCUPIED
                or status[row * columns + near_col] & LABEL_BITS != OCCUPIED
            ):
                return True
    return False


@inlined
def _mark_changed(changed, row, col, reach, rows, columns, now):  # type: ignore[no-untyped-def]
    """Note that cells within reach of a cell may have changed, in rows and columns."""
    across = (columns + TILE - 1) // TILE
    for tile_row in range(max(0, row - reach) // TILE, min(rows - 1, row + reach) // TILE + 1):
        first = tile_row * across + max(0, col - reach) // TILE
        last = tile_row * across + min(columns - 1, col + reach) // TILE
        for tile in range(first, last + 1):
            changed[tile] = now


@kernel
def apply_evidence(  # type: ignore[no-untyped-def]
    m, evidence, status, price, crowd, counts, bounds, changed, stamps, touched, before,
    cells, increments, low, high, rows, columns, thresholds, permille, neighbours, weights,
):  # fmt: skip
    """Add log entries to one map and bring all that is derived from it up to date.

    Args:
        m: which map: a row of the next six.
        evidence: int64[K, C] summed log-odds; status: uint8[K, C']; price: int16[K, C].
        crowd: int32[K, C]; counts: int64[K, 4]; bounds: int64[K, 2]; changed: int64[K, T]: see
            ``OccupancyGrids``.
        stamps: int64[C + 1], scratch: which update touched a cell last; [-1] counts updates.
        touched: int64[C], written: the cells that the entries name, each once.
        before: int64[C], written beside it: their evidence before.
        cells, increments: int64[N, capacity], the logs.
        low, high: int64[N], of robot k's log the entries low[k] … high[k] - 1 are added.
        rows, columns: the grid's shape.
        thresholds: int64[4]: lowest, highest, free_below, occupied_above.
        permille: int16[highest - lowest + 1], probabilities of log-odds.
        neighbours: 4 or 8, for frontiers; weights: of ``Footprint``.

    Returns:
        How many cells were touched.
    """
    lowest, highest, free_below, occupied_above = (
        thresholds[0], thresholds[1], thresholds[2], thresholds[3],
    )  # fmt: skip
    stamps[-1] += 1
    now = stamps[-1]
    n = 0
    for k in range(cells.shape[0]):
        for e in range(low[k], high[k]):
            cell = cells[k, e]
            if stamps[cell] != now:
                stamps[cell] = now
                touched[n] = cell
                before[n] = evidence[m, cell]
                n += 1
            evidence[m, cell] += increments[k, e]
    counts[m, CLOSED] = 0
    for t in range(n):
        cell = touched[t]
        read = min(highest, max(lowest, evidence[m, cell]))
        label = UNKNOWN
        if read < free_below:
            label = FREE
        elif read > occupied_above:
            label = OCCUPIED
        price[m, cell] = -1 if label == OCCUPIED else permille[read - lowest]
        row = cell // columns
        col = cell - row * columns
        bounds[m, 0] = min(bounds[m, 0], row)
        bounds[m, 1] = max(bounds[m, 1], row)
        _mark_changed(changed[m], row, col, 0, rows, columns, now)
        old = status[m, cell] & LABEL_BITS
        if label == old:
            continue
        status[m, cell] = (status[m, cell] & ~LABEL_BITS) | label
        if label == OCCUPIED or old == OCCUPIED:
            sign = 1 if label == OCCUPIED else -1
            closed, first, last = weigh(
                status[m], crowd[m], row, col, rows, columns, weights, sign
            )  # fmt: skip
            counts[m, CLOSED] += closed + (label == OCCUPIED)
            bounds[m, 0] = min(bounds[m, 0], first)
            bounds[m, 1] = max(bounds[m, 1], last)
            _mark_changed(changed[m], row, col, -weights[0, 0], rows, columns, now)
        counts[m, KNOWN_FREE] += (label == FREE) - (old == FREE)
        counts[m, KNOWN_OCCUPIED] += (label == OCCUPIED) - (old == OCCUPIED)
        for near_row in range(max(0, row - 1), min(rows, row + 2)):
            for near_col in range(max(0, col - 1), min(columns, col + 2)):
                near = near_row * columns + near_col
                was = status[m, near] & FRONTIER
                if _is_frontier(status[m], near_row, near_col, rows, columns, neighbours):
                    status[m, near] |= FRONTIER
                    counts[m, FRONTIERS] += was == 0
                else:
                    status[m, near] &= ~FRONTIER
                    counts[m, FRONTIERS] -= was != 0
    return n


@kernel
def collect_frontiers(words, bounds, columns, size, found):  # type: ignore[no-untyped-def]
    """List the frontier cells of one map in the order of their flat index.

    Args:
        words: uint64[C' / 8], the map's status, eight cells a word.
        bounds: int64[2], first and last row with evidence.
        columns: of the grid; size: its number of cells.
        found: int64[frontiers], written.

    Returns:
        How many there are.
    """
    n = 0
    any_frontier = np.uint64(0x0404040404040404)
    first = max(0, bounds[0] * columns // 8)
    last = min((bounds[1] + 1) * columns // 8 + 1, words.shape[0])
    for w in range(first, last):
        word = words[w] & any_frontier
        if word == 0:
            continue
        for b in range(8):
            if word & (np.uint64(4) << np.uint64(8 * b)) and 8 * w + b < size:
                if n == found.shape[0]:  # The map was changed by hand.
                    return n
                found[n] = 8 * w + b
                n += 1
    return n


@kernel
def count_neighbours(status, row, col, rows, columns):  # type: ignore[no-untyped-def]
    """Frontier and occupied cells among a cell's 8 neighbours.

    Args:
        status: uint8[C'], of one map; row, col: the cell; rows, columns: the grid's shape.
    """
    frontiers = 0
    occupied = 0
    for near_row in range(max(0, row - 1), min(rows, row + 2)):
        for near_col in range(max(0, col - 1), min(columns, col + 2)):
            if near_row == row and near_col == col:
                continue
            near = status[near_row * columns + near_col]
            frontiers += near & FRONTIER != 0
            occupied += near & LABEL_BITS == OCCUPIED
    return frontiers, occupied


class BeliefView:
    """One robot's occupancy grid, to be looked at.

    Attributes:
        frame: where it lies.
        model: how its evidence is read.
    """

    def __init__(self, grids: OccupancyGrids, m: int) -> None:
        self._grids = grids
        self._m = m
        self.frame = grids.frame
        self.model = grids.model

    @property
    def labels(self) -> NDArray[np.uint8]:
        """uint8[rows, columns]: UNKNOWN, FREE or OCCUPIED."""
        status = self._grids.status[self._m, : self.frame.size]
        labels: NDArray[np.uint8] = status & np.uint8(LABEL_BITS)
        return labels.reshape(self.frame.shape)

    @property
    def log_odds(self) -> NDArray[np.int32]:
        """int32[rows, columns]: log-odds as read, saturated, in 1/1000 nat."""
        log_odds = np.clip(self._grids.evidence[self._m], self.model.lowest, self.model.highest)
        narrow: NDArray[np.int32] = log_odds.astype(np.int32)
        return narrow.reshape(self.frame.shape)

    @property
    def evidence(self) -> NDArray[np.int64]:
        """int64[rows, columns]: summed evidence, not saturated, in 1/1000 nat (read-only)."""
        view: NDArray[np.int64] = self._grids.evidence[self._m].reshape(self.frame.shape)
        view.flags.writeable = False
        return view

    @property
    def frontier_count(self) -> int:
        """How many frontier cells there are."""
        return self._grids.frontier_count(self._m)

    def frontiers(self) -> NDArray[np.int64]:
        """int64[n, 2]: frontier cells (row, col), by row and then by column."""
        return self.frame.unflat_many(self._grids.frontiers(self._m))

    def neighbour_counts(self, cell: tuple[int, int]) -> tuple[int, int]:
        """Frontier and occupied cells among a cell's 8 neighbours."""
        frontiers, occupied = count_neighbours(
            self._grids.status[self._m], cell[0], cell[1], self.frame.rows, self.frame.columns
        )
        return int(frontiers), int(occupied)


class OccupancyGrids:
    """K occupancy grids over one frame, one for each group of robots that know the same.

    Attributes:
        frame: where they lie.
        model: the inverse sensor model.
        evidence: int64[K, C], summed log-odds in 1/1000 nat.
        footprint: of the robots' body.
        status: uint8[K, C'], label in the lower bits, FRONTIER, TIGHT and BESIDE above; C' is C
            rounded up to 8.
        price: int16[K, C], occupancy probability in 1/1000 for route costs; -1: occupied.
        crowd: int32[K, C], weights of the occupied cells round each, see ``Footprint``.
        counts: int64[K, 4]: closed in the last update, free, occupied, frontier cells.
        bounds: int64[K, 2], first and last row with evidence, or weights of a cell that has some;
            (rows, -1): none.
        changed: int64[K, T], for each tile, by rows, the number of the update that changed it last.
        touched: int64[C], the first `touched_count` are the cells that the last update named;
            before: int64[C], their evidence before it.
    """

    def __init__(
        self,
        frame: GridFrame,
        maps: int,
        model: InverseSensorModel,
        neighbours: int,
        footprint: Footprint | None = None,
    ) -> None:
        self.frame = frame
        self.model = model
        self.footprint = footprint or Footprint()
        size = frame.size
        self.evidence: NDArray[np.int64] = np.zeros((maps, size), dtype=np.int64)
        self.status: NDArray[np.uint8] = np.zeros((maps, -(-size // 8) * 8), dtype=np.uint8)
        self.price: NDArray[np.int16] = np.full((maps, size), 500, dtype=np.int16)
        self.crowd: NDArray[np.int32] = np.zeros((maps, size), dtype=np.int32)
        self.counts: NDArray[np.int64] = np.zeros((maps, 4), dtype=np.int64)
        self.touched: NDArray[np.int64] = np.zeros(size, dtype=np.int64)
        self.before: NDArray[np.int64] = np.zeros(size, dtype=np.int64)
        self.touched_count = 0
        self.bounds = np.tile(np.array([frame.rows, -1], dtype=np.int64), (maps, 1))
        tiles = -(-frame.rows // TILE) * -(-frame.columns // TILE)
        self.changed: NDArray[np.int64] = np.zeros((maps, tiles), dtype=np.int64)
        self._stamps = np.zeros(size + 1, dtype=np.int64)
        self._permille = model.permille()
        self._neighbours = neighbours
        self._thresholds = np.array(
            [model.lowest, model.highest, model.free_below, model.occupied_above], dtype=np.int64
        )

    def apply(
        self,
        m: int,
        cells: NDArray[np.int64],
        increments: NDArray[np.int64],
        low: NDArray[np.int64],
        high: NDArray[np.int64],
    ) -> None:
        """Add entries ``low[k] … high[k] - 1`` of each log k to map m; see the kernel."""
        self.touched_count = apply_evidence(
            m, self.evidence, self.status, self.price, self.crowd, self.counts, self.bounds,
            self.changed, self._stamps, self.touched, self.before, cells, increments, low, high,
            self.frame.rows, self.frame.columns, self._thresholds, self._permille,
            self._neighbours, self.footprint.weights,
        )  # fmt: skip

    def grow(self, maps: int) -> None:
        """Make room for a number of maps; those added hold nothing meaningful."""
        for name in _PER_MAP:
            array = getattr(self, name)
            grown = np.empty((maps, array.shape[1]), dtype=array.dtype)
            grown[: len(array)] = array
            setattr(self, name, grown)

    def copy_row(self, source: int, target: int) -> None:
        """Make one map equal to another."""
        for name in _PER_MAP:
            array = getattr(self, name)
            array[target] = array[source]
        self._stamps[-1] += 1
        self.changed[target] = self._stamps[-1]

    def fork(self, m: int) -> OccupancyGrids:
        """One map of its own, equal to map m now."""
        one = OccupancyGrids(self.frame, 1, self.model, self._neighbours, self.footprint)
        for name in _PER_MAP:
            getattr(one, name)[0] = getattr(self, name)[m]
        return one

    def entries(self, m: int, cells: NDArray[np.int64]) -> NDArray[np.int64]:
        """int64[n], where a body that is to get to flat cells drives; -1: it has no room near."""
        found = np.empty(len(cells), dtype=np.int64)
        find_entries(
            self.status[m], cells, self.frame.rows, self.frame.columns, self.footprint.entry_cells,
            found,
        )  # fmt: skip
        return found

    def exits(self, m: int, cells: NDArray[np.int64]) -> NDArray[np.int64]:
        """int64[n], where bodies in flat cells get room, see ``get_out``."""
        found = np.empty(len(cells), dtype=np.int64)
        find_exits(
            self.status[m], cells, self.frame.rows, self.frame.columns, self.footprint.exit_cells,
            found,
        )  # fmt: skip
        return found

    def frontier_count(self, m: int) -> int:
        """How many frontier cells map m has."""
        return int(self.counts[m, FRONTIERS])

    def frontiers(self, m: int) -> NDArray[np.int64]:
        """int64[n]: flat frontier cells of map m, ascending."""
        found = np.empty(self.counts[m, FRONTIERS], dtype=np.int64)
        if len(found):
            collect_frontiers(
                self.status[m].view(np.uint64),
                self.bounds[m],
                self.frame.columns,
                self.frame.size,
                found,
            )
        return found

    def view(self, m: int) -> BeliefView:
        """Map m, to be looked at."""
        return BeliefView(self, m)
