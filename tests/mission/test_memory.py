"""A mission that does not fit into the machine's memory is refused before it is made."""

from __future__ import annotations

import os
from typing import Any

import numpy as np
import pytest

from swarmscout.core import memory
from swarmscout.core.errors import ScenarioError
from swarmscout.mission.build import make_frame
from swarmscout.mission.memory import map_rows, memory_needed
from swarmscout.mission.mission import Mission
from swarmscout.mission.scenario import Scenario
from swarmscout.worlds.arrays import world_from_array

HALL = world_from_array(np.ones((200, 200), dtype=np.uint8), resolution_m=0.1)


def of(robots: int, **radio: Any) -> Scenario:
    return Scenario(robots=robots, radio=radio) if radio else Scenario(robots=robots)


def estimate(scenario: Scenario) -> int:
    return memory_needed(scenario, HALL, make_frame(HALL, scenario), map_rows(scenario, HALL))


def test_robots_have_maps_of_their_own_if_some_cannot_hear_each_other() -> None:
    assert map_rows(of(40), HALL) == 1
    assert map_rows(of(40, model="disc", range_m=8.0), HALL) == 40
    assert map_rows(of(40, model="disc", range_m=30.0), HALL) == 1


def test_the_estimate_counts_robots_cells_and_maps() -> None:
    shared, own = of(40), of(40, model="disc", range_m=8.0)
    assert estimate(of(80)) > estimate(shared)
    # Beyond one map: 40 rows of maps, beacons and versions.
    mission = Mission(own, world=HALL)
    grids = mission.knowledge.grids
    row = sum(getattr(grids, name).nbytes for name in ("evidence", "status", "price", "crowd"))
    assert 40 * row < estimate(own) - estimate(shared) < 60 * row + 40 * 40 * 200


def test_a_mission_that_does_not_fit_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    scenario = of(40, model="disc", range_m=8.0)
    there = estimate(scenario) - 1
    monkeypatch.setattr("swarmscout.mission.memory.machine_memory", lambda: there)
    with pytest.raises(ScenarioError) as caught:
        Mission(scenario, world=HALL)
    for part in ("GB", "key 'robots'", "key 'map.cell_m'", "key 'radio.range_m'", "40 maps"):
        assert part in str(caught.value)
    Mission(of(40), world=HALL)
    monkeypatch.setattr("swarmscout.mission.memory.machine_memory", lambda: None)
    Mission(scenario, world=HALL)


def test_the_limit_of_a_container_counts(monkeypatch: pytest.MonkeyPatch, tmp_path: Any) -> None:
    monkeypatch.setattr(memory, "_CONTAINER_LIMIT", tmp_path / "memory.max")
    whole = memory.machine_memory()
    (tmp_path / "memory.max").write_text("max\n")
    assert memory.machine_memory() == whole
    (tmp_path / "memory.max").write_text("1000000\n")
    assert memory.machine_memory() == 1_000_000
    monkeypatch.delattr(os, "sysconf")
    assert memory.machine_memory() is None
