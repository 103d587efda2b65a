"""Whether routes connect two cells, found without the routes: as the search and SciPy find it."""

from __future__ import annotations

import numpy as np
import scipy.ndimage
from hypothesis import given, settings
from hypothesis import strategies as st
from test_route_search import costs_for, maps_of

from swarmscout.core.grid import GridFrame
from swarmscout.mapping.footprint import TIGHT
from swarmscout.planning.routes import Planner, Vehicle


@settings(max_examples=150)
@given(
    st.integers(0, 2**32 - 1), st.integers(1, 25), st.integers(1, 40), st.sampled_from([0.1, 0.45])
)
def test_cells_are_connected_where_routes_lead(
    seed: int, rows: int, columns: int, walls: float
) -> None:
    rng = np.random.default_rng(seed)
    frame = GridFrame(0.0, 0.0, 0.5, rows, columns)
    # What is not known is open; some rows at either end are not known at all.
    evidence = np.where(rng.random((rows, columns)) < walls, 5000, 0)
    evidence[rng.random((rows, columns)) < 0.2] = 0
    evidence[: rng.integers(0, rows)] = 0
    evidence[rows - rng.integers(0, rows) :] = 0
    grids = maps_of(frame, evidence, 1)
    grids.bounds[0] = frame.rows, -1
    known = np.flatnonzero(evidence.any(axis=1))
    if len(known):
        grids.bounds[0] = known[0], known[-1]
    headings = np.column_stack([np.cos(np.arange(3600)), np.sin(np.arange(3600))])
    vehicle = Vehicle(0.15, 0.2, 400, 1.4, headings)
    planner = Planner(frame, 1, costs_for("length"), np.zeros((0, 2)), vehicle)
    everywhere = np.arange(frame.size)
    entries = grids.entries(0, everywhere)
    open_ = (grids.status[0, : frame.size] & TIGHT == 0).reshape(frame.shape)
    component, _ = scipy.ndimage.label(open_)
    for start in rng.integers(0, frame.size, 6).tolist():
        found = planner.connects(grids, 0, start, entries)
        found[start] = True
        costs = planner.costs_from(grids, 0, start, everywhere)
        assert np.array_equal(found, np.isfinite(costs))
        row, col = frame.unflat(start)
        if open_[row, col]:
            same = open_.ravel() & (component.ravel() == component[row, col])
            same[start] = True
            assert np.array_equal(found & open_.ravel(), same)
