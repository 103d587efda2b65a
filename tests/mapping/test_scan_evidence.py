"""Scans become evidence: the kernel against a slow reference written from the definition."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence
from itertools import pairwise

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from swarmscout.core.enums import NO_CONTACT, ROBOT_CONTACT, WALL_CONTACT
from swarmscout.core.grid import GridFrame
from swarmscout.core.scan import Scan
from swarmscout.mapping.evidence import EvidenceLog
from swarmscout.mapping.log_odds import InverseSensorModel
from swarmscout.mapping.scan_evidence import BUMP_HITS, inverse_model, observe, rays_per_beam
from swarmscout.minds.minds import blank_minds
from swarmscout.robots.bodies import place_bodies

TICKS = 3600
ANGLES = np.arange(TICKS) * 2.0 * np.pi / TICKS
TABLE = np.column_stack([np.cos(ANGLES), np.sin(ANGLES)]).round(15)
FREE, OCCUPIED = -405, 847


Array = NDArray[np.float64]


def read(
    log: EvidenceLog,
    frame: GridFrame,
    scan: Scan,
    poses: Array,
    touch: Sequence[tuple[float, float, int]] | None = None,
    sensing: NDArray[np.bool_] | None = None,
    depth_m: float = 0.0,
) -> None:
    """One scan of all robots into their logs; poses are x, y and heading, touches dx, dy, kind."""
    bodies = place_bodies(poses[:, :2], poses[:, 2].astype(np.int64), np.ones(len(poses)))
    own = blank_minds(len(poses)).own
    own["x_m"], own["y_m"], own["heading"] = poses.T
    if sensing is not None:
        bodies.can["sense"] = sensing
    for i, (dx_m, dy_m, kind) in enumerate(touch or ()):
        bodies.touch[i] = dx_m, dy_m, kind, -1
    grid = InverseSensorModel(FREE, OCCUPIED, -3476, 3476, -619, 619, depth_m)
    model = inverse_model(scan, grid, frame, TABLE, log.reach)
    log.make_room(np.zeros(len(poses), dtype=np.int64))
    observe(log, own, bodies.can, scan, bodies.touch, model)


def cells_on_way(frame: GridFrame, start: Array, end: Array) -> set[tuple[int, int]]:
    """Cells that a straight way enters: cut it at all grid lines, and look in the middles."""
    cuts = [0.0, 1.0]
    for axis, origin in enumerate((frame.origin_x_m, frame.origin_y_m)):
        a, b = (start[axis] - origin) / frame.cell_m, (end[axis] - origin) / frame.cell_m
        low, high = min(a, b), max(a, b)
        lines = np.arange(np.ceil(low), np.floor(high) + 1.0)
        if b != a:
            cuts += ((lines - a) / (b - a)).tolist()
    cuts = sorted(cut for cut in cuts if 0.0 <= cut <= 1.0)
    middles = [(s + t) / 2.0 for s, t in pairwise(cuts)]
    return {frame.cell_of(*(start + t * (end - start))) for t in middles}


def reference(
    frame: GridFrame, place: Array, tick: int, ranges: Array, offsets: NDArray[np.int64],
    range_m: float, contact: int, contact_offset: Array, depth_m: float,
) -> dict[int, int]:  # fmt: skip
    """Sum of one scan's increments for each cell of the grid that it says something about."""
    total: dict[tuple[int, int], int] = defaultdict(int)
    for measured, offset in zip(ranges, offsets, strict=True):
        angle = ANGLES[(tick + int(offset)) % TICKS]
        way = np.array([np.cos(angle), np.sin(angle)])
        passed = cells_on_way(frame, place, place + min(measured, range_m) * way)
        if measured <= range_m:
            ended = frame.cell_of(*(place + (measured + depth_m) * way))
            passed.discard(ended)
            total[ended] += OCCUPIED
        for cell in passed:
            total[cell] += FREE
    if contact == WALL_CONTACT:
        total[frame.cell_of(*(place + contact_offset))] += BUMP_HITS * OCCUPIED
    return {frame.flat(*cell): sum_ for cell, sum_ in total.items() if frame.contains(*cell)}


