"""What counts as a join: two teams that both take themselves for one."""

from __future__ import annotations

import numpy as np
import pytest
from tape import Tape, scenario_of, small_world

from swarmscout.core.enums import JOIN
from swarmscout.mission.mission import Mission


@pytest.mark.parametrize(
    ("joined", "count"),
    [
        ([], 0),
        ([(1, 9)], 0),  # One side only.
        ([(0, 9), (1, 9)], 0),  # Members of one team.
        ([(0, 9), (1, 9), (3, 9), (2, 9)], 1),
        ([(0, 9), (4, 8), (2, 9), (5, 8)], 2),
        ([(0, 9), (4, 8), (2, 9)], 1),
    ],
)
def test_a_join_needs_two_sides(joined: list[tuple[int, int]], count: int) -> None:
    mission = Mission(scenario_of(), world=small_world(0))
    mission.judge._before[:, 3] = [7, 7, 2, 2, 4, 5, 6, 8]
    mission.events.clear()
    rows = mission.events.rows
    rows[0]["value"] = len(joined)
    for row, (robot, team) in zip(rows[1:], joined, strict=False):
        row["kind"], row["robot"], row["value"] = JOIN, robot, team
    mission.judge.judge_robots(mission.bodies, mission.minds, mission.action, mission.events)
    assert mission.judge._tally[0]["joins"] == count
    assert mission.judge._before[:, 3].tolist() == mission.minds.team.tolist()


def test_joins_under_failing_links_have_robots_of_two_teams() -> None:
    rng = np.random.default_rng(3)
    tape = Tape()
    mission = Mission(
        scenario_of(steps=150), world=small_world(2), recorder=tape,
        links=lambda step: rng.random((8, 8)) < 0.6,
    )  # fmt: skip
    summary = mission.run()
    both = sides = 0
    before = tape.records[0].team
    for record in tape.records[1:]:
        rows = [row for row in record.events.tolist() if row[0] == JOIN]
        for team in {row[3] for row in rows}:
            former = {int(before[row[1]]) for row in rows if row[3] == team}
            both += len(former) > 1
            sides += 1
        before = record.team
    assert summary["joins"] == both
    assert both < sides, "links that fail make one-sided joins, or this tests nothing"
