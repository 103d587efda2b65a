"""The nearest frontier is NetworkX's nearest; any frontier is as likely as the other."""

from __future__ import annotations

import dataclasses
import math
from typing import Any

import networkx as nx
import numpy as np
import pytest
from footprint_oracle import entry_of, room_of
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import stats
from test_classic_features import some_labels

from swarmscout.core.enums import FREE, OCCUPIED, UNKNOWN
from swarmscout.destinations.nearest import Nearest
from swarmscout.destinations.random import Random
from swarmscout.destinations.selector import Choice
from swarmscout.destinations.view import LeaderView
from swarmscout.mission.mission import Mission
from swarmscout.mission.scenario import Scenario
from swarmscout.testing import leader_view, situations, small_world

RADIUS_M, DEPTH_M = 0.15, 0.05


def route_graph(view: LeaderView, start: tuple[int, int]) -> nx.Graph:
    """8 neighbours, no cutting of corners; cost is length × mean of (1 + p), near walls more."""
    labels, odds = view.labels, view.log_odds
    rows, columns = labels.shape
    tight, beside = room_of(labels == OCCUPIED, view.frame.cell_m, RADIUS_M, DEPTH_M)

    def price(cell: tuple[int, int]) -> int:
        if tight[cell]:
            return 2000  # Only where the leader stands.
        p = round(1000.0 / (1.0 + math.exp(-int(odds[cell]) / 1000.0)))
        return 1000 + p + 1000 * int(beside[cell])

    def passable(cell: tuple[int, int]) -> bool:
        return not tight[cell]

    graph = nx.Graph()
    graph.add_node(start)
    cell_mm = 1000.0 * view.frame.cell_m
    for row in range(rows):
        for col in range(columns):
            here = (row, col)
            if not passable(here) and here != start:
                continue
            for there in ((row, col + 1), (row + 1, col - 1), (row + 1, col), (row + 1, col + 1)):
                if not (there[0] < rows and 0 <= there[1] < columns):
                    continue
                if not passable(there) and there != start:
                    continue
                length = round(cell_mm)
                if there[0] != row and there[1] != col:
                    if not (passable((row, there[1])) and passable((there[0], col))):
                        continue
                    length = round(cell_mm * math.sqrt(2.0))
                graph.add_edge(here, there, weight=length * (price(here) + price(there)))
    return graph


def check_against_networkx(view: LeaderView) -> None:
    start = view.frame.cell_of(*view.position_m)
    lengths = nx.single_source_dijkstra_path_length(route_graph(view, start), start)
    cells = [tuple(cell) for cell in view.frontiers.tolist()]
    room = room_of(view.labels == OCCUPIED, view.frame.cell_m, RADIUS_M, DEPTH_M)
    reach = 3.0 * RADIUS_M / view.frame.cell_m + 2.0
    entries = [entry_of(*room, view.labels, cell, reach) for cell in cells]
    # Wherever the leader is, it is there already.
    expected = [
        0.0 if cell == start else lengths.get(entry, math.inf) / 2e6
        for cell, entry in zip(cells, entries, strict=True)
    ]
    fresh = dataclasses.replace(view)
    assert fresh.route_costs().tolist() == expected
    choice = Nearest().choose(dataclasses.replace(view), None)
    if math.isinf(min(expected)):
        assert choice.cell == cells[int(np.argmin(view.distances_m))]
    else:
        assert choice.cell == cells[expected.index(min(expected))]


@settings(max_examples=30, deadline=None, derandomize=True, database=None)
@given(seed=st.integers(0, 10**6), walls=st.floats(0.0, 0.5), unknown=st.floats(0.02, 0.6))
def test_nearest_is_the_nearest_by_dijkstra(seed: int, walls: float, unknown: float) -> None:
    rng = np.random.default_rng(seed)
    labels = some_labels(rng, walls, unknown)
    leader = (int(rng.integers(12)), int(rng.integers(15)))
    check_against_networkx(leader_view(labels, leader, seed=seed))


@pytest.mark.parametrize("number", range(10))
def test_nearest_in_rare_situations(number: int) -> None:
    check_against_networkx(list(situations(number))[number].view)


def test_nearest_in_a_mission() -> None:
    class Checked:
        seen = 0

        def choose(self, view: LeaderView, memory: Any) -> Choice:
            if view.step % 5 == 0:
                check_against_networkx(view)
                self.seen += 1
            return Nearest().choose(view, memory)

    # With batteries, cells round stations are dearer, which the oracle does not know.
    scenario = Scenario(robots=6, steps=120, seed=1, battery={"enabled": False})
    mission = Mission(scenario, world=small_world(1))
    checked = Checked()
    mission.destinations.selector = checked
    mission.run()
    assert checked.seen > 3


def test_every_frontier_is_equally_likely() -> None:
    labels = np.full((9, 9), UNKNOWN, dtype=np.uint8)
    labels[2:7, 2:7] = FREE
    view = leader_view(labels, (4, 4))
    cells = [tuple(cell) for cell in view.frontiers.tolist()]
    assert len(cells) == 16
    for vary in ("step", "robot", "_seed"):
        counts = dict.fromkeys(cells, 0)
        for value in range(1600):
            counts[Random().choose(dataclasses.replace(view, **{vary: value}), None).cell] += 1
        assert stats.chisquare(list(counts.values())).pvalue > 0.01