@settings(max_examples=100)
@given(
    seed=st.integers(0, 2**32 - 1),
    cell_m=st.sampled_from([0.1, 0.25, 0.5, 0.7, 2.0]),
    rays=st.integers(1, 12),
    range_m=st.floats(0.1, 2.5),
    depth_m=st.sampled_from([0.0, 0.05, 0.3]),
)
def test_log_entries_equal_the_reference(
    seed: int, cell_m: float, rays: int, range_m: float, depth_m: float
) -> None:
    rng = np.random.default_rng(seed)
    robots = 4
    frame = GridFrame(*rng.uniform(-3.0, 3.0, 2).tolist(), cell_m, *rng.integers(3, 12, 2).tolist())
    left, right, bottom, top = frame.extent
    offsets = rng.integers(-TICKS // 2, TICKS // 2, rays)
    log = EvidenceLog(robots, rays, range_m + 0.5, cell_m)
    expected: list[list[dict[int, int]]] = [[] for _ in range(robots)]
    lengths = [log.length.copy()]
    for _ in range(3):
        reading = np.column_stack([
            # A robot may believe to be outside of its map.
            rng.uniform(left - 1.0, right + 1.0, robots),
            rng.uniform(bottom - 1.0, top + 1.0, robots),
            rng.integers(0, TICKS, robots),
        ])  # fmt: skip
        ranges = rng.uniform(0.0, 1.3 * range_m, (robots, rays))
        ranges[rng.random((robots, rays)) < 0.3] = np.inf
        ranges[rng.random((robots, rays)) < 0.1] = 0.0
        contact = rng.choice([NO_CONTACT, WALL_CONTACT, ROBOT_CONTACT], robots)
        contact_offset = rng.uniform(-0.3, 0.3, (robots, 2))
        sensing = rng.random(robots) < 0.8
        scan = Scan(ranges, offsets, range_m)
        touch = [(*offset, kind) for offset, kind in zip(contact_offset, contact, strict=True)]
        read(log, frame, scan, reading, touch, sensing, depth_m)
        lengths.append(log.length.copy())
        for i in range(robots):
            expected[i].append(
                reference(
                    frame, reading[i, :2], int(reading[i, 2]), ranges[i], offsets, range_m,
                    int(contact[i]), contact_offset[i], depth_m,
                ) if sensing[i] else {}
            )  # fmt: skip
    for i in range(robots):
        for scan, wanted in enumerate(expected[i]):
            entries = slice(lengths[scan][i], lengths[scan + 1][i])
            cells = log.cells[i, entries].tolist()
            assert len(set(cells)) == len(cells) <= log.per_scan
            assert dict(zip(cells, log.increments[i, entries].tolist(), strict=True)) == {
                cell: sum_ for cell, sum_ in wanted.items() if sum_ != 0
            }


def test_a_ray_straight_ahead_by_hand() -> None:
    frame = GridFrame(0.0, 0.0, 0.5, rows=3, columns=6)
    log = EvidenceLog(1, 1, 2.5, 0.5)
    reading = np.array([[0.25, 0.75, 0.0]])
    scan = Scan(np.array([[1.2]]), np.array([0]), 2.0)
    read(log, frame, scan, reading)
    assert log.cells[0, :3].tolist() == [6, 7, 8]
    assert log.increments[0, :3].tolist() == [FREE, FREE, OCCUPIED]
    # Nothing met: every cell up to the longest range is free.
    scan = Scan(np.array([[np.inf]]), np.array([0]), 2.0)
    read(log, frame, scan, reading)
    assert log.cells[0, 3:8].tolist() == [6, 7, 8, 9, 10]
    assert log.increments[0, 3:8].tolist() == [FREE] * 5
    assert log.length.tolist() == [8]


def cone_reference(
    frame: GridFrame, place: Array, tick: int, half: int, measured: float, range_m: float
) -> tuple[set[tuple[int, int]], set[tuple[int, int]]]:
    """Cells on a cone's arc, and cells in front of it, by a ray for each tick of its opening."""
    ways = TABLE[np.arange(tick - half, tick + half + 1) % TICKS]
    arc = {frame.cell_of(*p) for p in place + measured * ways} if measured <= range_m else set()
    ends = place + min(measured, range_m) * ways
    inside = set().union(*(cells_on_way(frame, place, end) for end in ends))
    return arc, inside - arc


@settings(max_examples=30, deadline=None)
@given(
    seed=st.integers(0, 2**32 - 1),
    opening_deg=st.integers(1, 180),
    cell_m=st.sampled_from([0.25, 0.5]),
    measured=st.sampled_from([0.4, 1.3, 2.2, np.inf]),
)
def test_a_cone_fills_its_arc_and_clears_what_lies_before_it(
    seed: int, opening_deg: int, cell_m: float, measured: float
) -> None:
    rng = np.random.default_rng(seed)
    frame = GridFrame(0.0, 0.0, cell_m, 40, 40)
    place = frame.centre_of(20, 20) + rng.uniform(-0.5, 0.5, 2) * cell_m
    tick = int(rng.integers(0, TICKS))
    scan = Scan(np.array([[measured]]), np.array([0]), 2.5, opening_deg * 10)
    lines = rays_per_beam(scan, cell_m)[0]
    log = EvidenceLog(1, lines, 3.0, cell_m)
    read(log, frame, scan, np.array([[*place, tick]]))
    n = int(log.length[0])
    assert n <= log.per_scan
    entries = dict(zip(log.cells[0, :n].tolist(), log.increments[0, :n].tolist(), strict=True))
    assert len(entries) == n, "each cell once"
    assert list(entries) == sorted(entries)
    assert set(entries.values()) <= {FREE, OCCUPIED}, "each cell counts once"
    arc, free = cone_reference(frame, place, tick, opening_deg * 5, measured, 2.5)
    occupied = {frame.unflat(c) for c, v in entries.items() if v == OCCUPIED}
    cleared = {frame.unflat(c) for c, v in entries.items() if v == FREE}
    # Rays half a cell apart may miss the corners of cells, and nothing else.
    assert occupied <= arc
    assert len(arc - occupied) <= 0.25 * len(arc) + 2
    assert cleared <= free | arc
    assert len(free - cleared) <= 0.15 * len(free) + 3


def fill(log: EvidenceLog, scans: int, seed: int) -> list[list[tuple[int, int]]]:
    """Write scans of random length by hand; returns what was written."""
    rng = np.random.default_rng(seed)
    written: list[list[tuple[int, int]]] = [[] for _ in log.length]
    for _ in range(scans):
        log.make_room(np.zeros_like(log.length))
        for k in range(len(log.length)):
            for _ in range(int(rng.integers(log.per_scan // 2, log.per_scan + 1))):
                entry = int(rng.integers(10**6)), int(rng.integers(-900, 900))
                log.cells[k, log.length[k]], log.increments[k, log.length[k]] = entry
                log.length[k] += 1
                written[k].append(entry)
    return written


@settings(max_examples=5)
@given(st.integers(0, 2**32 - 1))
def test_a_log_that_grows_keeps_what_it_holds(seed: int) -> None:
    log = EvidenceLog(2, 1, 0.4, 0.5)
    capacity = log.cells.shape[1]
    written = fill(log, 200, seed)
    assert log.cells.shape[1] > 2 * capacity
    for k, entries in enumerate(written):
        n = int(log.length[k])
        kept = list(zip(log.cells[k, :n].tolist(), log.increments[k, :n].tolist(), strict=True))
        assert kept == entries


def test_a_log_that_all_have_read_holds_one_scan() -> None:
    log = EvidenceLog(2, 3, 1.5, 0.5)
    for scan in range(5):
        log.make_room(log.end())
        assert log.length.tolist() == [0, 0]
        log.length[:] = 7, 2 * scan
    assert log.end().tolist() == [35, 20]
    assert log.cells.shape == (2, log.per_scan)


@settings(max_examples=30)
@given(st.integers(0, 2**32 - 1))
def test_a_log_forgets_only_what_all_have_read(seed: int) -> None:
    """Entries keep their numbers, whatever is dropped before them."""
    rng = np.random.default_rng(seed)
    log = EvidenceLog(2, 1, 0.4, 0.5)
    written: list[list[tuple[int, int]]] = [[], []]
    oldest = np.zeros(2, dtype=np.int64)
    for _ in range(30):
        log.make_room(oldest)
        assert (log.dropped <= oldest).all()
        assert (log.length + log.per_scan <= log.cells.shape[1]).all()
        since = log.length.copy()
        for k in range(2):
            for entry in rng.integers(-900, 900, (int(rng.integers(0, log.per_scan + 1)), 2)):
                log.cells[k, log.length[k]], log.increments[k, log.length[k]] = entry
                log.length[k] += 1
                written[k].append(tuple(entry.tolist()))
        assert log.end().tolist() == [len(entries) for entries in written]
        new = [(k, *e) for k in range(2) for e in written[k][int(log.dropped[k] + since[k]) :]]
        assert log.entries_from(since).tolist() == [list(row) for row in new]
        for k in range(2):
            kept = np.column_stack((log.cells[k], log.increments[k]))[: log.length[k]]
            assert [tuple(e) for e in kept.tolist()] == written[k][int(log.dropped[k]) :]
        oldest = np.maximum(oldest, (log.end() * rng.choice([0.0, 0.5, 1.0], 2)).astype(np.int64))
