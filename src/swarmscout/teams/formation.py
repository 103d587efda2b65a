"""Leave, join, lead: how robots form teams (paper, "Decentralized team formation").

There is no table of teams. A team is what its members believe: who carries the same team id.
Leaders speak for their teams: a leader's beacon names the robot of another team that it would join
with, and two teams join exactly when each of their leaders, as heard, picks a robot of the other
team. No arbiter decides and the order of robots does not matter. Deviation: the paper merges two
teams at once; without an arbiter each has to hear the other's choice first, which takes a step.

All of a step's rules read the same snapshot, the beacons of this step's exchange. What a rule
changes reaches the members of the same team in the same step, by team notices; other teams hear of
it in the next step.
"""

from __future__ import annotations

import numpy as np

from swarmscout.comms.knowledge import Knowledge
from swarmscout.core.enums import JOIN, LEAVE
from swarmscout.core.enums import LEADER as LEADER_EVENT
from swarmscout.core.events import EventLog, note
from swarmscout.core.jit import allocating, inlined, kernel
from swarmscout.minds.minds import Minds
from swarmscout.minds.modes import is_on_task
from swarmscout.teams.parameters import TeamParameters

__all__ = ["TALLY", "TEAM_RULES", "TeamFormation", "elect_and_pick", "leave_and_join"]

ROBOT_BITS = 24

TEAM_RULES = np.dtype([("d_join_m", "f8"), ("silence_steps", "i8"), ("general", "?")], align=True)
"""Teams this near may join; a member silent for longer is dropped; the general rule for leaving."""

TALLY = np.dtype(
    [
        ("members", "i8"),
        ("desired", "i8"),  # sum of desired sizes
        ("lowest", "i8"),  # lowest member
        ("distance2", "f8"),  # the best pair for joining: squared distance in m² …
        ("low", "i8"),  # … lower id …
        ("high", "i8"),  # … higher id
        ("partner", "i8"),  # … and the robot of it that belongs to the other team
        ("elected", "i8"),
        ("recruit", "i8"),  # scratch, a list of recruiting robots
    ],
    align=True,
)
"""What a listener makes of the beacons it has heard, one record per leader."""


@inlined
def _mint(step, robot, joined):  # type: ignore[no-untyped-def]
    """A new team's id: when it formed, its lowest robot, and whether by joining or by leaving."""
    return ((step * 2 + joined) << ROBOT_BITS) | robot


@inlined
def _count(heard, step, silence, tally):  # type: ignore[no-untyped-def]
    """Members, sum of desired sizes and lowest member of each leader's team, as heard."""
    robots = heard.shape[0]
    for j in range(robots):
        tally[j].members = 0
        tally[j].desired = 0
        tally[j].lowest = robots
    for j in range(robots):
        if heard[j].step < 0 or heard[j].step < step - silence:
            continue
        leader = heard[j].leader
        # Ids grow with time: a silent robot followed this leader in an earlier team of its.
        if heard[j].team < heard[leader].team:
            continue
        team = tally[leader]
        team.members += 1
        team.desired += heard[j].desired
        team.lowest = min(team.lowest, j)


@inlined
def _fits(heard, tally, i, j):  # type: ignore[no-untyped-def]
    """The paper's condition for i and j to join their teams, in both directions.

    n_i + n_j ≤ min(desired_i, mean desired size of T(j)), and the same with i and j exchanged.
    Means are compared as products, so that no rounding decides.
    """
    ours = tally[heard[i].leader]
    theirs = tally[heard[j].leader]
    together = ours.members + theirs.members
    return (
        together <= heard[i].desired
        and together <= heard[j].desired
        and together * theirs.members <= theirs.desired
        and together * ours.members <= ours.desired
    )


@inlined
def _near(heard, i, j, d_join):  # type: ignore[no-untyped-def]
    """Squared distance of two robots, infinite beyond `d_join`."""
    dx = heard[i].x_m - heard[j].x_m
    dy = heard[i].y_m - heard[j].y_m
    distance2 = dx * dx + dy * dy
    return distance2 if distance2 <= d_join * d_join else np.inf


