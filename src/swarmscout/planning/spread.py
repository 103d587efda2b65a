"""The search itself: costs spread from seeds over the grid until the starts are reached.

Most of a large swarm's time is spent here. So cells wait in buckets of nearly equal cost instead of
a heap: within a bucket they come in any order, and one that turns out cheaper after it was settled
is settled again. Once all buckets up to the farthest robot's are empty, every cost up to there is
the least.

Sources: Hart, Nilsson, Raphael (1968), "A formal basis for the heuristic determination of minimum
cost paths"; Dial (1969), "Algorithm 360: shortest-path forest with topological ordering".
"""

from __future__ import annotations

import numpy as np

from swarmscout.core.jit import inlined
from swarmscout.planning.search_memory import BUCKETS
from swarmscout.planning.tolls import unpadded

__all__ = ["FLAG_BITS", "SETTLED", "START", "flags_of", "read_off", "spread"]

# Flags of a node in the running search; the search's number stands above them.
REACHED, SETTLED, START, OPEN, SEED = 1, 2, 4, 8, 16
FLAG_BITS = 5

DIAGONAL_FIRST = 4
# Orthogonal neighbours first, then diagonal ones: the fixed order among equally good routes.
ROW_STEP = np.array([0, 1, 0, -1, 1, 1, -1, -1], dtype=np.int64)
COL_STEP = np.array([1, 0, -1, 0, 1, -1, -1, 1], dtype=np.int64)
# Which orthogonal neighbours (as bits) a diagonal move passes between.
BETWEEN = np.array([0, 0, 0, 0, 0b0011, 0b0110, 0b1100, 0b1001], dtype=np.int64)


@inlined
def _put(nodes, buckets, cell, bucket, current):  # type: ignore[no-untyped-def]
    """Queue a cell; what is too far ahead waits in the last bucket."""
    slot = min(bucket, current + BUCKETS - 1) & (BUCKETS - 1)
    first = buckets[slot]
    node = nodes[cell]
    node.before = -1 - slot
    node.after = first
    node.bucket = bucket
    if first >= 0:
        nodes[first].before = cell
    buckets[slot] = cell


@inlined
def _take(nodes, buckets, cell):  # type: ignore[no-untyped-def]
    """Remove a cell from its bucket."""
    before = nodes[cell].before
    after = nodes[cell].after
    if before >= 0:
        nodes[before].after = after
    else:
        buckets[-1 - before] = after
    if after >= 0:
        nodes[after].before = before


@inlined
def _way_out(row, col, box, straight, diagonal, least):  # type: ignore[no-untyped-def]
    """The least that a way from a cell to the nearest cell of a box can cost."""
    dr = max(box[0] - row, 0, row - box[1])
    dc = max(box[2] - col, 0, col - box[3])
    low = min(dr, dc)
    return (low * diagonal + (max(dr, dc) - low) * straight) * 2 * least


@inlined
def flags_of(node, now):  # type: ignore[no-untyped-def]
    """The flags of a cell in search number `now`."""
    return node.mark & ((1 << FLAG_BITS) - 1) if node.mark >> FLAG_BITS == now else 0


