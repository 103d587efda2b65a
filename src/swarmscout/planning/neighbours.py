"""Whom a robot has near it, and what it expects of them, as far as it has heard.

Robots are looked for in buckets, so that a swarm of thousands costs a thousand times one robot.
"""

from __future__ import annotations

import math

import numpy as np

from swarmscout.core.cells import cell_of
from swarmscout.core.enums import CHARGE
from swarmscout.core.grid import GRID
from swarmscout.core.jit import inlined
from swarmscout.mapping.footprint import STATION_ZONE

__all__ = [
    "FAR",
    "MOST_NEAR",
    "MOVES",
    "NEIGHBOUR",
    "RIGHTS",
    "empty_buckets",
    "fill_buckets",
    "look_round",
    "turns_to",
]

RIGHTS = np.dtype(
    [
        *GRID.descr,  # the frame of the map
        ("edge_m", "f8"),  # of the buckets in which robots look for each other
        ("bucket_rows", "i8"),
        ("bucket_columns", "i8"),
        ("radius_m", "f8"),  # the robots' body
        ("forward_m", "f8"),
        ("turn_ticks", "i8"),
        ("aside", "i8"),  # turns between two headings that are compared
    ],
    align=True,
)
"""How robots keep clear of each other."""

NEIGHBOUR = np.dtype(
    [
        ("x_m", "f8"),
        ("y_m", "f8"),
        ("dx_m", "f8"),  # one move in the direction in which it means to drive
        ("dy_m", "f8"),
        ("starts", "i8"),  # turns until it looks there; FAR: it stands
        ("wants", "?"),  # it wants to drive
        ("first", "?"),  # it goes first
    ],
    align=True,
)
"""What a robot expects of one that is near."""

MOST_NEAR = 48
MOVES = 5
"""Number of moves looked ahead."""
TURN_STEPS = 20
"""Number of steps after which the order of robots rotates."""
BUSY_STEPS = 6
"""A robot that has stayed in place for this many steps is not expected to drive on: otherwise two
robots would wait for each other."""
FAR = 1 << 20


@inlined
def turns_to(heading, wanted, turn, ticks):  # type: ignore[no-untyped-def]
    """How many turns, to the left if positive, bring a heading nearest to another one."""
    off = (wanted - heading + ticks // 2) % ticks - ticks // 2
    turns = (abs(off) + turn // 2) // turn
    return turns if off > 0 else -turns


@inlined
def _bucket(x, y, rules):  # type: ignore[no-untyped-def]
    """The bucket that a believed position falls into; those off the map fall into the rim."""
    row = int(math.floor((y - rules.origin_y_m) / rules.edge_m))
    col = int(math.floor((x - rules.origin_x_m) / rules.edge_m))
    row = min(rules.bucket_rows - 1, max(0, row))
    return row * rules.bucket_columns + min(rules.bucket_columns - 1, max(0, col))


@inlined
def fill_buckets(heard, chain, rules):  # type: ignore[no-untyped-def]
    """Put the robots that a row has heard of into buckets."""
    buckets = rules.bucket_rows * rules.bucket_columns
    for j in range(heard.shape[0] - 1, -1, -1):
        if heard[j].step >= 0:
            b = _bucket(heard[j].x_m, heard[j].y_m, rules)
            chain[buckets + j] = chain[b]
            chain[b] = j


@inlined
def empty_buckets(heard, chain, rules):  # type: ignore[no-untyped-def]
    """Empty the buckets again."""
    for j in range(heard.shape[0]):
        if heard[j].step >= 0:
            chain[_bucket(heard[j].x_m, heard[j].y_m, rules)] = -1


@inlined
def _expect(near, beacon, step, headings, rules):  # type: ignore[no-untyped-def]
    """Write down what is expected of robot j."""
    near.x_m = beacon.x_m
    near.y_m = beacon.y_m
    near.wants = beacon.step == step and beacon.aim >= 0
    near.dx_m = 0.0
    near.dy_m = 0.0
    near.starts = FAR
    if near.wants and beacon.still < BUSY_STEPS:
        near.dx_m = rules.forward_m * headings[beacon.aim, 0]
        near.dy_m = rules.forward_m * headings[beacon.aim, 1]
        ticks = headings.shape[0]
        near.starts = abs(turns_to(beacon.heading, beacon.aim, rules.turn_ticks, ticks))


@inlined
def _goes_first(heard, status, i, j, step, rules):  # type: ignore[no-untyped-def]
    """Whether robot j goes before robot i where their ways cross."""
    charges = heard[j].mode == CHARGE
    if charges != (heard[i].mode == CHARGE):
        # Who has to charge cannot wait; but who has charged leaves before others come in.
        explorer = heard[i] if charges else heard[j]
        leaves = status[cell_of(explorer.x_m, explorer.y_m, rules)] & STATION_ZONE != 0
        return charges != leaves
    shift = step // TURN_STEPS
    robots = heard.shape[0]
    return (j + shift) % robots < (i + shift) % robots


@inlined
def look_round(me, heard, status, chain, near, i, step, headings, rules):  # type: ignore[no-untyped-def]
    """List the neighbours that a robot can meet within the moves looked ahead; returns how many.

    In a dense crowd it looks less far.
    """
    buckets = rules.bucket_rows * rules.bucket_columns
    reach = 2.0 * MOVES * rules.forward_m + 2.0 * rules.radius_m
    while True:
        n = 0
        first = _bucket(me.x_m - reach, me.y_m - reach, rules)
        last = _bucket(me.x_m + reach, me.y_m + reach, rules)
        columns = rules.bucket_columns
        for row in range(first // columns, last // columns + 1):
            for col in range(first % columns, last % columns + 1):
                j = chain[row * columns + col]
                while j >= 0:
                    dx = heard[j].x_m - me.x_m
                    dy = heard[j].y_m - me.y_m
                    if j != i and dx * dx + dy * dy <= reach * reach:
                        if n < near.shape[0]:
                            _expect(near[n], heard[j], step, headings, rules)
                            near[n].first = _goes_first(heard, status, i, j, step, rules)
                        n += 1
                    j = chain[buckets + j]
        if n <= near.shape[0]:
            return n
        reach *= 0.7
