"""A leader that chooses by criteria: what its choice depends on, and bounds of scores for it."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from swarmscout.core.cells import cell_of, centre
from swarmscout.core.jit import allocating, inlined
from swarmscout.destinations.claims import crowding, own_share
from swarmscout.destinations.criteria_blocks import middle
from swarmscout.destinations.path_lengths import NO_WAY_M

__all__ = [
    "Seeker",
    "bound_block",
    "bound_ring",
    "least_way",
    "list_members",
    "make_seeker",
    "own_claims",
    "soonest",
    "toward",
]


class Seeker(NamedTuple):
    """A leader that chooses.

    Attributes:
        leader, team: its numbers. x_m, y_m: where it believes to be.
        members: int64[n], robots of its team that it hears, itself too.
        own_x, own_y: float64[m], destinations of its own team, which do not crowd it.
        from_x, from_y: where its ways begin. stray_m: how far that is from it.
        kept_x, kept_y: the team's direction so far. ahead: what that is worth at most.
        top, bottom, left, right: the blocks in which its members are.
    """

    leader: int
    team: int
    x_m: float
    y_m: float
    members: NDArray[np.int64]
    own_x: NDArray[np.float64]
    own_y: NDArray[np.float64]
    from_x: float
    from_y: float
    stray_m: float
    kept_x: float
    kept_y: float
    ahead: float
    top: int
    bottom: int
    left: int
    right: int


@inlined
def list_members(teams, team, leader, members):  # type: ignore[no-untyped-def]
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
def own_claims(speakers, heard, leader, team, x_m, y_m, rules):  # type: ignore[no-untyped-def]
    """List the destinations of a leader's own team, which do not crowd it; returns how many."""
    n = 0
    for j in speakers:
        if j == leader or heard[j].team == team:
            x_m[n], y_m[n] = centre(heard[j].destination, rules)
            n += 1
    return n


@allocating
def make_seeker(choice, me, members, own_x, own_y, heard, source, blocks, rules):  # type: ignore[no-untyped-def]
    """What a leader's decision depends on."""
    from_x, from_y = centre(source, rules)
    top, bottom, left, right = blocks.down, -1, blocks.across, -1
    for j in members:
        cell = cell_of(heard[j].x_m, heard[j].y_m, rules)
        row = cell // rules.columns // rules.block
        col = cell % rules.columns // rules.block
        top, bottom = min(top, row), max(bottom, row)
        left, right = min(left, col), max(right, col)
    stray_m = math.sqrt((from_x - me.x_m) ** 2 + (from_y - me.y_m) ** 2)
    ahead = abs(rules.ahead) * math.sqrt(choice.kept_x**2 + choice.kept_y**2)
    return Seeker(
        choice.leader, me.team, me.x_m, me.y_m, members, own_x, own_y, from_x, from_y, stray_m,
        choice.kept_x, choice.kept_y, ahead, top, bottom, left, right,
    )  # fmt: skip


@inlined
def soonest(x, y, seeker, heard, turns, rules):  # type: ignore[no-untyped-def]
    """The distance and turn of the member that arrives first at a point, as in ``weigh``."""
    soonest = np.inf
    for j in seeker.members:
        dx = x - heard[j].x_m
        dy = y - heard[j].y_m
        length = np.sqrt(dx * dx + dy * dy)
        cos = turns[heard[j].heading, 0]
        sin = turns[heard[j].heading, 1]
        along = (dx * cos + dy * sin) / length if length > 0.0 else 1.0
        soonest = min(soonest, length + rules.turn_m * np.sqrt(max(0.0, 2.0 - 2.0 * along)))
    return soonest


@inlined
def toward(x, y, seeker, rules):  # type: ignore[no-untyped-def]
    """What a point is worth for lying in the team's direction so far, as in ``weigh``."""
    dx = x - seeker.x_m
    dy = y - seeker.y_m
    length = np.sqrt(dx * dx + dy * dy)
    if length > 0.0:
        return rules.ahead * (dx * seeker.kept_x + dy * seeker.kept_y) / length
    return 0.0


@inlined
def least_way(x, y, nearer, seeker, rules):  # type: ignore[no-untyped-def]
    """No way to a candidate at a point, or so much nearer, is shorter than this."""
    off = math.sqrt((x - seeker.from_x) ** 2 + (y - seeker.from_y) ** 2) - nearer
    slack_m = (rules.entry_cells + 2.0) * rules.cell_m
    return min(NO_WAY_M, rules.least_m * max(0.0, off - slack_m))


@inlined
def bound_ring(ring, seeker, rules):  # type: ignore[no-untyped-def]
    """No candidate in a ring of blocks, or outside it, scores more."""
    away_m = max(0, ring - 1) * rules.block * rules.cell_m
    slack_m = seeker.stray_m + (rules.entry_cells + 2.0) * rules.cell_m
    way_m = min(NO_WAY_M, rules.least_m * max(0.0, away_m - slack_m))
    return rules.most_gain + seeker.ahead - rules.front * away_m - rules.way * way_m


@inlined
def bound_block(b, seeker, heard, blocks, claims, rules):  # type: ignore[no-untyped-def]
    """No candidate in a block scores more."""
    x, y, half_m = middle(b, blocks, rules)
    if np.isnan(blocks.worth[b]):
        blocks.worth[b] = rules.most_gain - crowding(x, y, half_m, claims, rules)
    away2 = np.inf
    for j in seeker.members:
        dx = x - heard[j].x_m
        dy = y - heard[j].y_m
        away2 = min(away2, dx * dx + dy * dy)
    away_m = max(0.0, math.sqrt(away2) - half_m)
    return (
        blocks.worth[b] + own_share(x, y, half_m, seeker.own_x, seeker.own_y, rules)
        + seeker.ahead - rules.front * away_m - rules.way * least_way(x, y, half_m, seeker, rules)
    )  # fmt: skip
