"""When a team needs a new destination, and how members learn of it.

"After any member reaches the assigned target, the leader selects a new target" (paper, "Task
description"). Deviation: the scenario ``paper`` also drops a destination that is no frontier any
more or overdue, and a team avoids for a while what it gave up; ``paper-literal`` does not.
"""

from __future__ import annotations

import math

from swarmscout.core.enums import (
    CHARGE,
    DROP,
    NO_CAUSE,
    NONE_YET,
    NOT_FRONTIER,
    OVERDUE,
    REACHED,
    UNREACHABLE,
)
from swarmscout.core.jit import inlined, kernel
from swarmscout.minds.minds import DESTINATION, DUE_AT, LEADER, MODE, NEEDS, STEP, TEAM

__all__ = ["due_step", "find_stale", "share_destinations"]


def due_step(step: int, distance_m: float, forward_m: float, factor: float, extra: int) -> int:
    """The step after which a destination chosen now is overdue.

    Args:
        step: the current step.
        distance_m: straight distance to the destination; forward_m: length of a move.
        factor, extra: overdue after `factor` times the straight time plus `extra` steps.
    """
    return step + math.ceil(factor * distance_m / forward_m) + extra


@inlined
def _give_up(avoided, avoided_next, i, cell, until):  # type: ignore[no-untyped-def]
    slot = avoided_next[i] % avoided.shape[1]
    avoided[i, slot, 0] = cell
    avoided[i, slot, 1] = until
    avoided_next[i] += 1


@kernel
def find_stale(  # type: ignore[no-untyped-def]
    state, sending, links, heard_state, heard_reading, status, frontier_bit, no_route,
    avoided, avoided_next, ox, oy, cell_m, columns, reach_m, stale_rule, avoid_steps, step,
    events, count,
):  # fmt: skip
    """Each leader looks whether its team needs a new destination; column NEEDS says why.

    Args:
        state, sending, heard_state, heard_reading, avoided, avoided_next: see ``Minds``.
        links: bool[N, N]; not read where all share one listener's row.
        status: uint8[K, C'] and frontier_bit: see ``OccupancyGrids``.
        no_route: bool[N], whether each robot found no route to its destination.
        ox, oy, cell_m, columns: the grid's frame; reach_m: this near is reached.
        stale_rule: also drop what is no frontier any more, or overdue.
        avoid_steps: for so long a team avoids a frontier that it gave up.
        step: the current step; events, count: see ``core.codes``.

    Returns:
        How many leaders need a destination.
    """
    robots = state.shape[0]
    shared = heard_state.shape[0] == 1
    asking = 0
    for i in range(robots):
        state[i, NEEDS] = NO_CAUSE
    # Members report: each compares its own place with its team's destination.
    for i in range(robots):
        if not sending[i] or state[i, DESTINATION] < 0 or state[i, MODE] == CHARGE:
            continue
        leader = state[i, LEADER]
        k = 0 if shared else leader
        if heard_state[k, i, STEP] != step or state[leader, DESTINATION] != state[i, DESTINATION]:
            continue
        cell = state[i, DESTINATION]
        dx = ox + (cell % columns + 0.5) * cell_m - heard_reading[k, i, 0]
        dy = oy + (cell // columns + 0.5) * cell_m - heard_reading[k, i, 1]
        if dx * dx + dy * dy <= reach_m * reach_m:
            state[leader, NEEDS] = REACHED
    for i in range(robots):
        if not sending[i] or state[i, LEADER] != i or state[i, MODE] == CHARGE:
            state[i, NEEDS] = NO_CAUSE
            continue
        cell = state[i, DESTINATION]
        k = 0 if shared else i
        if cell < 0:
            state[i, NEEDS] = NONE_YET
        elif state[i, NEEDS] == REACHED:
            pass
        elif stale_rule and status[k, cell] & frontier_bit == 0:
            state[i, NEEDS] = NOT_FRONTIER
        elif no_route[i]:
            state[i, NEEDS] = UNREACHABLE
        elif stale_rule and step > state[i, DUE_AT]:
            state[i, NEEDS] = OVERDUE
        if state[i, NEEDS] == NO_CAUSE:
            continue
        asking += 1
        if cell < 0:
            continue
        state[i, DESTINATION] = -1
        events[count[0], 0] = DROP
        events[count[0], 1] = i
        events[count[0], 2] = state[i, NEEDS]
        events[count[0], 3] = cell
        count[0] += 1
        if avoid_steps == 0 or state[i, NEEDS] == NOT_FRONTIER:
            continue
        if status[k, cell] & frontier_bit == 0:
            continue
        # The whole team remembers, whoever leads it next.
        for j in range(robots):
            if (
                sending[j]
                and state[j, TEAM] == state[i, TEAM]
                and (shared or j == i or links[j, i])
            ):
                _give_up(avoided, avoided_next, j, cell, step + avoid_steps)
    return asking


@kernel
def share_destinations(state, sending, links, shared):  # type: ignore[no-untyped-def]
    """Members take over their leader's destination as it is now, where they hear it.

    Args:
        state: int64[N, columns], sending: bool[N]: see ``Minds``.
        links: bool[N, N]; not read if `shared`.
        shared: whether everybody hears everybody.
    """
    for i in range(state.shape[0]):
        leader = state[i, LEADER]
        if not sending[i] or leader == i or state[i, MODE] == CHARGE:
            continue
        if state[leader, TEAM] == state[i, TEAM] and (shared or links[i, leader]):
            state[i, DESTINATION] = state[leader, DESTINATION]
            state[i, DUE_AT] = state[leader, DUE_AT]
