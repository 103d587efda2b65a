"""Scans become evidence: the inverse sensor model.

Increments are summed per beam and merged per scan and cell.

Source: paper, "Robot model"; Thrun, Burgard, Fox (2005), *Probabilistic Robotics*, table 9.2.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from swarmscout.core.enums import WALL_CONTACT
from swarmscout.core.grid import GridFrame
from swarmscout.core.jit import inlined, kernel
from swarmscout.core.scan import TICKS, Scan, rays_in
from swarmscout.mapping.evidence import EvidenceLog
from swarmscout.mapping.log_odds import InverseSensorModel

__all__ = ["BUMP_HITS", "inverse_model", "observe", "rays_per_beam", "scan_evidence"]

BUMP_HITS = 4
"""Number of hits that a bump counts as. It is certain, and rays that pass over a drop or through
the open part of a cell must not outvote it at once. Much more, and a bump at the edge of a narrow
passage would close it for good."""

_MODEL = np.dtype([
    # The occupancy grid's frame.
    ("origin_x_m", "f8"), ("origin_y_m", "f8"), ("cell_m", "f8"), ("rows", "i8"), ("columns", "i8"),
    # Evidence in 1/1000 nat, and how far behind its measured surface an obstacle lies.
    ("free", "i8"), ("occupied", "i8"), ("depth_m", "f8"),
    # The beams: longest range, opening, and the bundle of rays that a beam stands for, in ticks.
    ("range_m", "f8"), ("opening", "i8"), ("apart", "i8"), ("lines", "i8"),
    # Cells from a robot's own one to the border of what its scan can touch; (cos, sin).
    ("reach", "i8"), ("table", "f8", (TICKS, 2)),
])  # fmt: skip


def rays_per_beam(scan: Scan, cell_m: float) -> tuple[int, int]:
    """How many rays a beam is read as, and how far they are apart, in ticks.

    At the longest range neighbours are at most half a map cell apart, or one tick.

    Args:
        scan: any scan of a sensor; cell_m: edge of a map cell.
    """
    return rays_in(scan.opening, scan.max_range_m, cell_m)


def inverse_model(
    scan: Scan, model: InverseSensorModel, frame: GridFrame, table: NDArray[np.float64], reach: int
) -> NDArray[Any]:
    """The inverse sensor model of one sensor, as the one record that :func:`observe` takes.

    Args:
        scan: any scan of the sensor.
        model: the evidence of a cell that was passed, and of one in which a beam ended.
        frame: the occupancy grid's frame.
        table: float64[3600, 2], (cos, sin) of every heading.
        reach: of the evidence log.
    """
    lines, apart = rays_per_beam(scan, frame.cell_m)
    record = (
        frame.origin_x_m, frame.origin_y_m, frame.cell_m, frame.rows, frame.columns,
        model.free, model.occupied, model.hit_depth_m,
        scan.max_range_m, scan.opening, apart, lines, reach, table,
    )  # fmt: skip
    return np.array([record], dtype=_MODEL)


@inlined
def _add(window, span, sparse, row, col, increment):  # type: ignore[no-untyped-def]
    """Add to a cell of the window, and note its column where few cells are touched."""
    window[row, col] += increment
    if sparse:
        span[row, 0] = min(span[row, 0], col)
        span[row, 1] = max(span[row, 1], col)


@inlined
def _append(window, span, low, left, rows, columns, cells, increments):  # type: ignore[no-untyped-def]
    """Write a scan's sums into a log, by row and column, and clear the window; returns how many."""
    written = 0
    for row in range(window.shape[0]):
        for col in range(span[row, 0], span[row, 1] + 1):
            increment = window[row, col]
            if increment == 0:
                continue
            window[row, col] = 0
            if 0 <= row + low < rows and 0 <= col + left < columns:
                cells[written] = (row + low) * columns + col + left
                increments[written] = increment
                written += 1
    return written


@inlined
def _clear(  # type: ignore[no-untyped-def]
    window, seen, span, wide, sparse, beam, x, y, left, low, dx, dy, longest, hit_row, hit_col, free
):
    """Add `free` to the cells that a ray passes, but for those in which its beam ended.

    Source: Amanatides and Woo (1987), "A fast voxel traversal algorithm for ray tracing".
    """
    col = int(math.floor(x))
    row = int(math.floor(y))
    step_col = 1 if dx > 0.0 else -1
    step_row = 1 if dy > 0.0 else -1
    per_col = abs(1.0 / dx) if dx != 0.0 else np.inf
    per_row = abs(1.0 / dy) if dy != 0.0 else np.inf
    next_col = (col + 1 - x if dx > 0.0 else x - col) * per_col if dx != 0.0 else np.inf
    next_row = (row + 1 - y if dy > 0.0 else y - row) * per_row if dy != 0.0 else np.inf
    col -= left
    row -= low
    while True:
        if wide:
            fresh = seen[row, col] != beam
            seen[row, col] = beam
        else:
            fresh = row != hit_row or col != hit_col
        if fresh:
            _add(window, span, sparse, row, col, free)
        if min(next_col, next_row) > longest:
            return
        if next_col < next_row:
            next_col += per_col
            col += step_col
        else:
            next_row += per_row
            row += step_row


