"""The baseline's choice for all leaders of a batch: the candidate at a rank by distance."""

from __future__ import annotations

import numpy as np

from swarmscout.core.cells import offset
from swarmscout.core.jit import kernel
from swarmscout.destinations.batch import ASKED
from swarmscout.destinations.offers import is_offered, keeps_doubting

__all__ = ["BY_RANK", "choose_by_rank"]

BY_RANK = np.dtype(
    [
        *((name, ASKED[name]) for name in ASKED.names or ()),
        ("quantile", "f8"),
        ("radius_m", "f8"),  # candidates nearer than this count, if there are any
        ("among", "i8"),  # written: how many counted
        ("rank", "i8"),  # written: the choice's rank by distance
    ],
    align=True,
)
"""ASKED, and what these rules read and write besides."""


@kernel
def choose_by_rank(own, land, memory, rules, step, asked):  # type: ignore[no-untyped-def]
    """Choose a candidate for each leader of a batch, see ``Quantile``.

    Args:
        own: MIND[N]; of it a leader's own record is read.
        land, memory: see ``Batch``.
        rules: OFFERS[1]; step: the current step.
        asked: BY_RANK[L], written.
    """
    rules = rules[0]
    flat = land.flat
    size = flat.shape[0]
    offered = np.empty(size, dtype=np.int64)
    distance = np.empty(size)
    for a in range(asked.shape[0]):
        choice = asked[a]
        i = choice.leader
        x, y = own[i].x_m, own[i].y_m
        n = 0
        near = 0
        for f in range(size):
            if choice.routed >= 0 and not land.routed[choice.routed, f]:
                continue
            if not is_offered(flat[f], memory.avoided[i], memory.given_up[i], rules, step):
                continue
            dx, dy = offset(flat[f], x, y, rules)
            distance[n] = np.sqrt(dx * dx + dy * dy)
            near += distance[n] <= choice.radius_m
            offered[n] = f
            n += 1
        choice.at = -1
        choice.offered = n
        if choice.routed >= 0:
            choice.doubts = keeps_doubting(
                flat, land.routed[choice.routed], memory.given_up[i], rules
            )
        if n == 0:
            continue
        choice.among = near if near > 0 else n
        choice.rank = np.int64(np.rint(choice.quantile * (choice.among - 1)))
        at = np.partition(distance[:n], choice.rank)[choice.rank]
        # Of equally far ones the first by cell.
        behind = choice.rank
        for k in range(n):
            behind -= distance[k] < at
        for k in range(n):
            if distance[k] == at:
                if behind == 0:
                    choice.at = offered[k]
                    break
                behind -= 1
