"""The classic rules against brute force and their formulas on small maps."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from swarmscout.core.enums import FREE, OCCUPIED, UNKNOWN
from swarmscout.destinations.hungarian import Hungarian
from swarmscout.destinations.information_gain import InformationGain
from swarmscout.destinations.llm_like import LlmLike
from swarmscout.destinations.minpos import MinPos
from swarmscout.destinations.nearest_euclidean import NearestEuclidean
from swarmscout.destinations.path_lengths import ways_m
from swarmscout.destinations.potential import Potential
from swarmscout.destinations.quantile_local import QuantileLocal
from swarmscout.destinations.registry import RECOMMENDED, make_selector, selectors
from swarmscout.destinations.utility import Utility
from swarmscout.destinations.view import LeaderView
from swarmscout.destinations.voronoi import Voronoi
from swarmscout.testing import check_selector, leader_view

Cell = tuple[int, int]
seeds = settings(max_examples=40, deadline=None, derandomize=True, database=None)


def hall(seed: int, teams: int, *, holes: int = 5) -> LeaderView:
    """A free hall with walls round it, a few unknown cells, and teams of one in it."""
    rng = np.random.default_rng(seed)
    labels = np.full((22, 26), OCCUPIED, dtype=np.uint8)
    labels[1:-1, 1:-1] = FREE
    for _ in range(holes):
        labels[int(rng.integers(1, 21)), int(rng.integers(1, 25))] = UNKNOWN
    free = np.argwhere(labels == FREE)
    spots: list[Cell] = [(int(r), int(c)) for r, c in rng.permutation(free)[: 2 * teams]]
    others = tuple(
        (spots[2 * t], spots[2 * t + 1] if rng.random() < 0.8 else None) for t in range(1, teams)
    )
    return leader_view(labels, spots[0], others=others, seed=seed)


def by_cluster(view: LeaderView) -> tuple[NDArray[np.float64], list[list[int]]]:
    """[teams, clusters] straight distances in m, the own team first; and the clusters' members."""
    groups: list[list[int]] = [[] for _ in range(int(view.clusters.max()) + 1)]
    for f, cluster in enumerate(view.clusters.tolist()):
        groups[cluster].append(f)
    places = [view.position_m, *map(tuple, view.others.positions_m.tolist())]
    distances = np.array(
        [
            [min(math.dist(place, view.frontiers_m[f]) for f in group) for group in groups]
            for place in places
        ]
    )
    return distances, groups


def index_of(view: LeaderView, cell: Cell) -> int:
    return view.frontiers.tolist().index(list(cell))


@pytest.mark.parametrize("name", list(selectors()))
def test_every_selector_is_sound(name: str) -> None:
    report = check_selector(name, missions=1)
    assert report.answers > 10


def test_every_selector_has_one_line_and_its_source() -> None:
    lines = selectors()
    assert RECOMMENDED in lines
    for name, line in lines.items():
        assert 10 < len(line) <= 100, name
        assert line.endswith("."), name
        if name != "random":
            assert "Source:" in str(type(make_selector(name)).__doc__), name


@seeds
@given(seed=st.integers(0, 10**6), teams=st.integers(1, 6), holes=st.integers(1, 7))
def test_minpos_takes_the_lowest_rank(seed: int, teams: int, holes: int) -> None:
    view = hall(seed, teams, holes=holes)
    distances, groups = by_cluster(view)
    candidates = []
    for cluster, group in enumerate(groups):
        rank = sum(distances[t, cluster] < distances[0, cluster] for t in range(1, teams))
        candidates += [(int(rank), float(ways_m(view)[f]), f) for f in group]
    chosen = index_of(view, MinPos().choose(view, None).cell)
    rank, way, _ = next(c for c in candidates if c[2] == chosen)
    assert (rank, way) == min(candidates)[:2]


@seeds
@given(seed=st.integers(0, 10**6), teams=st.integers(1, 4), holes=st.integers(1, 5))
def test_hungarian_is_part_of_a_cheapest_assignment(seed: int, teams: int, holes: int) -> None:
    view = hall(seed, teams, holes=holes)
    distances, groups = by_cluster(view)
    n = min(teams, len(groups))
    costs = {}
    for which in itertools.permutations(range(teams), n):
        for to in itertools.permutations(range(len(groups)), n):
            pairs = dict(zip(which, to, strict=True))
            cost = sum(distances[team, cluster] for team, cluster in pairs.items())
            own = pairs.get(0)
            costs[own] = min(costs.get(own, math.inf), cost)
    best = [own for own, cost in costs.items() if cost <= min(costs.values()) + 1e-9]
    choice = Hungarian().choose(view, None)
    chosen = index_of(view, choice.cell)
    if "none left" in choice.reason:
        assert None in best
        group = list(range(len(view.frontiers)))
    else:
        assert int(view.clusters[chosen]) in best
        group = groups[view.clusters[chosen]]
    assert ways_m(view)[chosen] == min(ways_m(view)[f] for f in group)


