"""Conversions between cells and metres are inverse to each other and round down."""

from __future__ import annotations

from fractions import Fraction
from math import floor

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from swarmscout.core.grid import GridFrame

lengths = st.floats(-200.0, 200.0, allow_nan=False)
edges = st.sampled_from([0.03, 0.05, 0.1, 0.25, 0.5, 1.0, 7.3])
frames = st.builds(GridFrame, lengths, lengths, edges, st.integers(1, 60), st.integers(1, 60))


@given(frames, st.data())
def test_a_cells_centre_lies_in_that_cell(frame: GridFrame, data: st.DataObject) -> None:
    row = data.draw(st.integers(-5, frame.rows + 5))
    col = data.draw(st.integers(-5, frame.columns + 5))
    x, y = frame.centre_of(row, col)
    assert frame.cell_of(x, y) == (row, col)
    assert frame.cells_of([x, y]).tolist() == [row, col]
    assert frame.centres_of([row, col]).tolist() == [x, y]
    inside = 0 <= row < frame.rows and 0 <= col < frame.columns
    assert frame.contains(row, col) == inside


@given(frames, lengths, lengths)
def test_a_point_lies_between_the_borders_of_its_cell(frame: GridFrame, x: float, y: float) -> None:
    row, col = frame.cell_of(x, y)
    for value, origin, index in ((x, frame.origin_x_m, col), (y, frame.origin_y_m, row)):
        # Exact arithmetic; a point within rounding of a border may count to either side.
        cells = (Fraction(value) - Fraction(origin)) / Fraction(frame.cell_m)
        assert index - Fraction(1, 10**9) <= cells <= index + 1 + Fraction(1, 10**9)


@pytest.mark.parametrize(("value", "index"), [(-0.01, -1), (0.0, 0), (0.49, 0), (0.5, 1), (-1, -2)])
def test_cells_round_down_on_both_sides_of_zero(value: float, index: int) -> None:
    frame = GridFrame(0.0, 0.0, 0.5, 4, 4)
    assert frame.cell_of(value, 0.1) == (0, index)
    assert frame.cell_of(0.1, value) == (index, 0)
    assert frame.cells_of([[value, 0.1], [0.1, value]]).tolist() == [[0, index], [index, 0]]


@given(frames, st.integers(0, 2**32 - 1))
def test_many_points_convert_like_one(frame: GridFrame, seed: int) -> None:
    points = np.random.default_rng(seed).uniform(-250.0, 250.0, (3, 4, 2))
    cells = frame.cells_of(points)
    assert cells.shape == points.shape
    for point, cell in zip(points.reshape(-1, 2), cells.reshape(-1, 2), strict=True):
        assert frame.cell_of(*point) == tuple(cell)
    centres = frame.centres_of(cells)
    for cell, centre in zip(cells.reshape(-1, 2), centres.reshape(-1, 2), strict=True):
        assert frame.centre_of(*cell) == tuple(centre)


@given(frames)
def test_flat_indices_number_all_cells_row_by_row(frame: GridFrame) -> None:
    flat = np.arange(frame.size)
    cells = frame.unflat_many(flat)
    assert [frame.unflat(int(f)) for f in flat] == [tuple(cell) for cell in cells.tolist()]
    assert [frame.flat(row, col) for row, col in cells.tolist()] == flat.tolist()
    assert np.array_equal(cells, np.argwhere(np.ones(frame.shape)))


@given(frames)
def test_covering_leaves_one_cell_on_each_side(frame: GridFrame) -> None:
    for cell_m in (0.1, 0.5, 3.0):
        cover = GridFrame.covering(frame.extent, cell_m)
        left, right, bottom, top = frame.extent
        around = cover.extent
        for low, high, cover_low, cover_high in (
            (left, right, around[0], around[1]),
            (bottom, top, around[2], around[3]),
        ):
            assert cover_low == pytest.approx(low - cell_m)
            # At least a cell to spare (but for rounding), and less than two.
            assert 1.0 - 2e-6 <= (cover_high - high) / cell_m < 2.0 + 2e-6
        for x in (left, right - 1e-6):
            for y in (bottom, top - 1e-6):
                assert cover.contains(*cover.cell_of(x, y))


def test_covering_ignores_a_sliver_that_rounding_leaves() -> None:
    # 3 × 0.1 is a little more than 0.3.
    assert GridFrame.covering((0.0, 3 * 0.1, 0.0, 0.3), 0.1).shape == (5, 5)
    assert GridFrame.covering((0.0, 0.31, 0.0, 0.3), 0.1).shape == (5, 6)


def test_extent_is_in_the_order_that_imshow_takes() -> None:
    frame = GridFrame(1.0, -2.0, 0.5, rows=4, columns=6)
    assert frame.extent == (1.0, 4.0, -2.0, 0.0)
    assert frame.shape == (4, 6)
    assert frame.size == 24
    assert floor((frame.extent[1] - frame.extent[0]) / frame.cell_m) == frame.columns