@inlined
def _seed(nodes, buckets, seeds, costs, box, width, search):  # type: ignore[no-untyped-def]
    """Queue the seeds at their costs; returns the first bucket and the number of open cells."""
    straight, diagonal, least = search.straight, search.diagonal, search.base + search.least
    current = 1 << 40
    for a in range(seeds.shape[0]):
        out = _way_out(seeds[a] // width, seeds[a] % width, box, straight, diagonal, least)
        current = min(current, (costs[a] + out) >> search.bits)
    n = 0
    for a in range(seeds.shape[0]):
        seed = seeds[a]
        flags = flags_of(nodes[seed], search.count)
        if flags & OPEN:
            if nodes[seed].cost <= costs[a]:
                continue
            _take(nodes, buckets, seed)
            n -= 1
        nodes[seed].mark = (search.count << FLAG_BITS) | flags | REACHED | OPEN | SEED
        nodes[seed].cost = costs[a]
        out = _way_out(seed // width, seed % width, box, straight, diagonal, least)
        _put(nodes, buckets, seed, (costs[a] + out) >> search.bits, current)
        n += 1
    return current, n


@inlined
def spread(toll, nodes, buckets, seeds, costs, waiting, box, search):  # type: ignore[no-untyped-def]
    """Settle cells from the seeds until `waiting` starts, and all that cost no more, are."""
    straight, diagonal, bits = search.straight, search.diagonal, search.bits
    least, now, width = search.base + search.least, search.count, search.columns + 2
    current, n = _seed(nodes, buckets, seeds, costs, box, width, search)
    bound = -1
    while n > 0:
        cell = buckets[current & (BUCKETS - 1)]
        if cell < 0:
            current += 1
            continue
        if waiting <= 0 and current > bound:
            break
        _take(nodes, buckets, cell)
        node = nodes[cell]
        if node.bucket > current:
            _put(nodes, buckets, cell, node.bucket, current)
            continue
        n -= 1
        flags = node.mark
        node.mark = (flags | SETTLED) & ~OPEN
        cost = node.cost
        here = toll[cell]
        if flags & START:
            if not flags & SETTLED:
                waiting -= 1
            bound = max(bound, cost >> bits)
            if here < 0:
                # A robot may leave a closed cell, but no route leads through it.
                continue
        here = abs(here)
        walls = 0
        row = cell // width
        col = cell - row * width
        for d in range(8):
            new = cell + ROW_STEP[d] * width + COL_STEP[d]
            price = toll[new]
            near = nodes[new]
            flags = flags_of(near, now)
            if price < 0:
                walls |= 1 << d
                if not flags & START:
                    continue
                price = -price
            length = straight
            if d >= DIAGONAL_FIRST:
                if walls & BETWEEN[d]:
                    continue
                length = diagonal
            total = cost + length * (here + price)
            if not flags & REACHED or total < near.cost:
                if flags & OPEN:
                    _take(nodes, buckets, new)
                else:
                    n += 1
                near.mark = (now << FLAG_BITS) | (flags & ~SEED) | REACHED | OPEN
                near.cost = total
                new_row, new_col = row + ROW_STEP[d], col + COL_STEP[d]
                f = total + _way_out(new_row, new_col, box, straight, diagonal, least)
                _put(nodes, buckets, new, f >> bits, current)
    while n > 0:
        cell = buckets[current & (BUCKETS - 1)]
        while cell >= 0:
            cell = nodes[cell].after
            n -= 1
        buckets[current & (BUCKETS - 1)] = -1
        current += 1


@inlined
def read_off(price, toll, nodes, search, start, route):  # type: ignore[no-untyped-def]
    """Follow optimal moves from a settled start to a seed.

    Returns:
        The number of cells (-1: there is no way), the seed, and the length in mm, of which what is
        not known to be free counts twice.
    """
    now, width = search.count, search.columns + 2
    n = 0
    way_mm = 0
    cell = start
    while not nodes[cell].mark & SEED:
        here = abs(toll[cell])
        walls = 0
        for d in range(8):
            new = cell + ROW_STEP[d] * width + COL_STEP[d]
            if toll[new] < 0:
                walls |= 1 << d
                continue
            if walls & BETWEEN[d] or not flags_of(nodes[new], now) & REACHED:
                continue
            length = search.diagonal if d >= DIAGONAL_FIRST else search.straight
            if nodes[new].cost + length * (here + toll[new]) == nodes[cell].cost:
                cell = new
                break
        else:
            return -1, cell, 0
        flat = unpadded(cell, search.columns)
        way_mm += length if price[flat] < search.proven else 2 * length
        if n < route.shape[0]:
            route[n] = flat
        n += 1
    return n, cell, way_mm
