"""What a leader may choose from, looked up cell by cell inside kernels.

The definition is :func:`swarmscout.destinations.candidates.mark_open`, which marks all cells.
"""

from __future__ import annotations

import numpy as np

from swarmscout.core.grid import GRID
from swarmscout.core.jit import inlined
from swarmscout.mapping.footprint import FRONTIER
from swarmscout.minds.given_up import FOR_GOOD, avoided_until, place_of

__all__ = ["OFFERS", "count_offered", "is_offered", "keeps_doubting"]

OFFERS = np.dtype(
    [
        *GRID.descr,  # the frame of the map
        ("place_cells", "i8"),  # edge of a place in cells, see ``minds.given_up``
    ],
    align=True,
)
"""Where candidates and places lie."""


@inlined
def is_offered(cell, cells, places, rules, step):  # type: ignore[no-untyped-def]
    """Whether a robot does not avoid a cell in a step.

    Args:
        cell: flat.
        cells: int64[32, 2], `avoided`, and places: GIVEN_UP[256]: the robot's own, see ``Minds``.
        rules: a record with `columns` and `place_cells`; step: the current step.
    """
    offered = avoided_until(places, place_of(cell, rules)) < step
    for a in range(cells.shape[0]):
        offered = offered and not (cells[a, 0] == cell and cells[a, 1] >= step)
    return offered


@inlined
def _count_in_place(status, place, rules):  # type: ignore[no-untyped-def]
    """How many frontier cells lie in a place."""
    side = rules.place_cells
    top = place // rules.columns * side
    left = place % rules.columns * side
    n = 0
    for row in range(top, min(rules.rows, top + side)):
        for col in range(left, min(rules.columns, left + side)):
            n += status[row * rules.columns + col] & FRONTIER != 0
    return n


@inlined
def count_offered(status, frontiers, cells, places, rules, step):  # type: ignore[no-untyped-def]
    """How many frontier cells of its map a robot does not avoid.

    Args:
        status: uint8[C'], of one map; frontiers: how many frontier cells it has.
        cells, places, rules, step: see :func:`is_offered`.
    """
    n = frontiers
    for at in range(places.shape[0]):
        if places[at].place >= 0 and places[at].until >= step:
            n -= _count_in_place(status, places[at].place, rules)
    for a in range(cells.shape[0]):
        cell = cells[a, 0]
        if (
            cells[a, 1] < step
            or not status[cell] & FRONTIER
            or avoided_until(places, place_of(cell, rules)) >= step
        ):
            continue
        again = False
        for b in range(a):
            again = again or (cells[b, 0] == cell and cells[b, 1] >= step)
        n -= not again
    return n


@inlined
def keeps_doubting(flat, routed, places, rules):  # type: ignore[no-untyped-def]
    """Whether a candidate that is not closed for good has no route.

    Args:
        flat: int64[F], candidates; routed: bool[F], whether a route leads there.
        places: GIVEN_UP[256], `given_up`, the robot's own; rules: see :func:`is_offered`.
    """
    for f in range(flat.shape[0]):
        if not routed[f] and avoided_until(places, place_of(flat[f], rules)) < FOR_GOOD:
            return True
    return False