@inlined
def _speaks(heard, leader, step):  # type: ignore[no-untyped-def]
    """Whether a robot was heard in this step, and as the leader of its team."""
    return heard[leader].step == step and heard[leader].leader == leader


@inlined
def _other_team(heard, tally, leader, step, d_join):  # type: ignore[no-untyped-def]
    """The leader of the team that joins with a leader's team in this step, or -1."""
    if not _speaks(heard, leader, step):
        return -1
    theirs = heard[leader].partner
    if theirs < 0 or heard[theirs].step != step:
        return -1
    other = heard[theirs].leader
    if other == leader or not _speaks(heard, other, step):
        return -1
    ours = heard[other].partner
    if ours < 0 or heard[ours].step != step or heard[ours].leader != leader:
        return -1
    # Each picks the other. Since the picks were sent, robots have moved and may have left.
    if _near(heard, ours, theirs, d_join) == np.inf or not _fits(heard, tally, ours, theirs):
        return -1
    return other


@inlined
def _leave(own, i, step, events):  # type: ignore[no-untyped-def]
    me = own[i]
    before = me.leader
    me.team = _mint(step, i, 0)
    me.leader = i
    me.destination = -1
    me.due_at = 0
    note(events, LEAVE, i, before, me.team)


@inlined
def _general_leaver(heard, tally, i, step, silence):  # type: ignore[no-untyped-def]
    """Whether i is the one to go where the mean desired size is below the team's size.

    One member leaves per step: the one that wants the smallest team, the highest id among equals.
    """
    leader = heard[i].leader
    team = tally[leader]
    if team.members < 2 or team.desired >= team.members * team.members:
        return False
    for j in range(heard.shape[0]):
        if j == i or heard[j].leader != leader or heard[j].step < step - silence:
            continue
        if heard[j].desired < heard[i].desired:
            return False
        if heard[j].desired == heard[i].desired and j > i:
            return False
    return True


@kernel
def leave_and_join(own, heard, listeners, groups, tally, step, rules, events):  # type: ignore[no-untyped-def]
    """Each robot leaves its team or joins it with another, by the beacons it has heard.

    Args:
        own: MIND[N], written: team, leader, size; destination of those that leave.
        heard: BEACON[R, N]; listeners: int64[N]; groups: int64[A, 3]: see ``Knowledge``.
        tally: TALLY[N], scratch.
        step: the current step; rules: TEAM_RULES[1]; events: see ``EventLog``.
    """
    rules = rules[0]
    silence = rules.silence_steps
    for a in range(groups.shape[0]):
        row = heard[groups[a, 0]]
        _count(row, step, silence, tally)
        for n in range(groups[a, 1], groups[a, 2]):
            i = listeners[n]
            me = own[i]
            if not me.thinks:
                continue
            leader = row[i].leader
            team = tally[leader]
            me.size = team.members
            if not is_on_task(me.mode):
                me.destination = -1
                if leader != i or team.members > 1:
                    _leave(own, i, step, events)
                continue
            if rules.general and _general_leaver(row, tally, i, step, silence):
                _leave(own, i, step, events)
                continue
            other = _other_team(row, tally, leader, step, rules.d_join_m)
            if other < 0:
                continue
            theirs = tally[other]
            me.team = _mint(step, min(team.lowest, theirs.lowest), 1)
            if theirs.members > team.members or (theirs.members == team.members and other < leader):
                me.leader = other
            note(events, JOIN, i, me.leader, me.team)


@inlined
def _has_leader(own, heard, notices, i, step, silence):  # type: ignore[no-untyped-def]
    """Whether i's leader still belongs to i's team, or was heard of not too long ago."""
    leader = own[i].leader
    if leader == i:
        return True
    if heard[leader].step == step and notices[leader].step == step:
        return notices[leader].team == own[i].team
    return heard[leader].step >= step - silence


@inlined
def _elect(own, heard, notices, i, step):  # type: ignore[no-untyped-def]
    """The member of i's team, as it is now, with most charge; ties to the lowest id."""
    best = i
    most = own[i].charge
    for j in range(heard.shape[0]):
        if j == i or heard[j].step != step or notices[j].step != step:
            continue
        if notices[j].team != own[i].team:
            continue
        if notices[j].charge > most or (notices[j].charge == most and j < best):
            best = j
            most = notices[j].charge
    return best


