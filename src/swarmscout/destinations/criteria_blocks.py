"""What candidates are worth to any leader that shares a map, computed by blocks when wanted."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from swarmscout.core.cells import centre
from swarmscout.core.enums import OCCUPIED, UNKNOWN
from swarmscout.core.grid import GRID
from swarmscout.core.jit import allocating, inlined
from swarmscout.destinations.batch import Batch
from swarmscout.destinations.claims import crowding
from swarmscout.destinations.features import disc_half_widths
from swarmscout.mapping.footprint import LABEL_BITS

__all__ = ["CRITERIA", "Blocks", "Fixed", "make_blocks", "middle", "open_block", "prepare"]

NEAR_M = 1.0
"""Unknown area counts as close by within this distance."""

OCCUPIED_FROM = 32

BLOCK_M = 4.0
"""Edge of the blocks in which candidates are looked up."""

CLAIM_M = 1.0
"""Least edge of the blocks in which other teams' destinations are looked up."""

CRITERIA = np.dtype(
    [
        *GRID.descr,  # the frame of the map
        ("silence_steps", "i8"),
        ("place_cells", "i8"),  # edge of a place, see ``minds.given_up``
        ("entry_cells", "f8"),  # see ``Footprint``
        ("exit_cells", "f8"),
        ("block", "i8"),  # edge of the blocks of candidates, in cells
        ("claim_m", "f8"),  # edge of the blocks of other teams' destinations
        ("least_m", "f8"),  # a way is at least this share of the straight line
        ("most_gain", "f8"),  # what a candidate may gain at most
        ("way", "f8"),  # the parameters of ``MultiCriteria``
        ("front", "f8"),
        ("turn_m", "f8"),
        ("near_gain", "f8"),
        ("open_gain", "f8"),
        ("wall", "f8"),
        ("apart", "f8"),
        ("apart_m", "f8"),
        ("ahead", "f8"),
    ],
    align=True,
)


class Fixed(NamedTuple):
    """What does not change over a mission.

    Attributes:
        turns: float64[ticks, 2], (cos, sin) of headings as NumPy computes them.
        near, open: int64[r + 1], half the width of discs 0 … r rows off their centre.
        sums: int64[w, w + 1], scratch: along each row round a block, how many cells are unknown,
            and above OCCUPIED_FROM bits how many are occupied.
        edge, lengths, field, queues: see ``Scratch``.
    """

    turns: NDArray[np.float64]
    near: NDArray[np.int64]
    open: NDArray[np.int64]
    sums: NDArray[np.int64]
    edge: NDArray[np.bool_]
    lengths: NDArray[np.int64]
    field: NDArray[np.int64]
    queues: NDArray[np.int64]


def prepare(batch: Batch, weights: Mapping[str, float]) -> tuple[Fixed, NDArray[np.void]]:
    """What the kernel reads that is the same over a mission: see ``Fixed``, and CRITERIA[1].

    Args:
        batch: any of the mission. weights: the parameters of ``MultiCriteria`` by name.
    """
    frontiers = batch.frontiers
    frame, scratch, footprint = frontiers.frame, frontiers.scratch, frontiers.grids.footprint
    rad = np.arange(batch.ticks) * np.float64(2.0 * math.pi / batch.ticks)
    block = max(1, round(BLOCK_M / frame.cell_m))
    near, open_ = (disc_half_widths(m, frame.cell_m) for m in (NEAR_M, weights["open_m"]))
    edge = block + 2 * max(len(near), len(open_))
    fixed = Fixed(
        np.column_stack((np.cos(rad), np.sin(rad))), near, open_,
        np.zeros((edge, edge + 1), dtype=np.int64),
        scratch.edge, scratch.lengths, scratch.field, scratch.queues,
    )  # fmt: skip
    rules = np.zeros(1, dtype=CRITERIA)
    rule = rules[0]
    frame.write_into(rule)
    rule["place_cells"], rule["silence_steps"] = batch.place_cells, batch.silence_steps
    rule["entry_cells"], rule["exit_cells"] = footprint.entry_cells, footprint.exit_cells
    rule["block"] = block
    rule["claim_m"] = max(weights["apart_m"], CLAIM_M)
    mm = 1000.0 * frame.cell_m
    rule["least_m"] = min(1.0, *(scratch.lengths / (mm, mm * math.sqrt(2.0))))
    near_m2, open_m2 = (
        (2 * np.sum(disc[1:] * 2 + 1) + 2 * disc[0] + 1) * frame.cell_m**2 for disc in (near, open_)
    )
    rule["most_gain"] = weights["near_gain"] * near_m2 + weights["open_gain"] * open_m2
    for name, weight in weights.items():
        if name in (CRITERIA.names or ()):
            rule[name] = weight
    return fixed, rules


