"""What the route search keeps in memory: nodes, buckets, costs."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from swarmscout.core.grid import GridFrame
from swarmscout.planning.costs import RouteCosts
from swarmscout.planning.regions import Regions, blank_regions

__all__ = ["BUCKETS", "NODE", "SEARCH", "Search"]

BUCKETS = 256
OUTSIDE = -(1 << 30)

NODE = np.dtype(
    [
        ("mark", "i8"),  # in which search the cell was touched last, with flags below
        ("cost", "i8"),  # its cost there
        ("before", "i4"),  # the open cells before and after it in its bucket (negative: none)
        ("after", "i4"),
        ("bucket", "i4"),  # the number of the bucket
        ("unused", "i4"),
    ],
    align=True,
)
"""What the search keeps of a cell, in one place: it spends its time fetching this."""

SEARCH = np.dtype(
    [
        ("straight", "i8"),  # the attributes of RouteCosts
        ("diagonal", "i8"),
        ("base", "i8"),
        ("least", "i8"),
        ("beside", "i8"),
        ("standing", "i8"),
        ("station", "i8"),
        ("unproven", "i8"),
        ("proven", "i8"),
        ("bits", "i8"),  # of a cost that a bucket spans: a move changes a cost, with its
        # heuristic, by less than half of all buckets
        ("columns", "i8"),  # of the grid
        ("count", "i8"),  # counts searches: even numbers to cells, odd ones to stations
        ("loaded", "i8"),  # the map whose tolls are filled in …
        ("seen", "i8"),  # … and the number of its last update that is
        ("far", "i8"),  # ways over more regions than this are planned in parts; 0: none are
        ("filled_low", "i8"),  # the first and last row of the grid with tolls of a map
        ("filled_high", "i8"),
        ("home", "i8"),  # 1: routes lead to stations, 0: to cells
    ],
    align=True,
)
"""Costs, and what persists between searches."""


class Search:
    """Scratch memory of the search over one grid, reused from call to call.

    The grid has a rim of one cell here, so that no neighbour has to be looked for outside: P cells.

    Attributes:
        toll: int32[P], what a cell costs per metre in 1/1000; negative: only for robots that stand
            there already.
        nodes: NODE[P].
        buckets: int32[BUCKETS], the first cell of each, used in turn; -1 for none.
        regions: see ``Regions``.
        state: SEARCH[1].

    Args:
        frame: the grid.
        costs: what moving costs.
        beside: a search to cells, whose nodes this one to stations shares.
    """

    def __init__(self, frame: GridFrame, costs: RouteCosts, beside: Search | None = None) -> None:
        self.regions: Regions = blank_regions(frame)
        size = (frame.rows + 2) * (frame.columns + 2)
        self.toll = np.full(size, OUTSIDE, dtype=np.int32)
        self.nodes: NDArray[np.void] = np.zeros(size, NODE) if beside is None else beside.nodes
        self.buckets = np.full(BUCKETS, -1, dtype=np.int32)
        toll = (
            costs.base + 1000 + costs.beside + 4 * costs.standing + costs.station + costs.unproven
        )
        most = 4 * costs.diagonal * toll
        self.state = np.zeros(1, dtype=SEARCH)
        state = self.state[0]
        for name in (
            "straight", "diagonal", "base", "least", "beside", "standing", "station",
            "unproven", "proven",
        ):  # fmt: skip
            state[name] = getattr(costs, name)
        state["bits"] = max(0, most.bit_length() - (BUCKETS.bit_length() - 2))
        state["columns"] = frame.columns
        state["filled_high"] = frame.rows - 1
        state["home"] = state["count"] = 0 if beside is None else 1
        state["loaded"] = -1
        state["far"] = costs.far_tiles
