"""Whatever entries come in whatever order: all that is derived equals its definition."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy.ndimage import binary_dilation

from swarmscout.core.enums import FREE, OCCUPIED, UNKNOWN
from swarmscout.core.grid import GridFrame
from swarmscout.mapping.log_odds import InverseSensorModel, log_odds_of, probability_of
from swarmscout.mapping.occupancy import CLOSED, LABEL_BITS, OccupancyGrids

MODEL = InverseSensorModel(
    free=log_odds_of(0.40),
    occupied=log_odds_of(0.70),
    lowest=log_odds_of(0.03),
    highest=log_odds_of(0.97),
    free_below=log_odds_of(0.35),
    occupied_above=log_odds_of(0.65),
    hit_depth_m=0.05,
)

Integers = NDArray[np.int64]


def label_of(sum_: int) -> int:
    """A cell's label by its definition."""
    probability = min(0.97, max(0.03, 1.0 / (1.0 + math.exp(-sum_ / 1000.0))))
    if abs(probability - 0.35) < 2e-4 or abs(probability - 0.65) < 2e-4:
        # At a threshold, log-odds in whole units decide.
        return FREE if sum_ < -619 else OCCUPIED if sum_ > 619 else UNKNOWN
    return FREE if probability < 0.35 else OCCUPIED if probability > 0.65 else UNKNOWN


def frontiers_of(labels: NDArray[np.int64], neighbours: int) -> set[tuple[int, int]]:
    """Free cells with an unknown neighbour that no two occupied cells hide, cell by cell."""
    rows, columns = labels.shape

    def label(row: int, col: int) -> int:
        return int(labels[row, col]) if 0 <= row < rows and 0 <= col < columns else OCCUPIED

    found = set()
    for row, col in np.ndindex(rows, columns):
        for dr, dc in itertools.product((-1, 0, 1), repeat=2):
            if (dr, dc) == (0, 0) or (neighbours == 4 and dr and dc):
                continue
            hidden = dr and dc and {label(row + dr, col), label(row, col + dc)} == {OCCUPIED}
            if label(row, col) == FREE and label(row + dr, col + dc) == UNKNOWN and not hidden:
                found.add((row, col))
    return found


def dilated_frontiers(labels: NDArray[np.int64], neighbours: int) -> NDArray[np.bool_]:
    """The same definition by SciPy's dilations: what lies in each of the directions."""

    def toward(label: int, down: int, across: int) -> NDArray[np.bool_]:
        one = np.zeros((3, 3), dtype=np.bool_)
        one[1 - down, 1 - across] = True
        return np.asarray(binary_dilation(labels == label, one, border_value=label == OCCUPIED))

    open_to = np.zeros(labels.shape, dtype=np.bool_)
    for down, across in itertools.product((-1, 0, 1), repeat=2):
        if abs(down) + abs(across) == 1:
            open_to |= toward(UNKNOWN, down, across)
        elif down and neighbours == 8:
            walls = toward(OCCUPIED, down, 0) & toward(OCCUPIED, 0, across)
            open_to |= toward(UNKNOWN, down, across) & ~walls
    return open_to & (labels == FREE)


def check_everything(grids: OccupancyGrids, m: int, sums: Integers, neighbours: int) -> None:
    """Assert that map m says what its summed evidence says."""
    frame = grids.frame
    view = grids.view(m)
    labels = np.array([label_of(int(s)) for s in sums]).reshape(frame.shape)
    assert np.array_equal(view.evidence.ravel(), sums)
    assert np.array_equal(view.labels, labels)
    saturated = np.clip(sums, -3476, 3476)
    assert np.array_equal(view.log_odds.ravel(), saturated)
    permille = np.rint(1000.0 / (1.0 + np.exp(-saturated / 1000.0)))
    price = np.where(labels.ravel() == OCCUPIED, -1, permille)
    assert np.array_equal(grids.price[m], price)
    wanted = sorted(frontiers_of(labels, neighbours))
    assert view.frontiers().tolist() == [list(cell) for cell in wanted]
    assert np.argwhere(dilated_frontiers(labels, neighbours)).tolist() == view.frontiers().tolist()
    assert grids.counts[m, 1:].tolist() == [
        (labels == FREE).sum(),
        (labels == OCCUPIED).sum(),
        len(wanted),
    ]
    assert grids.frontier_count(m) == len(wanted)
    # The rest of the last word is nobody's cell.
    assert not grids.status[m, frame.size :].any()
    for row, col in np.ndindex(frame.shape):
        near = [
            (r, c)
            for r in range(max(0, row - 1), min(frame.rows, row + 2))
            for c in range(max(0, col - 1), min(frame.columns, col + 2))
            if (r, c) != (row, col)
        ]
        counts = sum(c in wanted for c in near), sum(labels[c] == OCCUPIED for c in near)
        assert view.neighbour_counts((row, col)) == counts


# Beside the usual increments, some that saturate a cell or bring it exactly to a threshold.
increments = st.one_of(
    st.sampled_from([MODEL.free, MODEL.occupied, -619, -620, 619, 620, -3476, 3476, 1, -1]),
    st.integers(-9000, 9000),
)


@st.composite
def histories(
    draw: st.DrawFn,
) -> tuple[GridFrame, list[list[list[tuple[int, int]]]]]:
    """A grid, and updates: for each of two robots the entries that its log gets."""
    rows, columns = draw(st.tuples(st.integers(1, 9), st.integers(1, 9)))
    entries = st.lists(st.tuples(st.integers(0, rows * columns - 1), increments), max_size=12)
    updates = draw(st.lists(st.lists(entries, min_size=2, max_size=2), min_size=1, max_size=6))
    return GridFrame(0.0, 0.0, 0.5, rows, columns), updates


