"""Team formation once more, slowly: sets and loops, written from the paper's text.

"Merging takes place when two teams are both in the recruitment state and within a certain
proximity. Specifically, if robot i finds robot j not in T(i) within a threshold distance d_join,
and the condition n_i + n_j <= min(desired_i, mean of desired over T(j)) is satisfied, then teams
T(i) and T(j) are merged. ... leaving is performed by individual robots, and is permitted
unconditionally when the battery charge level is low (CHR mode)."

What the paper leaves open follows docs: the inequality holds in both directions, each team picks
its nearest admissible pair, and two teams join where each picks the other. A team is who carries
the same team id and was heard not too long ago; all hear all.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from fractions import Fraction

import numpy as np
from known import exchange, place

from swarmscout.comms.knowledge import Knowledge
from swarmscout.core.enums import CHARGE, EXPLORE, JOIN, LEAVE
from swarmscout.core.enums import LEADER as LEADER_EVENT
from swarmscout.core.events import EventLog
from swarmscout.core.grid import GridFrame
from swarmscout.mapping.log_odds import InverseSensorModel
from swarmscout.mapping.occupancy import OccupancyGrids
from swarmscout.minds.minds import Minds, blank_minds
from swarmscout.teams.formation import TeamFormation
from swarmscout.teams.parameters import TeamParameters

Team = tuple[int, int]
"""A team as heard: its id, and the leader that a robot follows in it."""

MAP = GridFrame(0.0, 0.0, 0.5, 1, 8), 1, InverseSensorModel(-1, 1, -9, 9, -1, 1, 0.0), 8


class Population:
    """Robots that do nothing but form teams, through the real phases of a step."""

    def __init__(
        self,
        positions_m: np.ndarray,
        desired: np.ndarray,
        charge: np.ndarray,
        *,
        d_join_m: float = 2.0,
        silence: int = 5,
        rule: str = "charge",
    ) -> None:
        robots = len(positions_m)
        self.minds: Minds = blank_minds(robots)
        place(self.minds, positions_m)
        self.knowledge = Knowledge(robots, OccupancyGrids(*MAP))
        self.minds.own["charge"] = charge
        self.wanted = np.asarray(desired, dtype=np.int64).copy()
        self.minds.own["desired"] = self.wanted
        self.d_join_m, self.silence, self.rule = d_join_m, silence, rule
        self.number = 0
        self.events: list[list[int]] = []
        self.snapshot: Snapshot | None = None
        self._formation = TeamFormation(
            robots,
            TeamParameters(d_join_m=d_join_m, silence_steps=silence, leave_rule=rule),  # type: ignore[arg-type]
        )

    def step(
        self,
        positions_m: np.ndarray | None = None,
        mode: np.ndarray | None = None,
        dead: np.ndarray | None = None,
    ) -> Snapshot:
        """Beacons, then modes (and deaths), then teams: the order of a mission's step."""
        minds = self.minds
        self.number += 1
        if positions_m is not None:
            place(minds, positions_m)
        exchange(self.knowledge, minds, self.number)
        if dead is not None:
            minds.own["thinks"] &= ~dead
            minds.own["sends"] &= ~dead
        if mode is not None:
            minds.own["mode"][minds.own["thinks"]] = mode[minds.own["thinks"]]
        minds.own["desired"] = np.where(minds.mode == CHARGE, 1, self.wanted)
        self.snapshot = Snapshot.of(self)
        log = EventLog(len(minds))
        self._formation.reorganize(minds, self.knowledge, self.number, log)
        self.events = log.entries.tolist()
        return self.snapshot

    def gather(self, *teams: list[int], leaders: list[int] | None = None) -> None:
        """Put robots into teams by hand."""
        for index, members in enumerate(teams):
            self.minds.own["team"][members] = 1000 + index  # Below every id that is minted.
            self.minds.own["leader"][members] = members[0] if leaders is None else leaders[index]

    @property
    def living(self) -> list[int]:
        return np.flatnonzero(self.minds.own["thinks"]).tolist()

    def teams(self) -> dict[int, frozenset[int]]:
        """Living members by team id."""
        found: dict[int, set[int]] = {}
        for i in self.living:
            found.setdefault(int(self.minds.team[i]), set()).add(i)
        return {team: frozenset(members) for team, members in found.items()}

    def partition(self) -> frozenset[frozenset[int]]:
        return frozenset(self.teams().values())


