"""Exact map exchange: version vectors over evidence logs.

What robot i knows of robot k's log is a prefix of it, so one number says it: ``known[i, k]``. On
contact i takes from j exactly the entries ``known[i, k] … known[j, k]`` for every k. Exchange is
therefore idempotent, nothing counts twice however often robots meet (which plain addition of maps
suffers from), and when everybody has heard everybody all maps are equal.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from swarmscout.core.jit import kernel
from swarmscout.mapping.evidence import EvidenceLog
from swarmscout.mapping.occupancy import OccupancyGrids

__all__ = ["exchange_evidence", "merge_versions", "share_evidence"]


@kernel
def merge_versions(known, length, links, merged):  # type: ignore[no-untyped-def]
    """What everybody knows after one round of contacts, all at the same time.

    Args:
        known: int64[N, N], before; length: int64[N], how long each robot's own log is.
        links: bool[N, N]: links[i, j] says that i hears j.
        merged: int64[N, N], written: after.
    """
    robots = known.shape[0]
    for i in range(robots):
        for k in range(robots):
            merged[i, k] = known[i, k]
        merged[i, i] = length[i]
        for j in range(robots):
            if j == i or not links[i, j]:
                continue
            for k in range(robots):
                heard = length[j] if k == j else known[j, k]
                merged[i, k] = max(merged[i, k], heard)


def exchange_evidence(
    grids: OccupancyGrids, log: EvidenceLog, known: NDArray[np.int64], links: NDArray[np.bool_]
) -> None:
    """Phase 3 of a step with a map per robot: evidence flows along this step's links.

    Args:
        grids: one map per robot; each gets the entries that are new to it.
        log: every robot's log.
        known: int64[N, N], the version vectors, brought up to date.
        links: bool[N, N]: links[i, j] says that i hears j.
    """
    merged = np.empty_like(known)
    merge_versions(known, log.length, links, merged)
    for i in range(len(known)):
        grids.apply(i, log.cells, log.increments, known[i], merged[i])
    known[:] = merged


def share_evidence(grids: OccupancyGrids, log: EvidenceLog, since: NDArray[np.int64]) -> int:
    """Phase 3 under full communication: one map takes in everybody's new entries.

    Args:
        grids: one map.
        log: every robot's log.
        since: int64[N], the first entry of each that is new.

    Returns:
        How many cells the entries name; they stand in ``grids.touched``.
    """
    return grids.apply(0, log.cells, log.increments, since, log.length)
