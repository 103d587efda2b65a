"""The kernel that adds other robots' evidence to one robot's map."""

from __future__ import annotations

from swarmscout.core.jit import kernel

__all__ = ["merge_versions", "take_in"]


@kernel
def merge_versions(known, length, links, merged):  # type: ignore[no-untyped-def]
    """What everybody knows after one round of contacts, all at the same time.

    Args:
        known: int64[N, N], before; length: int64[N], how long each robot's own log is.
        links: bool[N, N]: links[i, j] says that i hears j.
        merged: int64[N, N], written: after.
    """
    robots = known.shape[0]
    for i in range(robots):
        for k in range(robots):
            merged[i, k] = known[i, k]
        merged[i, i] = length[i]
        for j in range(robots):
            if j == i or not links[i, j]:
                continue
            for k in range(robots):
                heard = length[j] if k == j else known[j, k]
                merged[i, k] = max(merged[i, k], heard)


@kernel
def take_in(  # type: ignore[no-untyped-def]
    low, high, ends, cells, increments, evidence, stamps, lowest, highest, changed, log_odds
):  # fmt: skip
    """Add what one robot has newly heard of all logs to its map.

    Args:
        low, high: int64[N]: of robot k's log the steps low[k] + 1 … high[k] are new.
        ends: int64[steps + 1, N], where the entries of each step and robot end; row 0 is 0.
        cells, increments: int32[entries], by step and then by robot.
        evidence: int64[C], the robot's map, brought up to date.
        stamps: int64[C + 1, 2], scratch: which call touched a cell last, its log-odds before;
            the last row counts calls.
        lowest, highest: saturation of log-odds when read.
        changed, log_odds: int32[C], written: cells whose log-odds as read changed, and these.

    Returns:
        How many cells changed as read.
    """
    robots = low.shape[0]
    size = evidence.shape[0]
    stamps[size, 0] += 1
    now = stamps[size, 0]
    touched = 0
    for k in range(robots):
        for step in range(low[k] + 1, high[k] + 1):
            begin = ends[step, k - 1] if k else ends[step - 1, robots - 1]
            for e in range(begin, ends[step, k]):
                cell = cells[e]
                if stamps[cell, 0] != now:
                    stamps[cell, 0] = now
                    stamps[cell, 1] = min(highest, max(lowest, evidence[cell]))
                    changed[touched] = cell
                    touched += 1
                evidence[cell] += increments[e]
    n = 0
    for t in range(touched):
        cell = changed[t]
        read = min(highest, max(lowest, evidence[cell]))
        if read != stamps[cell, 1]:
            changed[n] = cell
            log_odds[n] = read
            n += 1
    return n
