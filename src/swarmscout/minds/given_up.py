"""What a robot remembers of destinations that were given up: where, how often, and what follows.

Deviation: the paper heads for every frontier, however often that was in vain. Here a place is a
square of map cells of about a metre: who has stood within reach of one of its cells has stood near
all of them. A place is *closed*, which means that nobody who has heard of it heads there any more,
after `STANDS` tries in which a robot stood within reach of a frontier there that its sensor did not
resolve, or after `TRIES` in all: from where robots can stand, the frontier stays one. A frontier
that vanishes when a team is near counts as a try, too: should the place have one again each time,
it is one that flickers. Tries are counted some time apart, twice as long after each. A team that
did not get to a place at all avoids it for that time.

Memory is the same for each robot and however long the mission is: in a full part of the table, what
matters for the shortest time is forgotten first.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from swarmscout.core.enums import OVERDUE, REACHED, UNREACHABLE
from swarmscout.core.jit import inlined

__all__ = [
    "FOR_GOOD",
    "GIVEN_UP",
    "PLACE_M",
    "avoided_until",
    "nothing_given_up",
    "place_of",
    "remember",
]

GIVEN_UP = np.dtype(
    [
        ("place", "i4"),  # its number, or -1: none
        ("until", "i4"),  # the last step in which to avoid it, or -1; FOR_GOOD: it is closed
        ("again", "i4"),  # until after this step, what fails there belongs to the same try
        ("tries", "i2"),  # failed tries
        ("stands", "i2"),  # those in which a robot stood within reach
    ]
)
"""One place that was given up."""

PLACE_M = 1.0
STANDS = 3
TRIES = 4
FOR_GOOD = 2**31 - 1

PARTS, PART = 32, 8
"""Number of parts of a robot's table, and of places in each part."""


def nothing_given_up(robots: int) -> NDArray[np.void]:
    """GIVEN_UP[N, 256]: blank tables, one for each robot.

    Args:
        robots: N.
    """
    table = np.zeros((robots, PARTS * PART), dtype=GIVEN_UP)
    table["place"] = table["until"] = table["again"] = -1
    return table


@inlined
def place_of(cell, rules):  # type: ignore[no-untyped-def]
    """The number of the place in which a flat cell lies.

    Args:
        cell: the cell.
        rules: a record with `columns` of the grid and `place_cells`, the edge of a place in cells.
    """
    side = rules.place_cells
    row = cell // rules.columns
    return row // side * rules.columns + (cell - row * rules.columns) // side


@inlined
def _part_of(place):  # type: ignore[no-untyped-def]
    """Where the part of the table begins in which a place is kept."""
    return (place * 40503 >> 7) % PARTS * PART


@inlined
def avoided_until(table, place):  # type: ignore[no-untyped-def]
    """The last step in which a robot avoids a place; -1: it has not heard of it.

    Args:
        table: GIVEN_UP[256], the robot's own.
        place: its number.
    """
    first = _part_of(place)
    for at in range(first, first + PART):
        if table[at].place == place:
            return table[at].until
    return -1


@inlined
def remember(table, place, why, ours, avoid_steps, step):  # type: ignore[no-untyped-def]
    """Note a failed try.

    Args:
        table: GIVEN_UP[256], the robot's own; written.
        place: its number.
        why: REACHED: it is a frontier still; another code of CAUSES: see above.
        ours: whether the robot's own team gave it up. Its table always has room for that.
        avoid_steps: the time between the first two tries; step: the current step.
    """
    first = _part_of(place)
    at = -1
    oldest = first
    for slot in range(first, first + PART):
        if table[slot].place == place:
            at = slot
        elif table[slot].again < table[oldest].again:
            oldest = slot
    if at < 0:
        if not ours and table[oldest].again >= step:
            return
        at = oldest
        table[at].place = place
        table[at].until = -1
        table[at].again = -1
        table[at].tries = 0
        table[at].stands = 0
    known = table[at]
    if known.again < step:
        known.tries += 1
        known.stands += why == REACHED
        known.again = step + (avoid_steps << (known.tries - 1))
        if known.stands == STANDS or known.tries == TRIES:
            known.until = FOR_GOOD
            known.again = FOR_GOOD
    if why in (OVERDUE, UNREACHABLE):
        known.until = max(known.until, known.again)