@dataclass
class Snapshot:
    """What all heard in a step, and what the paper's rules make of it."""

    step: int
    d_join_m: float
    rule: str
    place: list[tuple[float, float]]
    charge: list[float]
    desired: list[int]
    now: list[bool]
    leader: list[int]
    pick: list[int]
    team: list[Team]
    mode_now: list[int]
    living: list[int]
    members: dict[Team, frozenset[int]] = field(default_factory=dict)
    fresh: list[int] = field(default_factory=list)

    @staticmethod
    def of(population: Population) -> Snapshot:
        minds, step = population.minds, population.number
        heard = population.knowledge.heard[0]
        snapshot = Snapshot(
            step=step,
            d_join_m=population.d_join_m,
            rule=population.rule,
            place=[tuple(p) for p in np.column_stack((heard["x_m"], heard["y_m"])).tolist()],
            charge=minds.own["charge"].tolist(),
            desired=heard["desired"].tolist(),
            now=(heard["step"] == step).tolist(),
            leader=heard["leader"].tolist(),
            pick=heard["partner"].tolist(),
            team=[(int(t), int(b)) for t, b in zip(heard["team"], heard["leader"], strict=True)],
            mode_now=minds.mode.tolist(),
            living=population.living,
        )
        fresh = snapshot.fresh = np.flatnonzero(
            (heard["step"] >= 0) & (heard["step"] >= step - population.silence)
        ).tolist()
        for i in fresh:
            team = snapshot.team[i]
            snapshot.members.setdefault(team, frozenset())
            snapshot.members[team] |= {i}
        return snapshot

    def size(self, i: int) -> int:
        return len(self.members[self.team[i]])

    def mean_desired(self, i: int) -> Fraction:
        members = self.members[self.team[i]]
        return Fraction(sum(self.desired[j] for j in members), len(members))

    def distance2(self, i: int, j: int) -> float:
        (ax, ay), (bx, by) = self.place[i], self.place[j]
        return (ax - bx) * (ax - bx) + (ay - by) * (ay - by)

    def near(self, i: int, j: int) -> bool:
        return self.distance2(i, j) <= self.d_join_m * self.d_join_m

    def recruits(self, i: int) -> bool:
        return self.desired[i] > self.size(i)

    def fits(self, i: int, j: int) -> bool:
        """The paper's inequality, as i sees it."""
        return self.size(i) + self.size(j) <= min(self.desired[i], self.mean_desired(j))

    def may_join(self, i: int, j: int) -> bool:
        return (
            self.team[i] != self.team[j]
            and self.near(i, j)
            and self.recruits(i)
            and self.recruits(j)
            and self.fits(i, j)
            and self.fits(j, i)
        )

    def speaker(self, team: Team) -> int | None:
        """The member that was heard in this step as the team's leader."""
        found = [i for i in self.members[team] if self.leader[i] == i and self.now[i]]
        assert len(found) <= 1
        return found[0] if found else None

    def picked(self, team: Team) -> int | None:
        speaker = self.speaker(team)
        if speaker is None or self.pick[speaker] < 0 or not self.now[self.pick[speaker]]:
            return None
        return self.pick[speaker]

    def joins(self) -> list[tuple[Team, Team]]:
        """Pairs of teams that join in this step."""
        pairs = []
        for a in self.members:
            for b in self.members:
                theirs, ours = self.picked(a), self.picked(b)
                if a >= b or theirs is None or ours is None:
                    continue
                if self.team[theirs] == b and self.team[ours] == a and self.may_join(ours, theirs):
                    pairs.append((a, b))
        return pairs

    def joiners(self) -> set[int]:
        """Robots whose team joins with another, and who stay with it."""
        both = {i for pair in self.joins() for team in pair for i in self.members[team]}
        exploring = {i for i in self.living if self.mode_now[i] != CHARGE}
        return (both & exploring) - self.leavers()

    def leavers(self) -> set[int]:
        gone = set()
        for members in self.members.values():
            if len(members) < 2:
                continue
            gone |= {i for i in members if self.mode_now[i] == CHARGE}
            total = sum(self.desired[i] for i in members)
            if self.rule == "general" and Fraction(total, len(members)) < len(members):
                # One at a time: who wants the smallest team, the highest id among equals.
                gone.add(min(members, key=lambda i: (self.desired[i], -i)))
        return gone & set(self.living)

    def outcome(self) -> tuple[frozenset[frozenset[int]], dict[int, int]]:
        """The partition of the living after the step, and each robot's leader."""
        leavers = self.leavers()
        groups: list[tuple[set[int], int | None]] = [({i}, i) for i in sorted(leavers)]
        joined = {team for pair in self.joins() for team in pair}
        stay = set(self.living) - leavers
        alone_chr = {i for i in stay if self.mode_now[i] == CHARGE}
        for a, b in self.joins():
            lead = []
            for team in (a, b):
                speaker = self.speaker(team)
                assert speaker is not None
                lead.append((-len(self.members[team]), speaker))
            members = (self.members[a] | self.members[b]) & stay - alone_chr
            groups.append((set(members), min(lead)[1]))
        for team, members in self.members.items():
            rest = members & stay - (alone_chr if team in joined else set())
            if team not in joined and rest:
                (leader,) = {self.leader[i] for i in rest}
                groups.append((set(rest), leader))
        groups += [({i}, i) for i in sorted(alone_chr) if self.team[i] in joined]
        partition, leaders = set(), {}
        for members, leader in groups:
            if not members:
                continue
            # A leader that fell silent leads until it counts as gone; one that left says so.
            silent = leader not in self.living and leader in self.fresh
            if leader not in members and not silent:
                leader = min(members, key=lambda i: (-self.charge[i], i))
            partition.add(frozenset(members))
            leaders.update(dict.fromkeys(members, leader))
        return frozenset(partition), leaders

    def next_picks(self, teams_now: list[int]) -> dict[Team, int]:
        """The partner that each team picks for its next beacon, by its speaker."""
        able = [
            i for i in self.living_heard() if teams_now[i] == self.team[i][0] and self.recruits(i)
        ]
        best: dict[Team, tuple[float, int, int]] = {}
        for i in able:
            for j in able:
                if i < j and self.may_join(i, j):
                    key = (self.distance2(i, j), i, j)
                    for team in (self.team[i], self.team[j]):
                        best[team] = min(best.get(team, key), key)
        picks = {}
        for team, (_, i, j) in best.items():
            picks[team] = j if self.team[i] == team else i
        return picks

    def living_heard(self) -> list[int]:
        return [i for i in range(len(self.now)) if self.now[i]]


__all__ = ["CHARGE", "EXPLORE", "JOIN", "LEADER_EVENT", "LEAVE", "Population", "Snapshot"]
