"""Leave, join, lead: how robots form teams (paper, "Decentralized team formation").

There is no table of teams. A team is what its members believe: who carries the same team id.
Leaders speak for their teams: a leader's beacon says which robot of another team it would join
with, and two teams join exactly when each of their leaders, as heard, picks a robot of the other
team. No arbiter decides and no order of robots matters. Deviation: the paper merges two teams at
once; without an arbiter each has to hear the other's choice first, which takes a step.

All of a step's rules read the same snapshot, the beacons of this step's exchange. What a rule
changes reaches the members of the same team at once (a second, short exchange); other teams hear
of it in the next step.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from swarmscout.core.enums import CHARGE, JOIN, LEAVE
from swarmscout.core.enums import LEADER as LEADER_EVENT
from swarmscout.core.jit import inlined, kernel
from swarmscout.minds.minds import (
    DESIRED,
    DESTINATION,
    DUE_AT,
    LEADER,
    MODE,
    PICK,
    SIZE,
    STEP,
    TEAM,
    Minds,
)

__all__ = ["Tally", "form_teams", "reorganize"]

ROBOT_BITS = 24


class Tally:
    """Scratch memory: what one listener makes of the beacons, per leader.

    Attributes:
        counts: int64[N, 4]: members, sum of desired sizes, lowest member, lowest desired size.
        pair: float64[N, 3]: the best pair for joining: squared distance, lower id, higher id.
    """

    def __init__(self, robots: int) -> None:
        self.counts = np.zeros((robots, 4), dtype=np.int64)
        self.pair = np.zeros((robots, 3))
        self.recruits = np.zeros(robots, dtype=np.int64)


@inlined
def _mint(step, robot, joined):  # type: ignore[no-untyped-def]
    """A new team's id: when it formed, its lowest robot, and whether by joining or by leaving."""
    return ((step * 2 + joined) << ROBOT_BITS) | robot


@inlined
def _count(heard, step, silence, counts):  # type: ignore[no-untyped-def]
    """Members, sum of desired sizes and lowest member of each leader's team, as heard."""
    robots = heard.shape[0]
    for j in range(robots):
        counts[j, 0] = 0
        counts[j, 1] = 0
        counts[j, 2] = robots
    for j in range(robots):
        if heard[j, STEP] < 0 or heard[j, STEP] < step - silence:
            continue
        leader = heard[j, LEADER]
        # Ids grow with time: a silent robot followed this leader in an earlier team of its.
        if heard[j, TEAM] < heard[leader, TEAM]:
            continue
        counts[leader, 0] += 1
        counts[leader, 1] += heard[j, DESIRED]
        counts[leader, 2] = min(counts[leader, 2], j)


@inlined
def _fits(heard, counts, i, j):  # type: ignore[no-untyped-def]
    """The paper's condition for i and j to join their teams, in both directions.

    n_i + n_j ≤ min(desired_i, mean desired size of T(j)), and the same with i and j exchanged.
    Means are compared as products, so that no rounding decides.
    """
    a = heard[i, LEADER]
    b = heard[j, LEADER]
    together = counts[a, 0] + counts[b, 0]
    return (
        together <= heard[i, DESIRED]
        and together <= heard[j, DESIRED]
        and together * counts[b, 0] <= counts[b, 1]
        and together * counts[a, 0] <= counts[a, 1]
    )


@inlined
def _near(heard_reading, i, j, d_join):  # type: ignore[no-untyped-def]
    dx = heard_reading[i, 0] - heard_reading[j, 0]
    dy = heard_reading[i, 1] - heard_reading[j, 1]
    distance2 = dx * dx + dy * dy
    return distance2 if distance2 <= d_join * d_join else np.inf


@inlined
def _speaks(heard, leader, step):  # type: ignore[no-untyped-def]
    """Whether a robot was heard in this step, and as the leader of its team."""
    return heard[leader, STEP] == step and heard[leader, LEADER] == leader


