"""Routes that lead far are planned in parts: they get there, and are hardly longer than others."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import scipy.ndimage
from hypothesis import given, settings
from hypothesis import strategies as st
from known import knowledge_of
from known import place as put
from numpy.typing import NDArray
from test_route_search import MODEL, VEHICLE, costs_for, maps_of

from swarmscout.core.events import EventLog
from swarmscout.core.grid import GridFrame
from swarmscout.mapping.footprint import TIGHT, Footprint
from swarmscout.mapping.occupancy import OccupancyGrids
from swarmscout.minds.minds import blank_minds
from swarmscout.planning.routes import Planner

FRAME = GridFrame(0.0, 0.0, 0.5, 500, 420)


def ground(seed: int, walls: float) -> OccupancyGrids:
    """A large map: blobs of walls, known free ground between them, and unknown ground."""
    rng = np.random.default_rng(seed)
    relief = scipy.ndimage.gaussian_filter(rng.standard_normal(FRAME.shape), 6.0)
    known = scipy.ndimage.gaussian_filter(rng.standard_normal(FRAME.shape), 25.0) > 0.0
    evidence = np.where(relief > np.quantile(relief, 1.0 - walls), 5000, -5000)
    return maps_of(FRAME, np.where(known, evidence, 0), 1)


def planner_of(far_tiles: int, robots: int = 1) -> Planner:
    return Planner(
        FRAME, robots, replace(costs_for("length"), far_tiles=far_tiles), np.zeros((0, 2)), VEHICLE
    )


def drive(
    planner: Planner, grids: OccupancyGrids, start: int, goal: int
) -> tuple[NDArray[np.int64], int]:
    """The cells that a robot drives through, from plan to plan, and how many plans it makes."""
    minds = blank_minds(1)
    minds.own["target"] = goal
    cells, plans = [start], 0
    knowledge = knowledge_of(minds, grids)
    route = planner.table.state[0]
    while plans < 40:
        put(minds, FRAME.centres_of(FRAME.unflat_many(np.array(cells[-1:]))))
        planner.plan(minds, knowledge, 7, EventLog(1))
        plans += 1
        if route["cost"] < 0:
            return np.zeros(0, dtype=np.int64), plans
        cells += planner.table.ahead(0).tolist()
        arrived = route["length"] == route["kept"]
        route["at"] = route["kept"]
        if arrived:
            break
    return np.array(cells), plans


def cost_of(cells: NDArray[np.int64], grids: OccupancyGrids) -> float:
    """In metres of free way, as the search counts them."""
    costs = costs_for("length")
    price = grids.price[0][cells].astype(np.int64) + 1000
    rows, cols = cells // FRAME.columns, cells % FRAME.columns
    diagonal = (np.diff(rows) != 0) & (np.diff(cols) != 0)
    length = np.where(diagonal, costs.diagonal, costs.straight)
    return float((length * (price[1:] + price[:-1])).sum()) / 2e6


def far_pairs(grids: OccupancyGrids, rng: np.random.Generator, count: int) -> list[tuple[int, int]]:
    open_ = np.flatnonzero(grids.status[0, : FRAME.size] & TIGHT == 0)
    pairs = []
    while len(pairs) < count:
        start, goal = rng.choice(open_, 2).tolist()
        off = np.subtract(FRAME.unflat(start), FRAME.unflat(goal))
        if np.abs(off).max() > 9 * 32:
            pairs.append((start, goal))
    return pairs


@pytest.mark.parametrize("walls", [0.2, 0.4])
@pytest.mark.parametrize("seed", range(4))
def test_a_robot_gets_there_in_parts(seed: int, walls: float) -> None:
    grids = ground(seed, walls)
    whole, parts = planner_of(0), planner_of(8)
    ratios = []
    for start, goal in far_pairs(grids, np.random.default_rng(seed), 6):
        best = float(whole.costs_from(grids, 0, start, np.array([goal]))[0])
        cells, plans = drive(parts, grids, start, goal)
        assert np.isfinite(best) == (len(cells) > 0)
        if len(cells):
            assert cells[-1] == goal
            assert plans > 1
            assert not (grids.status[0, cells] & TIGHT).any()
            assert (np.abs(np.diff(cells // FRAME.columns)) <= 1).all()
            ratios.append(cost_of(cells, grids) / best)
            assert ratios[-1] >= 1.0 - 1e-9
            alone, _ = drive(planner_of(0), grids, start, goal)
            assert cost_of(alone, grids) == pytest.approx(best)
    assert np.mean(ratios) < 1.15
    assert max(ratios) < 1.4


def test_what_others_ask_does_not_change_a_route() -> None:
    grids = ground(5, 0.3)
    rng = np.random.default_rng(5)
    (start, goal), *others = far_pairs(grids, rng, 5)
    together, alone = planner_of(8, robots=6), planner_of(8, robots=6)
    for planner, asking in ((together, 6), (alone, 1)):
        minds = blank_minds(6)
        starts = np.array([start, *(place for place, _ in others), start + 1])
        put(minds, FRAME.centres_of(FRAME.unflat_many(starts)))
        minds.own["target"][:asking] = goal
        planner.plan(minds, knowledge_of(minds, grids), 7, EventLog(6))
    assert together.table.ahead(0).tolist() == alone.table.ahead(0).tolist()
    assert together.table.state["way_mm"][0] == alone.table.state["way_mm"][0]


@settings(max_examples=100)
@given(st.integers(0, 2**32 - 1), st.sampled_from([0.0, 0.4, 1.5]))
def test_tolls_follow_the_map(seed: int, radius_m: float) -> None:
    rng = np.random.default_rng(seed)
    frame = GridFrame(0.0, 0.0, 0.5, *rng.integers(1, 90, 2).tolist())
    # Some change cells at the corner of four tiles alone.
    where = np.arange(frame.size)
    if rng.random() < 0.7 and min(frame.shape) > 40:
        where = where.reshape(frame.shape)[28:36, 28:36].ravel()
    footprint = Footprint.of_disc(radius_m, frame.cell_m, 0.0) if radius_m else None
    grids = OccupancyGrids(frame, 2, MODEL, 8, footprint)
    planner = Planner(frame, 1, costs_for("length"), np.zeros((0, 2)), VEHICLE)
    for _ in range(12):
        m = int(rng.integers(2))
        if rng.random() < 0.3:
            grids.copy_row(1 - m, m)
        cells = rng.choice(where, (1, 12))
        increments = rng.integers(-3000, 3000, (1, 12))
        low = np.zeros(1, dtype=np.int64)
        grids.apply(m, cells, increments, low, low + int(rng.integers(1, 13)))
        asked = int(rng.integers(2))
        planner.costs_from(grids, asked, 0, np.array([frame.size - 1]))
        fresh = Planner(frame, 1, costs_for("length"), np.zeros((0, 2)), VEHICLE)
        fresh.costs_from(grids, asked, 0, np.array([frame.size - 1]))
        assert np.array_equal(planner._search.toll, fresh._search.toll)


def test_tolls_follow_a_footprint_that_grows_along_one_row_alone() -> None:
    frame = GridFrame(0.0, 0.0, 0.5, 70, 70)
    grids = OccupancyGrids(frame, 1, MODEL, 8, Footprint.of_disc(0.4, frame.cell_m, 0.0))
    planner = Planner(frame, 1, costs_for("length"), np.zeros((0, 2)), VEHICLE)
    low = np.zeros(1, dtype=np.int64)
    # What the last wall adds in the rows above and below it, those before have closed already.
    for row in (8, 12, 10):
        cells = np.array([[frame.flat(row, 31)]])
        grids.apply(0, cells, np.full((1, 1), 5000), low, low + 1)
        planner.costs_from(grids, 0, 0, np.array([frame.size - 1]))
    fresh = Planner(frame, 1, costs_for("length"), np.zeros((0, 2)), VEHICLE)
    fresh.costs_from(grids, 0, 0, np.array([frame.size - 1]))
    assert np.array_equal(planner._search.toll, fresh._search.toll)