@inlined
def _sum_rows(b, status, fixed, blocks, rules):  # type: ignore[no-untyped-def]
    """Write running sums along the rows of the map round a block: see ``Fixed.sums``."""
    reach = max(fixed.near.shape[0], fixed.open.shape[0])
    top, left = _corner(b, reach, blocks, rules)
    edge = rules.block + 2 * reach
    for r in range(edge):
        row = top + r
        total = 0
        fixed.sums[r, 0] = 0
        for c in range(edge):
            col = left + c
            if 0 <= row < rules.rows and 0 <= col < rules.columns:
                label = status[row * rules.columns + col] & LABEL_BITS
                total += (label == UNKNOWN) + ((label == OCCUPIED) << OCCUPIED_FROM)
            fixed.sums[r, c + 1] = total


@inlined
def _corner(b, reach, blocks, rules):  # type: ignore[no-untyped-def]
    """Row and column of the first cell whose labels count for a block's candidates."""
    row = b // blocks.across
    return row * rules.block - reach, (b - row * blocks.across) * rules.block - reach


@inlined
def _count_disc(r, c, half_widths, sums):  # type: ignore[no-untyped-def]
    """Unknown and occupied cells in a disc round the cell (r, c) of running sums."""
    reach = half_widths.shape[0] - 1
    total = 0
    for off in range(-reach, reach + 1):
        half = half_widths[abs(off)]
        total += sums[r + off, c + half + 1] - sums[r + off, c - half]
    return total & ((1 << OCCUPIED_FROM) - 1), total >> OCCUPIED_FROM


@inlined
def _gain(r, c, fixed, rules):  # type: ignore[no-untyped-def]
    """What a candidate gains by unknown and open ground round it."""
    area = rules.cell_m * rules.cell_m
    unknown, _ = _count_disc(r, c, fixed.near, fixed.sums)
    near_m2 = unknown * area
    unknown, occupied = _count_disc(r, c, fixed.open, fixed.sums)
    open_m2 = unknown * area - rules.wall * (occupied * area)
    return rules.near_gain * near_m2 + rules.open_gain * open_m2


class Blocks(NamedTuple):
    """The candidates of one map by blocks of cells, with what holds for all leaders.

    Attributes:
        down, across: the number of blocks in a column and in a row.
        heads: int32[B], the first candidate of each block, -1 for none.
        chain: int32[F], the next one.
        worth: float64[B], no candidate there has a larger gain less crowding; NaN: not looked at.
        is_open: bool[B], whether gains and crowding of its candidates have been computed.
        gains, crowding: float64[F], see ``_gain`` and ``crowding``.
    """

    down: int
    across: int
    heads: NDArray[np.int32]
    chain: NDArray[np.int32]
    worth: NDArray[np.float64]
    is_open: NDArray[np.bool_]
    gains: NDArray[np.float64]
    crowding: NDArray[np.float64]


@allocating
def make_blocks(flat, rules):  # type: ignore[no-untyped-def]
    """Blocks of the candidates of one map.

    Args:
        flat: int64[F], flat cells; rules: CRITERIA.
    """
    size = rules.block
    down = (rules.rows + size - 1) // size
    across = (rules.columns + size - 1) // size
    heads = np.full(down * across, -1, dtype=np.int32)
    chain = np.empty(flat.shape[0], dtype=np.int32)
    for f in range(flat.shape[0]):
        row = flat[f] // rules.columns
        b = row // size * across + (flat[f] - row * rules.columns) // size
        chain[f] = heads[b]
        heads[b] = f
    return Blocks(
        down, across, heads, chain, np.full(down * across, np.nan),
        np.zeros(down * across, dtype=np.bool_), np.empty(flat.shape[0]), np.empty(flat.shape[0]),
    )  # fmt: skip


@inlined
def middle(b, blocks, rules):  # type: ignore[no-untyped-def]
    """X and y of a block's centre, and the distance of its corners from there."""
    edge_m = rules.block * rules.cell_m
    row = b // blocks.across
    return (
        rules.origin_x_m + (b - row * blocks.across + 0.5) * edge_m,
        rules.origin_y_m + (row + 0.5) * edge_m,
        0.7072 * edge_m,
    )


@inlined
def open_block(b, blocks, land, fixed, claims, rules):  # type: ignore[no-untyped-def]
    """Compute gains and crowding of a block's candidates.

    Args:
        b: the block. blocks: written. land: see ``Batch``.
        fixed, claims: see ``Fixed`` and ``Claims``; rules: CRITERIA.
    """
    blocks.is_open[b] = True
    reach = max(fixed.near.shape[0], fixed.open.shape[0])
    top, left = _corner(b, reach, blocks, rules)
    _sum_rows(b, land.status, fixed, blocks, rules)
    worth = -np.inf
    f = blocks.heads[b]
    while f >= 0:
        x, y = centre(land.flat[f], rules)
        row = land.flat[f] // rules.columns
        col = land.flat[f] - row * rules.columns
        blocks.gains[f] = _gain(row - top, col - left, fixed, rules)
        blocks.crowding[f] = crowding(x, y, 0.0, claims, rules)
        worth = max(worth, blocks.gains[f] - blocks.crowding[f])
        f = blocks.chain[f]
    blocks.worth[b] = worth
