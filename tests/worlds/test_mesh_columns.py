"""Columns and walls of a mesh against brute force: every line with every triangle."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from mesh_shapes import box, joined, room, sheet, walls

from swarmscout.core.grid import GridFrame
from swarmscout.worlds.meshes.span_heightfield import FACES_AIR, FACES_ROCK, find_spans
from swarmscout.worlds.meshes.tiles import TILE
from swarmscout.worlds.meshes.walls import EAST, NORTH, find_walls

CLEARANCE_M = 0.4
FRAME = GridFrame(0.0, 0.0, 0.5, 14, 17)


def quiet(_: float) -> None:
    pass


def in_cells(vertices: np.ndarray, frame: GridFrame) -> np.ndarray:
    corners = np.array(vertices, dtype=np.float64)
    corners[:, 0] = (corners[:, 0] - frame.origin_x_m) / frame.cell_m - 0.5
    corners[:, 1] = (corners[:, 1] - frame.origin_y_m) / frame.cell_m - 0.5
    return corners


def line_meets(vertices, triangles, x, y):
    """Heights at which the upright line at (x, y) meets triangles, by barycentric coordinates."""
    met = []
    for a, b, c in vertices[triangles]:
        matrix = np.array([[a[0], b[0], c[0]], [a[1], b[1], c[1]], [1.0, 1.0, 1.0]])
        if abs(np.linalg.det(matrix)) < 1e-9:
            continue
        shares = np.linalg.solve(matrix, [x, y, 1.0])
        if (shares >= -1e-9).all():
            met.append(float(shares @ [a[2], b[2], c[2]]))
    return sorted(met)


def expected_spans(vertices, triangles, frame):
    spans = []
    for row in range(frame.rows):
        for col in range(frame.columns):
            met = [*line_meets(vertices, triangles, *frame.centre_of(row, col)), np.inf]
            for low, high in itertools.pairwise(met):
                if high - low >= CLEARANCE_M:
                    spans.append((row * frame.columns + col, low, high))
    return spans


@st.composite
def soups(draw):
    """Up to a dozen triangles anywhere in the frame; corners often on lines between cells."""
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    count = draw(st.integers(1, 12))
    corners = rng.uniform(0.3, 6.5, size=(3 * count, 3))
    if draw(st.booleans()):
        corners = np.round(corners * 4.0) / 4.0
    return corners, np.arange(3 * count).reshape(-1, 3).astype(np.int32)


@given(soups())
@settings(max_examples=25, deadline=None)
def test_spans_are_those_of_brute_force(soup):
    vertices, triangles = soup
    spans = find_spans(in_cells(vertices, FRAME), triangles, FRAME, CLEARANCE_M, quiet)
    found = list(zip(spans.cell, spans.floor_m, spans.ceiling_m, strict=True))
    expected = expected_spans(vertices, triangles, FRAME)
    # A gap of just the clearance, or a line through a corner, may be judged either way.
    unsure = {cell for cell, low, high in expected if abs(high - low - CLEARANCE_M) < 1e-6}
    found = [span for span in found if span[0] not in unsure]
    expected = [span for span in expected if span[0] not in unsure]
    assert [int(cell) for cell, _, _ in found] == [cell for cell, _, _ in expected]
    np.testing.assert_allclose(
        np.array(found)[:, 1:] if found else [],
        np.array(expected)[:, 1:] if expected else [],
        atol=1e-4,
    )


@given(soups())
@settings(max_examples=25, deadline=None)
def test_a_level_line_between_two_centres_through_something_steep_meets_a_wall(soup):
    vertices, triangles = soup
    corners = in_cells(vertices, FRAME)
    found = find_walls(corners, triangles, FRAME, CLEARANCE_M, quiet)
    assert (np.diff(found.key) >= 0).all()
    at = {}
    for key, low, high in zip(found.key, found.bottom_m, found.top_m, strict=True):
        at.setdefault(int(key), []).append((low, high))
    rng = np.random.default_rng(0)
    for _ in range(300):
        row, col = int(rng.integers(0, 13)), int(rng.integers(0, 16))
        direction, z = int(rng.integers(0, 2)), rng.uniform(0.3, 6.5)
        ahead = (0.5, 0.0, 0.0) if direction == EAST else (0.0, 0.5, 0.0)
        origin = np.array([*FRAME.centre_of(row, col), z])
        steep = meets(vertices[triangles], origin, np.array(ahead))
        pieces = at.get(2 * (row * FRAME.columns + col) + direction, [])
        covered = any(low - 1e-4 <= z <= high + 1e-4 for low, high in pieces)
        assert covered or not steep


def meets(corners, origin, ahead):
    """Whether a segment meets a triangle that is steeper than 60° (and not nearly so)."""
    for a, b, c in corners:
        normal = np.cross(b - a, c - a)
        if np.hypot(normal[0], normal[1]) < 1.8 * abs(normal[2]):
            continue
        toward = normal @ ahead
        if abs(toward) < 1e-9:
            continue
        share = normal @ (a - origin) / toward
        if not 0.0 <= share <= 1.0:
            continue
        point = origin + share * ahead
        size = normal @ normal
        inside = [
            np.cross(q - p, point - p) @ normal >= 1e-6 * size for p, q in ((a, b), (b, c), (c, a))
        ]
        if all(inside):
            return True
    return False


def test_what_lies_across_tiles_is_found_once():
    frame = GridFrame(-0.2, -0.2, 0.1, TILE + 60, 2 * TILE + 60)
    vertices, triangles = room(0.1 * frame.columns - 0.5, 0.1 * frame.rows - 0.5, 2.0)
    shares = []
    spans = find_spans(
        in_cells(vertices, frame), triangles.astype(np.int32), frame, CLEARANCE_M, shares.append
    )
    inside = (frame.columns - 5) * (frame.rows - 5)
    assert np.isfinite(spans.ceiling_m).sum() == inside
    assert spans.hit == inside
    assert len(spans.cell) == 2 * inside
    assert (np.diff(spans.cell) >= 0).all()
    assert shares == sorted(shares)
    assert shares[-1] == 1.0


def test_which_way_surfaces_are_wound_is_told():
    frame = GridFrame(0.0, 0.0, 0.5, 10, 10)
    for shape, flag in ((room(4.0, 4.0), FACES_AIR), (box(0, 4, 0, 4, 0, 3), FACES_ROCK)):
        spans = find_spans(
            in_cells(shape[0], frame), shape[1].astype(np.int32), frame, CLEARANCE_M, quiet
        )
        under = np.isfinite(spans.ceiling_m)
        assert set(spans.facing[under]) == {flag}


def test_low_places_are_told():
    frame = GridFrame(0.0, 0.0, 0.5, 10, 10)
    low = joined(sheet(0, 4, 0, 4, 0.0), sheet(0, 2, 0, 4, 0.3), sheet(2, 4, 0, 4, 1.0))
    spans = find_spans(in_cells(low[0], frame), low[1].astype(np.int32), frame, 0.4, quiet)
    assert len(spans.low) == 4 * 8
    assert set(spans.low % 10) == {0, 1, 2, 3}


@pytest.mark.parametrize("direction", [EAST, NORTH])
def test_a_thin_wall_stands_between_two_cells(direction):
    frame = GridFrame(0.0, 0.0, 0.5, 10, 10)
    line = [(1.3, 0.0), (1.3, 4.0)] if direction == EAST else [(0.0, 1.3), (4.0, 1.3)]
    shape = walls(line, 0.0, 2.0)
    found = find_walls(in_cells(shape[0], frame), shape[1].astype(np.int32), frame, 0.4, quiet)
    assert set(found.key % 2) == {direction}
    row, col = np.divmod(found.key // 2, 10)
    # 1.3 m lies between the centres 1.25 and 1.75, in the cell of the first.
    assert set(col if direction == EAST else row) == {2}
    assert set(row if direction == EAST else col) == set(range(8))
    assert found.mine.all()
    assert set(found.bottom_m) == {0.0}
    assert set(found.top_m) == {2.0}
