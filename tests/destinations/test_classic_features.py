"""Features of frontiers against independent libraries and plain definitions."""

from __future__ import annotations

import math

import networkx as nx
import numpy as np
import pytest
from footprint_oracle import entry_of, room_of
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy import ndimage

from swarmscout.core.enums import FREE, OCCUPIED, UNKNOWN
from swarmscout.destinations.view import LeaderView
from swarmscout.testing import leader_view, situations

Cell = tuple[int, int]


CELL_M, RADIUS_M, DEPTH_M = 0.5, 0.15, 0.05


def some_labels(rng: np.random.Generator, walls: float, unknown: float) -> NDArray[np.uint8]:
    """A small map drawn cell by cell, with one frontier at least."""
    drawn = rng.random((12, 15))
    labels = np.full(drawn.shape, FREE, dtype=np.uint8)
    labels[drawn < walls] = OCCUPIED
    labels[drawn > 1.0 - unknown] = UNKNOWN
    labels[2, 2], labels[2, 3] = FREE, UNKNOWN
    return labels


def some_view(seed: int, walls: float = 0.2, unknown: float = 0.2) -> LeaderView:
    rng = np.random.default_rng(seed)
    labels = some_labels(rng, walls, unknown)
    spots = [(int(rng.integers(12)), int(rng.integers(15))) for _ in range(4)]
    others = ((spots[1], None), (spots[2], spots[3]))
    return leader_view(labels, spots[0], others=others, seed=seed)


def walks(labels: NDArray[np.uint8], starts: set[Cell]) -> dict[Cell, float]:
    """Shortest ways in mm, by NetworkX: over free cells with room, and no corner is cut."""
    tight, _ = room_of(labels == OCCUPIED, CELL_M, RADIUS_M, DEPTH_M)
    graph = nx.DiGraph()
    graph.add_nodes_from(starts)
    rows, columns = labels.shape
    for row in range(rows):
        for col in range(columns):
            if labels[row, col] != FREE and (row, col) not in starts:
                continue
            for d_row in (-1, 0, 1):
                for d_col in (-1, 0, 1):
                    r, c = row + d_row, col + d_col
                    if not (0 <= r < rows and 0 <= c < columns) or labels[r, c] != FREE:
                        continue
                    both = d_row != 0 and d_col != 0
                    if tight[r, c] or (both and (tight[row, c] or tight[r, col])):
                        continue
                    if d_row or d_col:
                        graph.add_edge((row, col), (r, c), weight=707 if both else 500)
    lengths: dict[Cell, float] = nx.multi_source_dijkstra_path_length(graph, starts)
    return lengths


@settings(max_examples=40, deadline=None, derandomize=True, database=None)
@given(seed=st.integers(0, 10**6), walls=st.floats(0.0, 0.5), unknown=st.floats(0.02, 0.6))
def test_walks_are_networkx_shortest(seed: int, walls: float, unknown: float) -> None:
    view = some_view(seed, walls, unknown)
    cells = [tuple(cell) for cell in view.frontiers.tolist()]
    room = room_of(view.labels == OCCUPIED, CELL_M, RADIUS_M, DEPTH_M)
    reach = 3.0 * RADIUS_M / CELL_M + 2.0
    cells = [entry_of(*room, view.labels, cell, reach) for cell in cells]
    own = walks(view.labels, {view.frame.cell_of(*view.position_m)})
    assert view.path_length_m.tolist() == [own.get(cell, math.inf) / 1000.0 for cell in cells]
    places = {view.frame.cell_of(x, y) for x, y in view.others.positions_m.tolist()}
    theirs = walks(view.labels, places)
    assert view.others_path_length_m.tolist() == [
        theirs.get(cell, math.inf) / 1000.0 for cell in cells
    ]


@pytest.mark.parametrize("number", range(10))
def test_features_follow_their_definitions(number: int) -> None:
    check_features(list(situations(number))[number].view)


@settings(max_examples=20, deadline=None, derandomize=True, database=None)
@given(seed=st.integers(0, 10**6), unknown=st.floats(0.02, 0.6))
def test_features_follow_their_definitions_anywhere(seed: int, unknown: float) -> None:
    check_features(some_view(seed, 0.2, unknown))


def check_features(view: LeaderView) -> None:
    labels, cell_m = view.labels, view.frame.cell_m
    is_frontier = np.zeros(labels.shape, dtype=np.bool_)
    is_frontier[tuple(view.frontiers.T)] = True
    regions, _ = ndimage.label(is_frontier, np.ones((3, 3)))
    theirs = regions[tuple(view.frontiers.T)].tolist()
    pairs = set(zip(theirs, view.clusters.tolist(), strict=True))
    assert len(pairs) == len(set(theirs)) == len(set(view.clusters.tolist()))
    assert set(view.clusters.tolist()) == set(range(len(pairs)))
    rows, columns = np.indices(labels.shape)
    kinds = {
        "unknown": labels == UNKNOWN,
        "free": labels == FREE,
        "occupied": labels == OCCUPIED,
        "frontier": is_frontier,
    }
    for f, (row, col) in enumerate(view.frontiers.tolist()):
        counts = view.neighbour_counts((row, col))
        assert counts == (view.frontier_neighbours[f], view.obstacle_neighbours[f])
        for reach_m in (0.5, 1.0, 2.3):
            disc = np.hypot(rows - row, columns - col) * cell_m <= reach_m
            for kind, cells in kinds.items():
                expected = np.count_nonzero(disc & cells) * cell_m**2
                assert view.area_m2(kind, reach_m)[f] == pytest.approx(expected)
    assert view.unknown_m2(1.0).tolist() == view.area_m2("unknown", 1.0).tolist()


def test_turns_are_angles_to_the_way() -> None:
    labels = np.full((9, 30), OCCUPIED, dtype=np.uint8)
    labels[4, 1:29] = FREE
    labels[4, 0] = labels[4, 29] = UNKNOWN
    view = leader_view(labels, (4, 10))
    # The leader looks along +x; the ways lead west and east.
    assert view.frontiers.tolist() == [[4, 1], [4, 28]]
    assert view.turns_rad.tolist() == pytest.approx([math.pi, 0.0])
    assert view.path_length_m.tolist() == [4.5, 9.0]
    assert view.members_heading_rad.tolist() == [0.0]


def test_features_are_read_only() -> None:
    view = some_view(3)
    for name in (
        "path_length_m",
        "others_path_length_m",
        "turns_rad",
        "clusters",
        "frontier_neighbours",
    ):
        with pytest.raises(ValueError, match="read-only"):
            getattr(view, name)[0] = 0
    with pytest.raises(ValueError, match="read-only"):
        view.unknown_m2(1.0)[0] = 0.0
