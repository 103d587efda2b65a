"""Claims: where other teams head, as robots have heard, looked up near a point inside kernels."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from swarmscout.core.cells import centre
from swarmscout.core.jit import allocating, inlined
from swarmscout.minds.modes import is_on_task

__all__ = ["Claims", "claim_block", "claim_cost", "crowding", "gather_claims", "own_share"]


@inlined
def claim_block(x, y, rules):  # type: ignore[no-untyped-def]
    """Row and column of a block of destinations, counted from 1."""
    return (
        int(math.floor((y - rules.origin_y_m) / rules.claim_m)) + 1,
        int(math.floor((x - rules.origin_x_m) / rules.claim_m)) + 1,
    )


class Claims(NamedTuple):
    """Other teams' destinations, listed for each block in whose reach they may lie.

    Attributes:
        begins: int64[blocks + 1], where the list of each block begins.
        leaders: int64[9 D], who heads there, ascending in each list; x_m, y_m: float64[9 D], where.
        across: the number of blocks in a row, those at the rim included.
    """

    begins: NDArray[np.int64]
    leaders: NDArray[np.int64]
    x_m: NDArray[np.float64]
    y_m: NDArray[np.float64]
    across: int


@allocating
def gather_claims(heard, rules, step):  # type: ignore[no-untyped-def]
    """List the destinations that leaders claim, as last heard: each in its block and those beside.

    Returns:
        int64[D], the leaders, ascending; and Claims.
    """
    down = int(math.floor(rules.rows * rules.cell_m / rules.claim_m)) + 3
    across = int(math.floor(rules.columns * rules.cell_m / rules.claim_m)) + 3
    begins = np.zeros(down * across + 2, dtype=np.int64)
    speakers = np.empty(heard.shape[0], dtype=np.int64)
    n = 0
    for j in range(heard.shape[0]):
        other = heard[j]
        recent = other.step >= 0 and other.step >= step - rules.silence_steps
        if not (recent and other.leader == j and is_on_task(other.mode)) or other.destination < 0:
            continue
        speakers[n] = j
        n += 1
        x, y = centre(other.destination, rules)
        row, col = claim_block(x, y, rules)
        for near_row in range(row - 1, row + 2):
            for near_col in range(col - 1, col + 2):
                begins[near_row * across + near_col + 2] += 1
    for b in range(2, begins.shape[0]):
        begins[b] += begins[b - 1]
    leaders = np.empty(9 * n, dtype=np.int64)
    x_m = np.empty(9 * n)
    y_m = np.empty(9 * n)
    for j in speakers[:n]:
        x, y = centre(heard[j].destination, rules)
        row, col = claim_block(x, y, rules)
        for near_row in range(row - 1, row + 2):
            for near_col in range(col - 1, col + 2):
                b = near_row * across + near_col + 1
                leaders[begins[b]] = j
                x_m[begins[b]] = x
                y_m[begins[b]] = y
                begins[b] += 1
    return speakers[:n], Claims(begins, leaders, x_m, y_m, across)


@inlined
def claim_cost(apart, rules):  # type: ignore[no-untyped-def]
    """What one destination of another team costs at a distance, as in ``weigh``."""
    return rules.apart * (1.0 - apart / rules.apart_m) if apart < rules.apart_m else 0.0


@inlined
def crowding(x, y, farther, claims, rules):  # type: ignore[no-untyped-def]
    """What all claims together cost at a point, were they so much farther away."""
    row, col = claim_block(x, y, rules)
    b = row * claims.across + col
    cost = 0.0
    for k in range(claims.begins[b], claims.begins[b + 1]):
        dx = x - claims.x_m[k]
        dy = y - claims.y_m[k]
        apart = np.sqrt(dx * dx + dy * dy) + farther
        cost += claim_cost(apart, rules)
    return cost


@inlined
def own_share(x, y, nearer, own_x, own_y, rules):  # type: ignore[no-untyped-def]
    """What the team's own claims contribute to :func:`_crowding`, were they so much nearer."""
    cost = 0.0
    for k in range(own_x.shape[0]):
        dx = x - own_x[k]
        dy = y - own_y[k]
        apart = max(0.0, np.sqrt(dx * dx + dy * dy) - nearer)
        cost += claim_cost(apart, rules)
    return cost