@allocating
def _pick(heard, notices, tally, step, d_join):  # type: ignore[no-untyped-def]
    """Each leader's nearest admissible partner, as a listener of these beacons finds it."""
    n = 0
    for j in range(heard.shape[0]):
        tally[j].distance2 = np.inf
        tally[j].partner = -1
        # Recruiting (desired size above team size), heard just now, and not changed since.
        if (
            heard[j].step == step
            and heard[j].desired > tally[heard[j].leader].members
            and not (notices[j].step == step and notices[j].team != heard[j].team)
        ):
            tally[n].recruit = j
            n += 1
    # Sweep from left to right: partners are no farther apart in x than in the plane.
    x = np.empty(n)
    for a in range(n):
        x[a] = heard[tally[a].recruit].x_m
    order = np.argsort(x)
    for a in range(n):
        i = tally[order[a]].recruit
        for b in range(a + 1, n):
            j = tally[order[b]].recruit
            if heard[j].x_m - heard[i].x_m > d_join:
                break
            if heard[i].leader == heard[j].leader:
                continue
            distance2 = _near(heard, i, j, d_join)
            if distance2 == np.inf or not _fits(heard, tally, i, j):
                continue
            low = min(i, j)
            high = max(i, j)
            for side in range(2):
                best = tally[heard[i].leader if side == 0 else heard[j].leader]
                if (distance2, low, high) < (best.distance2, best.low, best.high):
                    best.distance2 = distance2
                    best.low = low
                    best.high = high
                    best.partner = j if side == 0 else i


@kernel
def elect_and_pick(own, heard, notices, listeners, groups, tally, step, rules, events):  # type: ignore[no-untyped-def]
    """Robots whose leader is gone elect one, and each leader picks a partner for joining.

    Args:
        own: MIND[N], written: leader, partner.
        notices: NOTICE[N], what robots said after leaving and joining.
        heard, listeners, groups, tally, step, rules, events: see :func:`leave_and_join`.
    """
    rules = rules[0]
    for a in range(groups.shape[0]):
        row = heard[groups[a, 0]]
        leads = False
        for n in range(groups[a, 1], groups[a, 2]):
            i = listeners[n]
            me = own[i]
            me.partner = -1
            if not me.thinks:
                continue
            if not _has_leader(own, row, notices, i, step, rules.silence_steps):
                before = me.leader
                me.leader = _elect(own, row, notices, i, step)
                if me.leader == i:
                    note(events, LEADER_EVENT, i, before, me.team)
            leads = leads or me.leader == i
        if not leads:
            continue
        _count(row, step, rules.silence_steps, tally)
        _pick(row, notices, tally, step, rules.d_join_m)
        for n in range(groups[a, 1], groups[a, 2]):
            i = listeners[n]
            if own[i].thinks and own[i].leader == i:
                own[i].partner = tally[i].partner


class TeamFormation:
    """Phase 5 of a step: leave, then join, then lead.

    Args:
        robots: N.
        teams: who may join, leave, and counts as gone.
    """

    def __init__(self, robots: int, teams: TeamParameters) -> None:
        self._tally = np.zeros(robots, dtype=TALLY)
        self._rules = np.array(
            [(teams.d_join_m, teams.silence_steps, teams.leave_rule == "general")], dtype=TEAM_RULES
        )

    def reorganize(self, minds: Minds, knowledge: Knowledge, step: int, events: EventLog) -> None:
        """Let robots leave, join and elect, each by what it has heard."""
        heard, listeners, groups = knowledge.heard, knowledge.listeners, knowledge.groups
        leave_and_join(
            minds.own, heard, listeners, groups, self._tally, step, self._rules, events.rows
        )
        knowledge.tell(minds, step)
        elect_and_pick(
            minds.own, heard, knowledge.notices, listeners, groups, self._tally, step, self._rules,
            events.rows,
        )  # fmt: skip