@kernel
def scan_evidence(  # type: ignore[no-untyped-def]
    own, can, ranges, directions, models, touch, cells, increments, length
):
    """Append each robot's scan, seen from where it believes to be, to its own log.

    A beam is a ray, or a bundle of rays that all measured the same range. The cells in which its
    rays ended are occupied, and the other cells that they passed are free, each counted once.

    Args:
        own: MIND[N]; can: CAPABILITIES[N].
        ranges: float64[N, beams], inf where nothing was met; directions: int64[beams] in ticks.
        models: of :func:`inverse_model`.
        touch: TOUCH[N]: a wall that was touched in the last step, seen from the robot's centre.
        cells, increments: int64[N, capacity]; length: int64[N]: the logs.
    """
    model = models[0]
    table = model.table
    ticks = table.shape[0]
    edge = 2 * model.reach + 1
    # The scan's sum for each cell round the robot; of each row the columns to look at afterwards
    # (all, where many rays touch most of the window); for wide beams, which one saw a cell last.
    window = np.zeros((edge, edge), dtype=np.int32)
    wide = model.opening > 0
    seen = np.zeros((edge, edge) if wide else (1, 1), dtype=np.int64)
    span = np.empty((edge, 2), dtype=np.int64)
    sparse = directions.shape[0] * model.lines < edge
    span[:, 0] = edge if sparse else 0
    span[:, 1] = -1 if sparse else edge - 1
    beam = 0
    for i in range(own.shape[0]):
        if not (own[i].thinks and can[i].sense):
            continue
        x = (own[i].x_m - model.origin_x_m) / model.cell_m
        y = (own[i].y_m - model.origin_y_m) / model.cell_m
        left = int(math.floor(x)) - model.reach
        low = int(math.floor(y)) - model.reach
        for r in range(directions.shape[0]):
            beam += 1
            met = ranges[i, r] <= model.range_m
            longest = min(ranges[i, r], model.range_m) / model.cell_m
            first = own[i].heading + directions[r] - model.opening // 2
            hit_row = -1
            hit_col = -1
            if met:
                ended = longest + model.depth_m / model.cell_m
                for line in range(model.lines):
                    tick = (first + min(line * model.apart, model.opening)) % ticks
                    hit_row = int(math.floor(y + table[tick, 1] * ended)) - low
                    hit_col = int(math.floor(x + table[tick, 0] * ended)) - left
                    if wide:
                        if seen[hit_row, hit_col] == beam:
                            continue
                        seen[hit_row, hit_col] = beam
                    _add(window, span, sparse, hit_row, hit_col, model.occupied)
            for line in range(model.lines):
                tick = (first + min(line * model.apart, model.opening)) % ticks
                _clear(
                    window, seen, span, wide, sparse, beam, x, y, left, low,
                    table[tick, 0], table[tick, 1], longest, hit_row, hit_col,
                    model.free,
                )  # fmt: skip
        if touch[i].kind == WALL_CONTACT:
            # Deviation: a bump is a measurement too; the paper does not speak of contacts.
            row = int(math.floor(y + touch[i].dy_m / model.cell_m)) - low
            col = int(math.floor(x + touch[i].dx_m / model.cell_m)) - left
            _add(window, span, sparse, row, col, BUMP_HITS * model.occupied)
        length[i] += _append(
            window, span, low, left, model.rows, model.columns,
            cells[i, length[i] :], increments[i, length[i] :],
        )  # fmt: skip
        if sparse:
            span[:, 0] = edge
            span[:, 1] = -1


def observe(
    log: EvidenceLog,
    own: NDArray[np.void],
    can: NDArray[np.void],
    scan: Scan,
    touch: NDArray[np.void],
    model: NDArray[Any],
) -> None:
    """Phase 2 of a step: every robot logs what its scan says; see :func:`scan_evidence`.

    Call :meth:`swarmscout.mapping.evidence.EvidenceLog.make_room` before.

    Args:
        log: written. own: MIND[N]; can: CAPABILITIES[N]; scan: of all robots; touch: TOUCH[N].
        model: of :func:`inverse_model`.
    """
    scan_evidence(
        own, can, scan.ranges, scan.directions, model, touch, log.cells, log.increments, log.length
    )