@inlined
def _partner(heard, heard_reading, counts, leader, step, d_join):  # type: ignore[no-untyped-def]
    """The leader of the team that joins with a leader's team in this step, or -1."""
    if not _speaks(heard, leader, step):
        return -1
    theirs = heard[leader, PICK]
    if theirs < 0 or heard[theirs, STEP] != step:
        return -1
    other = heard[theirs, LEADER]
    if other == leader or not _speaks(heard, other, step):
        return -1
    ours = heard[other, PICK]
    if ours < 0 or heard[ours, STEP] != step or heard[ours, LEADER] != leader:
        return -1
    # Each picks the other. Since the picks were sent, robots have moved and may have left.
    if _near(heard_reading, ours, theirs, d_join) == np.inf or not _fits(
        heard, counts, ours, theirs
    ):
        return -1
    return other


@inlined
def _note(events, count, kind, robot, other, value):  # type: ignore[no-untyped-def]
    events[count[0], 0] = kind
    events[count[0], 1] = robot
    events[count[0], 2] = other
    events[count[0], 3] = value
    count[0] += 1


@inlined
def _leave(state, i, step, events, count):  # type: ignore[no-untyped-def]
    before = state[i, LEADER]
    state[i, TEAM] = _mint(step, i, 0)
    state[i, LEADER] = i
    state[i, DESTINATION] = -1
    state[i, DUE_AT] = 0
    _note(events, count, LEAVE, i, before, state[i, TEAM])


@inlined
def _general_leaver(heard, counts, i, step, silence):  # type: ignore[no-untyped-def]
    """Whether i is the one to go where the mean desired size is below the team's size.

    One member leaves per step: the one that wants the smallest team, the highest id among equals.
    """
    leader = heard[i, LEADER]
    if counts[leader, 0] < 2 or counts[leader, 1] >= counts[leader, 0] * counts[leader, 0]:
        return False
    for j in range(heard.shape[0]):
        if j == i or heard[j, LEADER] != leader or heard[j, STEP] < step - silence:
            continue
        if heard[j, DESIRED] < heard[i, DESIRED]:
            return False
        if heard[j, DESIRED] == heard[i, DESIRED] and j > i:
            return False
    return True


@inlined
def _has_leader(state, sending, links, heard, shared, i, oldest):  # type: ignore[no-untyped-def]
    """Whether i's leader still belongs to i's team, or was heard of not too long ago."""
    leader = state[i, LEADER]
    if leader != i and not shared and not (links[i, leader] and sending[leader]):
        return heard[leader, STEP] >= oldest
    return sending[leader] and state[leader, TEAM] == state[i, TEAM]


@inlined
def _elect(state, reading, sending, links, shared, i):  # type: ignore[no-untyped-def]
    """The member of i's team, as it is now, with most charge; ties to the lowest id."""
    best = i
    for j in range(state.shape[0]):
        if not sending[j] or state[j, TEAM] != state[i, TEAM]:
            continue
        if not shared and j != i and not links[i, j]:
            continue
        if reading[j, 3] > reading[best, 3] or (reading[j, 3] == reading[best, 3] and j < best):
            best = j
    return best


@inlined
def _pick(state, heard, heard_reading, counts, pair, recruits, only, step, d_join):  # type: ignore[no-untyped-def]
    """Each leader's (or only one leader's) nearest admissible partner, for its next beacon."""
    robots = state.shape[0]
    n = 0
    for j in range(robots):
        pair[j, 0] = np.inf
        if only < 0 or j == only:
            state[j, PICK] = -1
        # Recruiting (desired size above team size), heard just now, and not changed since.
        if (
            heard[j, STEP] == step
            and heard[j, DESIRED] > counts[heard[j, LEADER], 0]
            and heard[j, TEAM] == state[j, TEAM]
        ):
            recruits[n] = j
            n += 1
    # Sweep from left to right: partners are no farther apart in x than in the plane.
    order = np.argsort(heard_reading[recruits[:n], 0])
    for a in range(n):
        i = recruits[order[a]]
        for b in range(a + 1, n):
            j = recruits[order[b]]
            if heard_reading[j, 0] - heard_reading[i, 0] > d_join:
                break
            if heard[i, LEADER] == heard[j, LEADER]:
                continue
            distance2 = _near(heard_reading, i, j, d_join)
            if distance2 == np.inf or not _fits(heard, counts, i, j):
                continue
            key = (distance2, float(min(i, j)), float(max(i, j)))
            for side in range(2):
                leader = heard[i, LEADER] if side == 0 else heard[j, LEADER]
                if only >= 0 and leader != only:
                    continue
                if key < (pair[leader, 0], pair[leader, 1], pair[leader, 2]):
                    pair[leader, 0] = key[0]
                    pair[leader, 1] = key[1]
                    pair[leader, 2] = key[2]
                    state[leader, PICK] = j if side == 0 else i


