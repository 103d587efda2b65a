"""The weighted sum of ``MultiCriteria`` for all leaders of a batch: the same choices, found sooner.

``weigh`` in ``multi_criteria`` scores every candidate. Here candidates are taken in by rings of
blocks round the team, and the search for ways goes on from the leader, only as long as a candidate
that has not been scored may still be the best: its score cannot be higher than its gains allow,
less what the straight line costs. So a decision costs what is near, however large the map is. A
score is computed by the same expressions in the same order as in ``weigh``, so it is the same
number.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from swarmscout.core.cells import cell_of
from swarmscout.core.grid import GRID
from swarmscout.core.jit import inlined, kernel
from swarmscout.destinations.batch import ASKED, Batch
from swarmscout.destinations.features import disc_half_widths
from swarmscout.destinations.offers import count_offered, is_offered, keeps_doubting
from swarmscout.destinations.path_lengths import NO_WAY_M
from swarmscout.destinations.walking import FAR, begin_walk, end_walk, walk_on
from swarmscout.mapping.footprint import enter, get_out
from swarmscout.minds.modes import is_on_task

__all__ = ["BY_CRITERIA", "choose_by_criteria", "prepare"]

BLOCK_M = 2.0
"""Edge of the blocks in which candidates are looked up."""

CLAIM_M = 1.0
"""Least edge of the blocks in which other teams' destinations are looked up."""

