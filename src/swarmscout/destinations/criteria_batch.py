"""The weighted sum of ``MultiCriteria`` for all leaders of a batch: the same choices, found sooner.

``weigh`` in ``multi_criteria`` scores every candidate. Here candidates are taken in by rings of
blocks round the team, and the search for ways goes on from the leader, only as long as a candidate
that has not been scored may still be the best: its score cannot be higher than its gains allow,
less what the straight line costs. So a decision costs what is near, however large the map is. A
score is computed by the same expressions in the same order as in ``weigh``, so it is the same
number.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from swarmscout.core.cells import cell_of, centre
from swarmscout.core.jit import inlined, kernel
from swarmscout.destinations.batch import ASKED, Land, Memory
from swarmscout.destinations.claims import Claims, claim_block, claim_cost, gather_claims, own_share
from swarmscout.destinations.criteria_blocks import Blocks, Fixed, make_blocks, open_block
from swarmscout.destinations.criteria_seeker import (
    bound_block,
    bound_ring,
    least_way,
    list_members,
    make_seeker,
    own_claims,
    soonest,
    toward,
)
from swarmscout.destinations.offers import count_offered, is_offered, keeps_doubting
from swarmscout.destinations.path_lengths import NO_WAY_M
from swarmscout.destinations.walking import FAR, begin_walk, end_walk, walk_on
from swarmscout.mapping.footprint import enter, get_out

__all__ = ["BY_CRITERIA", "choose_by_criteria"]

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

NOT_YET = -2


class Scene(NamedTuple):
    """What leaders of a batch have in common: see the modules of these."""

    heard: NDArray[np.void]
    land: Land
    memory: Memory
    fixed: Fixed
    blocks: Blocks
    claims: Claims


WAITING = np.dtype(
    [
        ("at", "i8"),  # which candidate
        ("entry", "i8"),  # where a body drives to get there, -1: nowhere; NOT_YET: not looked up
        ("most", "f8"),  # what it scores with a way of no length
        ("least_m", "f8"),  # a lower bound of its way
        ("soonest", "f8"),  # see ``soonest``
    ],
    align=True,
)
"""A candidate whose way is not known yet."""


class Pending(NamedTuple):
    """What a leader's search still has to look at.

    Attributes:
        blocks: int64[B], blocks whose candidates have not been taken; bounds: float64[B], what
            those score at most.
        waiting: WAITING[F + 1].
    """

    blocks: NDArray[np.int64]
    bounds: NDArray[np.float64]
    waiting: NDArray[np.void]


@inlined
def _list_ring(ring, seeker, blocks, found):  # type: ignore[no-untyped-def]
    """List the blocks with candidates in a ring round the team; returns how many."""
    n = 0
    for row in range(max(0, seeker.top - ring), min(blocks.down, seeker.bottom + ring + 1)):
        inner = ring > 0 and seeker.top - ring < row < seeker.bottom + ring
        # Within a row between the outermost ones only its two ends are new.
        stride = seeker.right - seeker.left + 2 * ring if inner else 1
        for col in range(seeker.left - ring, seeker.right + ring + 1, stride):
            if 0 <= col < blocks.across and blocks.heads[row * blocks.across + col] >= 0:
                found[n] = row * blocks.across + col
                n += 1
    return n


@inlined
def _take_block(b, n, waiting, seeker, scene, rules, step, choice):  # type: ignore[no-untyped-def]
    """Append the candidates of a block that may be the best; returns how many wait then."""
    land, blocks = scene.land, scene.blocks
    avoided = scene.memory.avoided[seeker.leader]
    given_up = scene.memory.given_up[seeker.leader]
    f = blocks.heads[b]
    while f >= 0:
        cell = land.flat[f]
        routed = choice.routed < 0 or land.routed[choice.routed, f]
        if routed and is_offered(cell, avoided, given_up, rules, step):
            x, y = centre(cell, rules)
            one = waiting[n]
            one.at = f
            one.entry = NOT_YET
            one.least_m = least_way(x, y, 0.0, seeker, rules)
            one.soonest = soonest(x, y, seeker, scene.heard, scene.fixed.turns, rules)
            one.most = (
                blocks.gains[f] - blocks.crowding[f] - rules.front * one.soonest
                + own_share(x, y, 0.0, seeker.own_x, seeker.own_y, rules)
                + toward(x, y, seeker, rules)
            )  # fmt: skip
            n += one.most - rules.way * one.least_m >= choice.score - ROUNDING
        f = blocks.chain[f]
    return n


@inlined
def _settle(f, way_m, front_m, seeker, scene, rules, choice):  # type: ignore[no-untyped-def]
    """Score a candidate whose way is known, as ``weigh`` does, and choose it if it is the best."""
    heard, claims = scene.heard, scene.claims
    x, y = centre(scene.land.flat[f], rules)
    total = scene.blocks.gains[f] - rules.way * way_m
    total -= rules.front * front_m
    row, col = claim_block(x, y, rules)
    b = row * claims.across + col
    for k in range(claims.begins[b], claims.begins[b + 1]):
        j = claims.leaders[k]
        if j == seeker.leader or heard[j].team == seeker.team:
            continue
        dx = x - claims.x_m[k]
        dy = y - claims.y_m[k]
        apart = np.sqrt(dx * dx + dy * dy)
        total -= claim_cost(apart, rules)
    total += toward(x, y, seeker, rules)
    if total > choice.score or (total == choice.score and f < choice.at):
        choice.score = total
        choice.way_m = way_m
        choice.at = f


@inlined
def _settle_reached(walked, n, waiting, seeker, scene, rules, choice):  # type: ignore[no-untyped-def]
    """Score the candidates with ways up to `walked` mm; returns how many are left waiting."""
    land = scene.land
    k = 0
    while k < n:
        one = waiting[k]
        if one.most - rules.way * one.least_m >= choice.score - ROUNDING:
            cell = land.flat[one.at]
            if one.entry == NOT_YET:
                one.entry = enter(land.status, cell, rules.rows, rules.columns, rules.entry_cells)
            length = FAR if one.entry < 0 else scene.fixed.field[one.entry, 0]
            if one.entry >= 0 and length > walked:
                k += 1
                continue
            way_m = length / 1000.0
            if length == FAR:
                x, y = centre(cell, rules)
                dx = x - seeker.x_m
                dy = y - seeker.y_m
                way_m = NO_WAY_M + np.sqrt(dx * dx + dy * dy)
            _settle(one.at, way_m, one.soonest, seeker, scene, rules, choice)
        n -= 1
        last = waiting[n]
        one.at = last.at
        one.entry = last.entry
        one.most = last.most
        one.least_m = last.least_m
        one.soonest = last.soonest
    return n


@inlined
def _highest(bounds, n):  # type: ignore[no-untyped-def]
    """The highest of the first n bounds, and its place; (-inf, -1) of none."""
    highest = -np.inf
    at = -1
    for k in range(n):
        if bounds[k] > highest:
            highest = bounds[k]
            at = k
    return highest, at


@inlined
def _highest_waiting(waiting, n, walked, rules):  # type: ignore[no-untyped-def]
    """The most that a candidate scores whose way is not known, but longer than `walked` mm."""
    highest = -np.inf
    for k in range(n):
        way_m = max(waiting[k].least_m, min(walked / 1000.0, NO_WAY_M))
        highest = max(highest, waiting[k].most - rules.way * way_m)
    return highest


@inlined
def _search(seeker, scene, rules, step, pending, ends, choice):  # type: ignore[no-untyped-def]
    """Find the best candidate for one leader: what may score most is looked at next."""
    land, fixed, blocks = scene.land, scene.fixed, scene.blocks
    rings = 1 + max(
        seeker.top, seeker.left, blocks.down - 1 - seeker.bottom, blocks.across - 1 - seeker.right
    )
    ring = 0
    listed = 0
    n = 0
    walked = 0
    while True:
        by_way = _highest_waiting(pending.waiting, n, walked, rules)
        by_block, at = _highest(pending.bounds, listed)
        by_ring = bound_ring(ring, seeker, rules) if ring < rings else -np.inf
        highest = max(by_way, by_block, by_ring)
        if highest == -np.inf or highest < choice.score - ROUNDING:
            break
        if by_ring == highest:
            known = listed
            listed += _list_ring(ring, seeker, blocks, pending.blocks[known:])
            for k in range(known, listed):
                b = pending.blocks[k]
                pending.bounds[k] = bound_block(b, seeker, scene.heard, blocks, scene.claims, rules)
            ring += 1
        elif by_block == highest:
            b = pending.blocks[at]
            if not blocks.is_open[b]:
                open_block(b, blocks, land, fixed, scene.claims, rules)
                pending.bounds[at] = bound_block(
                    b, seeker, scene.heard, blocks, scene.claims, rules
                )
                continue
            n = _take_block(b, n, pending.waiting, seeker, scene, rules, step, choice)
            listed -= 1
            pending.blocks[at] = pending.blocks[listed]
            pending.bounds[at] = pending.bounds[listed]
        else:
            walked += STRIDE_MM
            if not walk_on(
                land.status, fixed.edge, fixed.lengths, 0, fixed.field, fixed.queues, ends, walked
            ):
                walked = FAR
        # The search may have passed those of a new block, too.
        n = _settle_reached(walked, n, pending.waiting, seeker, scene, rules, choice)


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
    robots = heard.shape[0]
    size = land.flat.shape[0]
    blocks = make_blocks(land.flat, rules)
    speakers, claims = gather_claims(heard, rules, step)
    scene = Scene(heard, land, memory, fixed, blocks, claims)
    members = np.empty(robots + 1, dtype=np.int64)
    own_x = np.empty(robots)
    own_y = np.empty(robots)
    pending = Pending(
        np.empty(blocks.heads.shape[0], dtype=np.int64), np.empty(blocks.heads.shape[0]),
        np.empty(size + 1, dtype=WAITING),
    )  # fmt: skip
    ends = np.empty((2, 2), dtype=np.int64)
    source = np.empty(1, dtype=np.int64)
    for a in range(asked.shape[0]):
        choice = asked[a]
        i = choice.leader
        me = own[i]
        crew = members[: list_members(teams, me.team, i, members)]
        n = own_claims(speakers, heard, i, me.team, own_x, own_y, rules)
        here = cell_of(me.x_m, me.y_m, rules)
        source[0] = get_out(land.status, here, rules.rows, rules.columns, rules.exit_cells)
        seeker = make_seeker(
            choice, me, crew, own_x[:n], own_y[:n], heard, source[0], blocks, rules
        )  # fmt: skip
        choice.at = -1
        choice.score = -np.inf
        begin_walk(source, fixed.field, fixed.queues, ends)
        _search(seeker, scene, rules, step, pending, ends, choice)
        end_walk(fixed.field, fixed.queues, ends)
        avoided = memory.avoided[i]
        given_up = memory.given_up[i]
        if choice.routed < 0:
            choice.offered = count_offered(land.status, size, avoided, given_up, rules, step)
            continue
        routed = land.routed[choice.routed]
        choice.doubts = keeps_doubting(land.flat, routed, given_up, rules)
        choice.offered = 0
        for f in range(size):
            choice.offered += routed[f] and is_offered(land.flat[f], avoided, given_up, rules, step)