@settings(max_examples=150)
@given(histories(), st.sampled_from([4, 8]))
def test_incremental_equals_from_scratch(
    history: tuple[GridFrame, list[list[list[tuple[int, int]]]]], neighbours: int
) -> None:
    frame, updates = history
    grids = OccupancyGrids(frame, 2, MODEL, neighbours)
    cells = np.zeros((2, 100), dtype=np.int64)
    added = np.zeros((2, 100), dtype=np.int64)
    length = np.zeros(2, dtype=np.int64)
    sums = np.zeros(frame.size, dtype=np.int64)
    check_everything(grids, 1, sums, neighbours)
    for update in updates:
        low, before = length.copy(), sums.copy()
        was = grids.view(1).labels.ravel()
        for k, entries in enumerate(update):
            for cell, increment in entries:
                cells[k, length[k]], added[k, length[k]] = cell, increment
                length[k] += 1
                sums[cell] += increment
        grids.apply(1, cells, added, low, length)
        touched = grids.touched_count
        check_everything(grids, 1, sums, neighbours)
        named = {cell for entries in update for cell, _ in entries}
        assert set(grids.touched[:touched].tolist()) == named
        assert touched == len(named)
        assert np.array_equal(grids.before[:touched], before[grids.touched[:touched]])
        closed = (grids.view(1).labels.ravel() == OCCUPIED) & (was != OCCUPIED)
        assert grids.counts[1, CLOSED] == closed.sum()
    # The other map heard nothing.
    check_everything(grids, 0, np.zeros(frame.size, dtype=np.int64), neighbours)


@settings(max_examples=40)
@given(
    seed=st.integers(0, 2**32 - 1),
    rows=st.integers(1, 40),
    columns=st.integers(1, 40),
    neighbours=st.sampled_from([4, 8]),
)
def test_frontiers_of_larger_grids_are_sorted_and_complete(
    seed: int, rows: int, columns: int, neighbours: int
) -> None:
    rng = np.random.default_rng(seed)
    frame = GridFrame(0.0, 0.0, 0.5, rows, columns)
    grids = OccupancyGrids(frame, 1, MODEL, neighbours)
    sums = np.zeros(frame.size, dtype=np.int64)
    for _ in range(8):
        n = int(rng.integers(1, frame.size + 1))
        entries = rng.choice(frame.size, n)[None], rng.choice([-405, 847, -700], n)[None]
        np.add.at(sums, entries[0][0], entries[1][0])
        grids.apply(0, *entries, np.zeros(1, dtype=np.int64), np.array([n]))
        labels = np.where(sums < -619, FREE, np.where(sums > 619, OCCUPIED, UNKNOWN))
        labels = labels.reshape(frame.shape)
        wanted = dilated_frontiers(labels, neighbours)
        assert grids.frontiers(0).tolist() == np.flatnonzero(wanted).tolist()


@pytest.mark.parametrize("size", [1, 7, 8, 9, 15, 16, 17])
def test_the_last_cells_of_a_grid_are_not_forgotten(size: int) -> None:
    for rows, columns in ((1, size + 1), (size + 1, 1)):
        grids = OccupancyGrids(GridFrame(0.0, 0.0, 0.5, rows, columns), 1, MODEL, 8)
        zero = np.zeros(1, dtype=np.int64)
        grids.apply(0, np.array([[size]]), np.array([[-5000]]), zero, zero + 1)
        assert grids.frontiers(0).tolist() == [size]
        grids.apply(0, np.array([[size - 1]]), np.array([[-5000]]), zero, zero + 1)
        known = size - 1 if size > 1 else None
        assert grids.frontiers(0).tolist() == ([known] if known is not None else [])


def test_saturation_happens_when_reading_and_not_when_adding() -> None:
    grids = OccupancyGrids(GridFrame(0.0, 0.0, 0.5, 1, 1), 1, MODEL, 8)
    zero = np.zeros(1, dtype=np.int64)
    for increment, label, log_odds in (
        (-9000, FREE, -3476), (9000, UNKNOWN, 0), (9000, OCCUPIED, 3476), (-8381, UNKNOWN, 619),
        (1, OCCUPIED, 620), (-1239, UNKNOWN, -619), (-1, FREE, -620),
    ):  # fmt: skip
        grids.apply(0, np.array([[0]]), np.array([[increment]]), zero, zero + 1)
        assert grids.status[0, 0] & LABEL_BITS == label
        assert grids.view(0).log_odds[0, 0] == log_odds


def test_views_cannot_change_the_map() -> None:
    grids = OccupancyGrids(GridFrame(0.0, 0.0, 0.5, 2, 2), 1, MODEL, 8)
    view = grids.view(0)
    with pytest.raises(ValueError, match="read-only"):
        view.evidence[0, 0] = 1
    view.labels[0, 0] = OCCUPIED
    view.log_odds[0, 0] = 77
    assert not grids.status.any()
    assert not grids.evidence.any()


@given(st.floats(0.001, 0.999))
def test_log_odds_and_probability_are_inverse(probability: float) -> None:
    assert probability_of(log_odds_of(probability)) == pytest.approx(probability, abs=2e-4)
    assert log_odds_of(1.0 - probability) == -log_odds_of(probability)