def test_hungarian_gives_no_two_teams_the_same() -> None:
    labels = np.full((22, 26), OCCUPIED, dtype=np.uint8)
    labels[1:-1, 1:-1] = FREE
    for row, col in ((3, 3), (3, 20), (17, 12), (18, 3)):
        labels[row, col] = UNKNOWN
    spots = [(10, 10), (10, 12), (12, 11), (9, 14)]
    taken = []
    for k in range(4):
        others = tuple((spot, None) for spot in spots if spot != spots[k])
        view = leader_view(labels, spots[k], others=others)
        chosen = index_of(view, Hungarian().choose(view, None).cell)
        taken.append(int(view.clusters[chosen]))
    assert sorted(taken) == [0, 1, 2, 3]


@seeds
@given(seed=st.integers(0, 10**6), teams=st.integers(1, 5))
def test_voronoi_prefers_its_own_cell(seed: int, teams: int) -> None:
    view = hall(seed, teams)
    chosen = index_of(view, Voronoi().choose(view, None).cell)
    ways, everywhere = ways_m(view), range(len(view.frontiers))
    nearer = [f for f in everywhere if view.path_length_m[f] < view.others_path_length_m[f]]
    # Where another team is just as near, either may have it.
    equal = [f for f in everywhere if view.path_length_m[f] == view.others_path_length_m[f]]
    own = nearer + [f for f in equal if view.in_own_voronoi_cell[f]]
    assert sorted(own) == np.flatnonzero(view.in_own_voronoi_cell).tolist()
    assert ways[chosen] == min(ways[f] for f in own or everywhere)


@seeds
@given(seed=st.integers(0, 10**6), teams=st.integers(1, 5))
def test_scores_are_what_their_docstrings_say(seed: int, teams: int) -> None:
    view = hall(seed, teams)
    ways = ways_m(view).tolist()
    targets = [t for t in view.others.destinations_m.tolist() if not math.isnan(t[0])]
    places = [*view.others.positions_m.tolist(), *targets]
    unknown = view.unknown_m2(1.0)
    scores: dict[str, list[float]] = {"utility": [], "gain": [], "potential": [], "llm": []}
    for f, at in enumerate(view.frontiers_m.tolist()):
        near = sum(max(0.0, 1.0 - math.dist(at, t) / 10.0) for t in targets)
        scores["utility"].append(1.0 - near - 0.1 * ways[f])
        scores["gain"].append(float(unknown[f]) * math.exp(-0.2 * ways[f]))
        push = 0.0
        for place in places:
            apart = min(10.0, max(0.25, math.dist(at, place)))
            push += 50.0 * (1.0 / apart - 0.1) ** 2
        scores["potential"].append(-ways[f] - push)
        around = view.neighbour_counts(tuple(view.frontiers[f].tolist()))
        scores["llm"].append(around[0] - around[1] - math.dist(at, view.position_m) - 10.0 * near)
    rules = {
        "utility": Utility(range_m=10.0, beta_per_m=0.1),
        "gain": InformationGain(reach_m=1.0, decay_per_m=0.2),
        "potential": Potential(range_m=10.0, push_m3=100.0),
        "llm": LlmLike(apart_m=10.0, shyness_m=10.0, frontier_m=1.0, obstacle_m=1.0),
    }
    for name, rule in rules.items():
        chosen = index_of(view, rule.choose(view, None).cell)
        assert scores[name][chosen] == pytest.approx(max(scores[name]), abs=1e-9), name


def test_near_means_near() -> None:
    view = hall(5, 3, holes=9)
    nearest = int(np.argmin(view.distances_m))
    assert index_of(view, NearestEuclidean().choose(view, None).cell) == nearest
    radius_m = float(np.sort(view.distances_m)[5])
    for bias in (0.0, 0.5, 1.0):
        rule = QuantileLocal(radius_m=radius_m, bias_min=bias, bias_max=bias, sigma=0.0)
        chosen = index_of(view, rule.choose(view, None).cell)
        assert view.distances_m[chosen] <= radius_m
    # None within the radius: all count.
    view = next(v for v in (hall(seed, 2) for seed in range(20)) if v.distances_m.min() > 0.1)
    far = QuantileLocal(radius_m=0.1, bias_min=1.0, bias_max=1.0, sigma=0.0)
    chosen = index_of(view, far.choose(view, None).cell)
    assert view.distances_m[chosen] == view.distances_m.max()
