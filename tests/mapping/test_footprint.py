"""Room for a body on a map equals a distance transform from scratch, after any changes."""

from __future__ import annotations

import math

import numpy as np
from footprint_oracle import entry_of, room_of
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from swarmscout.core.enums import OCCUPIED
from swarmscout.core.grid import GridFrame
from swarmscout.mapping.footprint import BESIDE, TIGHT, Footprint
from swarmscout.mapping.log_odds import InverseSensorModel, log_odds_of
from swarmscout.mapping.occupancy import CLOSED, OccupancyGrids

DEPTH_M = 0.05
MODEL = InverseSensorModel(
    -405, 847, log_odds_of(0.03), log_odds_of(0.97), log_odds_of(0.35), log_odds_of(0.65), DEPTH_M
)
bodies = st.sampled_from([0.05, 0.1, 0.15, 0.3, 0.5])
cells_m = st.sampled_from([0.05, 0.1, 0.19, 0.25, 0.5, 1.0])
shapes = st.tuples(st.integers(1, 24), st.integers(1, 24))
seeds = st.integers(0, 2**32 - 1)


def changed(
    grids: OccupancyGrids, rng: np.random.Generator, steps: int, share: float = 0.3
) -> None:
    """Let cells become occupied, free and unknown at random, many times."""
    zero = np.zeros(1, dtype=np.int64)
    for _ in range(steps):
        n = max(1, int(share * grids.frame.size))
        cells = rng.choice(grids.frame.size, n, replace=False)
        wanted = rng.choice([-2000, 0, 2000], n, p=[0.6, 0.2, 0.2])
        grids.apply(0, cells[None], (wanted - grids.evidence[0, cells])[None], zero, zero + n)


def bits(grids: OccupancyGrids, bit: int) -> NDArray[np.bool_]:
    status = grids.status[0, : grids.frame.size].reshape(grids.frame.shape)
    return np.asarray(status & bit != 0)


@settings(max_examples=150)
@given(seeds, shapes, bodies, cells_m, st.integers(1, 6), st.booleans())
def test_room_for_a_body_is_that_of_a_distance_transform(
    seed: int, shape: tuple[int, int], radius_m: float, cell_m: float, steps: int, clear: bool
) -> None:
    footprint = Footprint.of_disc(radius_m, cell_m, DEPTH_M, keeps_clear=clear)
    grids = OccupancyGrids(GridFrame(0.0, 0.0, cell_m, *shape), 1, MODEL, 8, footprint)
    rng = np.random.default_rng(seed)
    for _ in range(steps):
        before = bits(grids, TIGHT)
        changed(grids, rng, 1)
        occupied = grids.view(0).labels == OCCUPIED
        tight, beside = room_of(occupied, cell_m, radius_m, DEPTH_M)
        assert np.array_equal(bits(grids, TIGHT), tight)
        assert np.array_equal(bits(grids, BESIDE), beside if clear else tight)
        if (tight & ~before).any():
            assert grids.counts[0, CLOSED] > 0
        # Routes look at rows within the bounds only.
        rows = np.flatnonzero((tight | beside).any(axis=1)) if clear else np.zeros(0)
        if len(rows):
            assert grids.bounds[0, 0] <= rows[0] <= rows[-1] <= grids.bounds[0, 1]
    assert np.array_equal(grids.fork(0).status[0], grids.status[0])


@settings(max_examples=40)
@given(seeds, st.tuples(st.integers(1, 16), st.integers(1, 16)), bodies, cells_m)
def test_a_goal_stands_for_the_nearest_place_with_room(
    seed: int, shape: tuple[int, int], radius_m: float, cell_m: float
) -> None:
    footprint = Footprint.of_disc(radius_m, cell_m, DEPTH_M)
    grids = OccupancyGrids(GridFrame(0.0, 0.0, cell_m, *shape), 1, MODEL, 8, footprint)
    changed(grids, np.random.default_rng(seed), 1, 0.1)
    labels = grids.view(0).labels
    room = room_of(labels == OCCUPIED, cell_m, radius_m, DEPTH_M)
    every = np.arange(grids.frame.size)
    entries = grids.entries(0, every)
    for flat, entry in zip(every.tolist(), entries.tolist(), strict=True):
        wanted = entry_of(*room, labels, grids.frame.unflat(flat), footprint.entry_cells)
        assert (grids.frame.unflat(entry) if entry >= 0 else None) == wanted
    exits = grids.exits(0, every)
    free = ~room[0].ravel()
    assert np.array_equal(exits[free], every[free])


def open_rows(width_m: float, offset_m: float, cell_m: float, radius_m: float) -> int:
    """Rows with room for a body in a long corridor whose walls were measured without noise."""
    rows = math.ceil((width_m + 2.0) / cell_m)
    frame = GridFrame(0.0, 0.0, cell_m, rows, 41)
    footprint = Footprint.of_disc(radius_m, cell_m, DEPTH_M)
    grids = OccupancyGrids(frame, 1, MODEL, 8, footprint)
    low_m = 0.8 + offset_m
    for wall_m in (low_m - DEPTH_M, low_m + width_m + DEPTH_M):
        cells = math.floor(wall_m / cell_m) * frame.columns + np.arange(frame.columns)
        zero = np.zeros(1, dtype=np.int64)
        grids.apply(0, cells[None], np.full((1, len(cells)), 2000), zero, zero + len(cells))
    between = bits(grids, TIGHT)[:, 20]
    first, last = np.flatnonzero(grids.view(0).labels[:, 20] == OCCUPIED)[[0, -1]]
    return int((~between[first : last + 1]).sum())


@settings(max_examples=200)
@given(
    radius_m=st.floats(0.1, 0.5),
    share=st.floats(0.05, 1.0),
    offset=st.floats(0.0, 1.0),
)
def test_a_corridor_a_cell_wider_than_the_body_is_open_at_every_offset(
    radius_m: float, share: float, offset: float
) -> None:
    # Cells up to the body's diameter, and what an occupied cell lies behind the surface.
    cell_m = max(0.05, share * 2.0 * (radius_m + DEPTH_M))
    assert open_rows(2.0 * radius_m + cell_m + 1e-6, offset * cell_m, cell_m, radius_m) >= 1


@settings(max_examples=100)
@given(radius_m=st.floats(0.1, 0.5), share=st.floats(0.1, 0.9), offset=st.floats(0.0, 1.0))
def test_a_corridor_that_is_clearly_too_narrow_is_closed(
    radius_m: float, share: float, offset: float
) -> None:
    cell_m = max(0.05, share * radius_m)
    width_m = 2.0 * (radius_m - cell_m) - 1e-6
    if width_m > 0.0:
        assert open_rows(width_m, offset * cell_m, cell_m, radius_m) == 0
