"""Marching cubes in tiles and decimation, on shapes whose size is known."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from swarmscout.worlds.meshes import surfacing
from swarmscout.worlds.meshes.decimation import TOLERANCE_M, decimated
from swarmscout.worlds.meshes.surfacing import largest_part, surface_of


class Balls:
    """Balls of open space in rock, on a grid with a step of 1."""

    shape = (90, 80)
    levels_m = np.arange(40.0)

    def __init__(self, *balls: tuple[float, float, float, float]) -> None:
        self.balls = balls

    def is_solid(self, rows: slice, columns: slice) -> bool:
        return False

    def values(self, rows: slice, columns: slice):
        row, col, level = np.meshgrid(
            np.arange(rows.start, rows.stop), np.arange(columns.start, columns.stop),
            self.levels_m, indexing="ij",
        )  # fmt: skip
        inside = [
            radius - np.sqrt((row - r) ** 2 + (col - c) ** 2 + (level - z) ** 2)
            for r, c, z, radius in self.balls
        ]
        deepest = np.max(inside, axis=0)
        return np.where(np.abs(deepest) < 1e-3, 1e-3, deepest).astype(np.float32)

    def vertices_m(self, at):
        return at[:, [1, 0, 2]]


def volume(surface) -> float:
    one, two, three = np.moveaxis(surface[0][surface[1]], 1, 0)
    return float((one * np.cross(two, three)).sum() / 6.0)


def edge_counts(surface):
    ends = np.sort(np.concatenate([surface[1][:, [k, (k + 1) % 3]] for k in range(3)]), axis=1)
    return np.unique(ends, axis=0, return_counts=True)[1]


@given(
    st.floats(20.0, 70.0), st.floats(20.0, 60.0), st.floats(18.0, 22.0), st.floats(3.0, 16.0),
    st.sampled_from([7, 16, 64, 500]),
)  # fmt: skip
@settings(max_examples=25)
def test_tiles_leave_no_seam(row, col, level, radius, tile):
    field = Balls((row, col, level, radius))
    whole = surface_of(field)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(surfacing, "_TILE", tile)
        tiled = surface_of(field)
    assert (edge_counts(tiled) == 2).all()
    assert len(np.unique(tiled[0], axis=0)) == len(tiled[0]) == len(whole[0])
    assert len(tiled[1]) == len(whole[1])
    # A ball of chords is a little smaller than the ball.
    assert abs(volume(tiled)) == pytest.approx(4.0 / 3.0 * math.pi * radius**3, rel=0.12)
    # Vertices lie on the ball, and a sphere's Euler characteristic is 2.
    away = np.sqrt(((tiled[0] - (col, row, level)) ** 2).sum(axis=1))
    np.testing.assert_allclose(away, radius, atol=0.1)
    assert len(tiled[0]) - len(edge_counts(tiled)) + len(tiled[1]) == 2


@given(st.floats(8.0, 17.0), st.floats(0.0, 1.0))
@settings(max_examples=15)
def test_decimation_keeps_the_surface_where_it_is(radius, shift):
    middle = np.array([40.0 + shift, 45.0, 20.0])
    ball = surface_of(Balls((45.0, 40.0 + shift, 20.0, radius)))
    fewer = decimated(ball)
    assert len(fewer[1]) < 0.9 * len(ball[1])
    assert (edge_counts(fewer) == 2).all()
    assert volume(fewer) == pytest.approx(volume(ball), rel=0.01)
    before = np.sqrt(((ball[0] - middle) ** 2).sum(axis=1))
    # Vertices may move on the planes of the triangles that they stand for, hence a little out.
    after = np.sqrt(((fewer[0] - middle) ** 2).sum(axis=1))
    assert after.min() >= before.min() - 3.0 * TOLERANCE_M
    assert after.max() <= before.max() + 3.0 * TOLERANCE_M


def test_an_open_border_stays_as_it_is():
    ball = surface_of(Balls((45.0, 40.0, 39.5, 12.0)))
    border = (edge_counts(ball) == 1).sum()
    assert border > 20
    fewer = decimated(ball)
    assert (edge_counts(fewer) == 1).sum() == border
    top = ball[0][:, 2].max()
    rim = {tuple(place) for place in ball[0][ball[0][:, 2] == top].tolist()}
    assert {tuple(place) for place in fewer[0][fewer[0][:, 2] == top].tolist()} == rim


def test_bubbles_in_the_rock_are_left_out():
    both = surface_of(Balls((20.0, 20.0, 20.0, 6.0), (70.0, 60.0, 20.0, 10.0)))
    largest = largest_part(both)
    assert largest[0][:, 1].min() > 55.0
    assert (edge_counts(largest) == 2).all()
    assert len(largest[1]) < len(both[1])


def test_two_fans_that_touch_in_a_point_are_taken_apart():
    one = surface_of(Balls((45.0, 40.0, 20.0, 5.0)))
    shifted = one[0] + np.array([0.0, 0.0, np.ptp(one[0][:, 2])])
    # The lowest vertex of the upper ball becomes the highest of the lower one.
    low, high = int(np.argmin(shifted[:, 2])), int(np.argmax(one[0][:, 2]))
    faces = one[1] + len(one[0])
    faces[faces == low + len(one[0])] = high
    touching = np.concatenate((one[0], shifted)), np.concatenate((one[1], faces))
    apart = decimated(touching)
    assert len(apart[0]) - len(edge_counts(apart)) + len(apart[1]) == 4


def test_nothing_open_gives_no_surface():
    vertices, triangles = largest_part(surface_of(Balls((45.0, 40.0, 20.0, -5.0))))
    assert len(vertices) == len(triangles) == 0