CRITERIA = np.dtype(
    [
        *GRID.descr,  # the frame of the map
        ("place_cells", "i8"),  # edge of a place, see ``minds.given_up``
        ("silence_steps", "i8"),
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

BY_CRITERIA = np.dtype(
    [
        *((name, ASKED[name]) for name in ASKED.names or ()),
        ("kept_x", "f8"),  # the team's direction so far
        ("kept_y", "f8"),
        ("score", "f8"),  # written: the score of the choice …
        ("way_m", "f8"),  # … and the leader's way there
    ],
    align=True,
)
"""ASKED, and what this rule reads and writes besides."""

STRIDE_MM = 1000
"""The search for ways goes on by so much at a time."""

ROUNDING = 1e-6
"""Bounds are compared with this to spare: they may be summed in another order than scores."""

NOT_YET = -1.0


class Fixed(NamedTuple):
    """What does not change over a mission.

    Attributes:
        turns: float64[ticks, 2], (cos, sin) of headings as NumPy computes them.
        near, open: int64[r + 1], half the width of discs 0 … r rows off their centre.
        edge, lengths, field, queues: see ``Scratch``.
    """

    turns: NDArray[np.float64]
    near: NDArray[np.int64]
    open: NDArray[np.int64]
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
    near, open_ = (disc_half_widths(m, frame.cell_m) for m in (1.0, weights["open_m"]))
    fixed = Fixed(
        np.column_stack((np.cos(rad), np.sin(rad))), near, open_,
        scratch.edge, scratch.lengths, scratch.field, scratch.queues,
    )  # fmt: skip
    rules = np.zeros(1, dtype=CRITERIA)
    rule = rules[0]
    frame.write_into(rule)
    rule["place_cells"], rule["silence_steps"] = batch.place_cells, batch.silence_steps
    rule["entry_cells"], rule["exit_cells"] = footprint.entry_cells, footprint.exit_cells
    rule["block"] = max(1, round(BLOCK_M / frame.cell_m))
    rule["claim_m"] = max(weights["apart_m"], CLAIM_M)
    mm = 1000.0 * frame.cell_m
    rule["least_m"] = min(1.0, *(scratch.lengths / (mm, mm * math.sqrt(2.0))))
    near_m2, open_m2 = (
        (2 * np.sum(disc[1:] * 2 + 1) + 2 * disc[0] + 1) * frame.cell_m**2 for disc in (near, open_)
    )
    rule["most_gain"] = weights["near_gain"] * near_m2 + weights["open_gain"] * open_m2
    for name, weight in weights.items():
        if name in CRITERIA.names:
            rule[name] = weight
    return fixed, rules


@inlined
def _count_disc(words, cell, half_widths, rows, columns):  # type: ignore[no-untyped-def]
    """Unknown and occupied cells in a disc; a word of status holds eight cells."""
    ones = np.uint64(0x0101010101010101)
    all_bits = np.uint64(0xFFFFFFFFFFFFFFFF)
    row = cell // columns
    col = cell - row * columns
    reach = half_widths.shape[0] - 1
    unknown = np.uint64(0)
    occupied = np.uint64(0)
    for near_row in range(max(0, row - reach), min(rows, row + reach + 1)):
        half = half_widths[abs(near_row - row)]
        first = near_row * columns + max(0, col - half)
        last = near_row * columns + min(columns - 1, col + half)
        for w in range(first >> 3, (last >> 3) + 1):
            inside = ones
            if w == first >> 3:
                inside &= all_bits << np.uint64(8 * (first & 7))
            if w == last >> 3:
                inside &= all_bits >> np.uint64(56 - 8 * (last & 7))
            word = words[w]
            second = word >> np.uint64(1)
            # Labels: 0 unknown, 1 free, 2 occupied. The product sums the bytes into the first one.
            unknown += ((~(word | second) & inside) * ones) >> np.uint64(56)
            occupied += ((second & inside) * ones) >> np.uint64(56)
    return np.int64(unknown), np.int64(occupied)


@inlined
def _gain(words, cell, fixed, rules):  # type: ignore[no-untyped-def]
    """What a candidate gains by unknown and open ground round it."""
    area = rules.cell_m * rules.cell_m
    unknown, _ = _count_disc(words, cell, fixed.near, rules.rows, rules.columns)
    near_m2 = unknown * area
    unknown, occupied = _count_disc(words, cell, fixed.open, rules.rows, rules.columns)
    open_m2 = unknown * area - rules.wall * (occupied * area)
    return rules.near_gain * near_m2 + rules.open_gain * open_m2


@inlined
def _centre(cell, rules):  # type: ignore[no-untyped-def]
    """x and y of a cell's centre, as ``GridFrame`` computes them."""
    row = cell // rules.columns
    col = cell - row * rules.columns
    return (
        rules.origin_x_m + (col + 0.5) * rules.cell_m,
        rules.origin_y_m + (row + 0.5) * rules.cell_m,
    )


@inlined
def _claim_block(x, y, rules):  # type: ignore[no-untyped-def]
    """Row and column of a block of destinations, counted from 1."""
    return (
        int(math.floor((y - rules.origin_y_m) / rules.claim_m)) + 1,
        int(math.floor((x - rules.origin_x_m) / rules.claim_m)) + 1,
    )


@inlined
def _gather_claims(heard, rules, step):  # type: ignore[no-untyped-def]
    """For each block, the leaders whose team's destination lies in it or in one beside it.

    Returns:
        int64[blocks + 1], where each block's leaders begin in int64[9 D], ascending; the number of
        blocks in a row, those at the rim included.
    """
    down = int(math.floor(rules.rows * rules.cell_m / rules.claim_m)) + 3
    across = int(math.floor(rules.columns * rules.cell_m / rules.claim_m)) + 3
    begins = np.zeros(down * across + 2, dtype=np.int64)
    speaks = np.zeros(heard.shape[0], dtype=np.bool_)
    n = 0
    for j in range(heard.shape[0]):
        other = heard[j]
        recent = other.step >= 0 and other.step >= step - rules.silence_steps
        if not (recent and other.leader == j and is_on_task(other.mode)) or other.destination < 0:
            continue
        speaks[j] = True
        n += 1
        x, y = _centre(other.destination, rules)
        row, col = _claim_block(x, y, rules)
        for near_row in range(row - 1, row + 2):
            for near_col in range(col - 1, col + 2):
                begins[near_row * across + near_col + 2] += 1
    for b in range(2, begins.shape[0]):
        begins[b] += begins[b - 1]
    claims = np.empty(9 * n, dtype=np.int64)
    for j in range(heard.shape[0]):
        if not speaks[j]:
            continue
        x, y = _centre(heard[j].destination, rules)
        row, col = _claim_block(x, y, rules)
        for near_row in range(row - 1, row + 2):
            for near_col in range(col - 1, col + 2):
                b = near_row * across + near_col + 1
                claims[begins[b]] = j
                begins[b] += 1
    return begins, claims, across


@inlined
def _index_blocks(flat, rules):  # type: ignore[no-untyped-def]
    """Chain the candidates of each block of cells.

    Returns:
        int32[blocks], the first candidate of each, -1 for none; int32[F], the next one.
    """
    block = rules.block
    across = (rules.columns + block - 1) // block
    heads = np.full((rules.rows + block - 1) // block * across, -1, dtype=np.int32)
    chain = np.empty(flat.shape[0], dtype=np.int32)
    for f in range(flat.shape[0]):
        row = flat[f] // rules.columns
        b = row // block * across + (flat[f] - row * rules.columns) // block
        chain[f] = heads[b]
        heads[b] = f
    return heads, chain


@inlined
def _list_members(teams, team, leader, members):  # type: ignore[no-untyped-def]
    """List the robots of a leader's team that it hears, itself too; returns how many."""
    n = 0
    for m in range(np.searchsorted(teams[0], team), teams.shape[1]):
        if teams[0, m] != team:
            break
        members[n] = teams[1, m]
        n += 1
    at = 0
    while at < n and members[at] < leader:
        at += 1
    if at == n or members[at] != leader:
        for m in range(n, at, -1):
            members[m] = members[m - 1]
        members[at] = leader
        n += 1
    return n


@inlined
def _soonest(x, y, members, heard, turns, rules):  # type: ignore[no-untyped-def]
    """The distance and turn of the member that arrives first at a point, as in ``weigh``."""
    soonest = np.inf
    for j in members:
        dx = x - heard[j].x_m
        dy = y - heard[j].y_m
        length = np.sqrt(dx * dx + dy * dy)
        cos = turns[heard[j].heading, 0]
        sin = turns[heard[j].heading, 1]
        along = (dx * cos + dy * sin) / length if length > 0.0 else 1.0
        soonest = min(soonest, length + rules.turn_m * np.sqrt(max(0.0, 2.0 - 2.0 * along)))
    return soonest


@inlined
def _score(total, x, y, soonest, heard, claims, me, choice, rules):  # type: ignore[no-untyped-def]
    """The score of a candidate at (x, y), from its gain less its way: the sum of ``weigh``."""
    total -= rules.front * soonest
    begins, leaders, across = claims
    row, col = _claim_block(x, y, rules)
    b = row * across + col
    for k in range(begins[b], begins[b + 1]):
        other = heard[leaders[k]]
        if leaders[k] == choice.leader or other.team == me.team:
            continue
        ox, oy = _centre(other.destination, rules)
        dx = x - ox
        dy = y - oy
        apart = np.sqrt(dx * dx + dy * dy)
        if apart < rules.apart_m:
            total -= rules.apart * (1.0 - apart / rules.apart_m)
    dx = x - me.x_m
    dy = y - me.y_m
    length = np.sqrt(dx * dx + dy * dy)
    if length > 0.0:
        total += rules.ahead * (dx * choice.kept_x + dy * choice.kept_y) / length
    return total


@inlined
def _settle(f, way_m, soonest, gains, land, heard, claims, me, choice, rules):  # type: ignore[no-untyped-def]
    """Score a candidate whose way is known, and choose it if it is the best so far."""
    x, y = _centre(land.flat[f], rules)
    total = gains[f] - rules.way * way_m
    total = _score(total, x, y, soonest, heard, claims, me, choice, rules)
    if total > choice.score or (total == choice.score and f < choice.at):
        choice.score = total
        choice.way_m = way_m
        choice.at = f


@kernel
def choose_by_criteria(own, heard, teams, land, memory, fixed, rules, step, asked):  # type: ignore[no-untyped-def]
    """Choose a destination for each leader of a batch, see :class:`MultiCriteria`.

    Args:
        own: MIND[N]; of it a leader's own record is read.
        heard: BEACON[N], what all leaders of the batch have heard.
        teams: int64[2, M], see ``Batch``; land, memory: see ``Batch``.
        fixed: see ``Fixed``; its field and queues are scratch.
        rules: CRITERIA[1]; step: the current step.
        asked: BY_CRITERIA[L], written.
    """
    rules = rules[0]
    flat = land.flat
    size = flat.shape[0]
    heads, chain = _index_blocks(flat, rules)
    claims = _gather_claims(heard, rules, step)
    gains = np.full(size, np.nan)
    members = np.empty(heard.shape[0] + 1, dtype=np.int64)
    at = np.empty(size, dtype=np.int64)
    entry = np.empty(size, dtype=np.int64)
    most = np.empty(size)
    least_m = np.empty(size)
    soonest = np.empty(size)
    ends = np.empty((2, 2), dtype=np.int64)
    source = np.empty(1, dtype=np.int64)
    block = rules.block
    down = (rules.rows + block - 1) // block
    across = (rules.columns + block - 1) // block
    block_m = block * rules.cell_m
    for c in range(asked.shape[0]):
        choice = asked[c]
        i = choice.leader
        me = own[i]
        avoided = memory.avoided[i]
        given_up = memory.given_up[i]
        crew = members[: _list_members(teams, me.team, i, members)]
        here = cell_of(me.x_m, me.y_m, rules)
        source[0] = get_out(land.status, here, rules.rows, rules.columns, rules.exit_cells)
        from_x, from_y = _centre(source[0], rules)
        # The blocks in which the team's members are.
        top, bottom, left, right = down, -1, across, -1
        for j in crew:
            cell = cell_of(heard[j].x_m, heard[j].y_m, rules)
            row = cell // rules.columns // block
            col = cell % rules.columns // block
            top, bottom = min(top, row), max(bottom, row)
            left, right = min(left, col), max(right, col)
        rings = max(top, left, down - 1 - bottom, across - 1 - right) + 1
        kept = math.sqrt(choice.kept_x**2 + choice.kept_y**2)
        high = rules.most_gain + abs(rules.ahead) * kept
        slack_m = (rules.entry_cells + 2.0) * rules.cell_m
        stray_m = math.sqrt((from_x - me.x_m) ** 2 + (from_y - me.y_m) ** 2)
        begin_walk(source, fixed.field, fixed.queues, ends)
        choice.at = -1
        choice.score = -np.inf
        n = 0
        ring = 0
        walked = 0
        goes_on = True
        while True:
            # Which may score most: those that wait for a way, or those of the next ring?
            waiting = -np.inf
            for k in range(n):
                way_m = max(least_m[k], min(walked / 1000.0, NO_WAY_M))
                waiting = max(waiting, most[k] - rules.way * way_m)
            coming = -np.inf
            if ring < rings:
                away_m = max(0, ring - 1) * block_m
                way_m = rules.least_m * max(0.0, away_m - stray_m - slack_m)
                coming = high - rules.front * away_m - rules.way * min(way_m, NO_WAY_M)
            if max(waiting, coming) == -np.inf or max(waiting, coming) < choice.score - ROUNDING:
                break
            if coming >= waiting:
                for row in range(max(0, top - ring), min(down, bottom + ring + 1)):
                    inner = top - ring < row < bottom + ring
                    col = left - ring
                    while col <= right + ring:
                        if 0 <= col < across:
                            f = heads[row * across + col]
                            while f >= 0:
                                if (choice.routed < 0 or land.routed[choice.routed, f]) and (
                                    is_offered(flat[f], avoided, given_up, rules, step)
                                ):
                                    if np.isnan(gains[f]):
                                        gains[f] = _gain(land.words, flat[f], fixed, rules)
                                    x, y = _centre(flat[f], rules)
                                    at[n] = f
                                    soonest[n] = _soonest(x, y, crew, heard, fixed.turns, rules)
                                    most[n] = _score(
                                        gains[f], x, y, soonest[n], heard, claims, me, choice,
                                        rules,
                                    )  # fmt: skip
                                    off = math.sqrt((x - from_x) ** 2 + (y - from_y) ** 2)
                                    least_m[n] = min(
                                        NO_WAY_M, rules.least_m * max(0.0, off - slack_m)
                                    )
                                    entry[n] = NOT_YET
                                    n += 1
                                f = chain[f]
                        # Within a row between the outermost ones only its two ends are new.
                        col += right - left + 2 * ring if inner and ring > 0 else 1
                ring += 1
                continue
            if goes_on:
                walked += STRIDE_MM
                goes_on = walk_on(
                    land.status, fixed.edge, fixed.lengths, 0, fixed.field, fixed.queues, ends,
                    walked,
                )  # fmt: skip
            k = 0
            while k < n:
                f = at[k]
                if most[k] - rules.way * least_m[k] < choice.score - ROUNDING:
                    length = np.int64(-1)
                else:
                    if entry[k] == NOT_YET:
                        entry[k] = enter(
                            land.status, flat[f], rules.rows, rules.columns, rules.entry_cells
                        )
                    length = FAR if entry[k] < 0 else fixed.field[entry[k], 0]
                    if entry[k] >= 0 and length > walked and goes_on:
                        k += 1
                        continue
                    way_m = length / 1000.0
                    if length == FAR:
                        x, y = _centre(flat[f], rules)
                        dx = x - me.x_m
                        dy = y - me.y_m
                        way_m = NO_WAY_M + np.sqrt(dx * dx + dy * dy)
                    _settle(
                        f, way_m, soonest[k], gains, land, heard, claims, me, choice, rules
                    )  # fmt: skip
                n -= 1
                at[k] = at[n]
                entry[k] = entry[n]
                most[k] = most[n]
                least_m[k] = least_m[n]
                soonest[k] = soonest[n]
        end_walk(fixed.field, fixed.queues, ends)
        routed = choice.routed >= 0
        if routed:
            choice.doubts = keeps_doubting(flat, land.routed[choice.routed], given_up, rules)
            choice.offered = 0
            for f in range(size):
                choice.offered += land.routed[choice.routed, f] and is_offered(
                    flat[f], avoided, given_up, rules, step
                )
        else:
            choice.offered = count_offered(land.status, size, avoided, given_up, rules, step)
