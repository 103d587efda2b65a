"""The log of a step's events is never written past its end, and missions never fill it."""

from __future__ import annotations

from collections import Counter
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from swarmscout.core.enums import EVENTS
from swarmscout.core.events import EVENT, EventLog, note
from swarmscout.mission.mission import Mission
from swarmscout.mission.scenario import Scenario
from swarmscout.testing import small_world


@pytest.mark.parametrize("robots", [1, 3, 300])
def test_a_log_holds_an_event_of_each_kind_for_each_robot(robots: int) -> None:
    log = EventLog(robots)
    assert log.entries.shape == (0, 4)
    wanted = [(kind, i, i + 1, -kind) for i in range(robots) for kind in range(len(EVENTS))]
    for event in wanted:
        note(log.rows, *event)
    assert [tuple(row) for row in log.entries.tolist()] == wanted
    note(log.rows, 0, 0, 0, 0)
    with pytest.raises(RuntimeError, match=f"{len(wanted) + 1} events in one step, room for "):
        _ = log.entries
    log.clear()
    assert log.entries.shape == (0, 4)


def test_a_full_log_counts_events_and_writes_nothing_past_its_end() -> None:
    memory = np.zeros(12, dtype=EVENT)
    memory["kind"] = 77
    memory[0]["value"] = 0
    log = EventLog(1)
    log.rows = memory[:9]
    for n in range(1, 30):
        note(log.rows, 5, n, n, n)
        assert log.rows[0]["value"] == n
    assert memory["robot"][1:9].tolist() == list(range(1, 9))
    assert memory[9:].tolist() == [(77, 0, 0, 0)] * 3
    with pytest.raises(RuntimeError, match="29 events in one step, room for 8"):
        _ = log.entries


@settings(max_examples=15)
@given(
    seed=st.integers(0, 1000),
    robots=st.integers(1, 12),
    general=st.booleans(),
    desired=st.integers(1, 5),
    capacity=st.integers(10, 80),
    linked=st.sampled_from([0.1, 0.5, 1.0]),
)
def test_missions_note_each_kind_of_event_once_a_robot_and_step(
    seed: int, robots: int, general: bool, desired: int, capacity: int, linked: float
) -> None:
    """So a log with room for one event of each kind and robot is never full."""

    def links(step: int) -> Any:
        return np.random.default_rng((seed, step // 3)).random((robots, robots)) < linked

    keys = {
        "robots": robots,
        "steps": 40,
        "seed": seed,
        "battery": {"capacity_steps": capacity, "start_min": 0.3},
        "teams": {"desired_size": desired, "leave_rule": "general" if general else "charge"},
    }
    world = small_world(seed % 3)
    mission = Mission(Scenario.model_validate(keys), world=world, links=links)
    while not mission.done:
        mission.step()
        entries = mission.events.entries
        assert int(mission.events.rows[0]["value"]) == len(entries) <= len(EVENTS) * robots
        noted = Counter((kind, robot) for kind, robot, _, _ in entries.tolist())
        assert set(noted.values()) <= {1}