@kernel
def form_teams(  # type: ignore[no-untyped-def]
    state, reading, sending, links, heard_state, heard_reading,
    counts, pair, recruits, step, d_join, silence, general, events, count,
):  # fmt: skip
    """Phase 5 of a step for all robots: leave, then join, then lead, then pick.

    Args:
        state, reading, sending, heard_state, heard_reading: see ``Minds``.
        links: bool[N, N]: who hears whom; not read where all share one listener's row.
        counts, pair, recruits: scratch, see :class:`Tally`.
        step: the current step; d_join: metres; silence: steps; general: the paper's general rule
            for leaving applies too.
        events, count: see ``core.codes``.
    """
    robots = state.shape[0]
    listeners = heard_state.shape[0]
    shared = listeners == 1
    # Leave and join read the snapshot alone, so it does not matter who comes first.
    for k in range(listeners):
        heard = heard_state[k]
        _count(heard, step, silence, counts)
        for i in range(0 if shared else k, robots if shared else k + 1):
            if not sending[i]:
                continue
            leader = heard[i, LEADER]
            state[i, SIZE] = counts[leader, 0]
            if state[i, MODE] == CHARGE:
                state[i, DESTINATION] = -1
                if leader != i or counts[leader, 0] > 1:
                    _leave(state, i, step, events, count)
                continue
            if general and _general_leaver(heard, counts, i, step, silence):
                _leave(state, i, step, events, count)
                continue
            other = _partner(heard, heard_reading[k], counts, leader, step, d_join)
            if other < 0:
                continue
            state[i, TEAM] = _mint(step, min(counts[leader, 2], counts[other, 2]), 1)
            ours = counts[leader, 0]
            theirs = counts[other, 0]
            if theirs > ours or (theirs == ours and other < leader):
                state[i, LEADER] = other
            _note(events, count, JOIN, i, state[i, LEADER], state[i, TEAM])
    # Lead: members hear each other once more, and elect where their leader is gone. All elect
    # before anybody follows, so that nobody reads what another has just decided.
    for i in range(robots):
        pair[i, 0] = -1.0
        if sending[i] and not _has_leader(
            state, sending, links, heard_state[0 if shared else i], shared, i, step - silence
        ):
            pair[i, 0] = _elect(state, reading, sending, links, shared, i)
    for i in range(robots):
        if pair[i, 0] >= 0.0:
            before = state[i, LEADER]
            state[i, LEADER] = int(pair[i, 0])
            if state[i, LEADER] == i:
                _note(events, count, LEADER_EVENT, i, before, state[i, TEAM])
    for k in range(listeners):
        if not shared:
            if not sending[k] or state[k, LEADER] != k:
                state[k, PICK] = -1
                continue
            _count(heard_state[k], step, silence, counts)
        _pick(
            state, heard_state[k], heard_reading[k], counts, pair, recruits,
            -1 if shared else k, step, d_join,
        )  # fmt: skip


def reorganize(
    minds: Minds,
    tally: Tally,
    links: NDArray[np.bool_],
    step: int,
    d_join_m: float,
    silence_steps: int,
    leave_rule: str,
    events: NDArray[np.int64],
    count: NDArray[np.int64],
) -> None:
    """Phase 5 of a step; see :func:`form_teams`."""
    form_teams(
        minds.state, minds.reading, minds.sending, links, minds.heard_state, minds.heard_reading,
        tally.counts, tally.pair, tally.recruits, step, d_join_m, silence_steps,
        leave_rule == "general", events, count,
    )  # fmt: skip
