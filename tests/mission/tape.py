"""A recorder that keeps everything, and worlds to fly it in."""

from __future__ import annotations

import copy
import hashlib
from collections.abc import Mapping
from typing import Any

import numpy as np

from swarmscout.core.recorder import StepRecord
from swarmscout.mission.mission import Mission
from swarmscout.mission.scenario import Scenario
from swarmscout.testing import small_world
from swarmscout.worlds.arrays import world_from_ascii
from swarmscout.worlds.world import World


class Tape:
    """Keeps a copy of each step's record."""

    def __init__(self) -> None:
        self.records: list[StepRecord] = []
        self.summary: dict[str, Any] | None = None

    def begin(self, mission: Any) -> None:
        assert self.records == []

    def record(self, record: StepRecord) -> None:
        self.records.append(copy.deepcopy(record))

    def end(self, summary: Mapping[str, Any]) -> None:
        assert self.summary is None
        self.summary = dict(summary)


def scenario_of(scenario: Mapping[str, Any] | None = None, **keys: Any) -> Scenario:
    """A short mission of few robots with little charge, so that everything happens in it."""
    base = {
        "robots": 8,
        "steps": 120,
        "battery": {"capacity_steps": 150, "start_min": 0.3},
        **(scenario or {}),
        **keys,
    }
    return Scenario.model_validate(base)


LITERAL = {"routes": {"cost": "probability"}, "renewal": {"rule": "reached", "avoid_steps": 0}}


def state_of(mission: Mission) -> dict[str, np.ndarray]:
    """Everything that a mission's next step depends on, apart from maps, in arrays."""
    bodies, minds = mission.bodies, mission.minds
    return {
        "position": bodies.position.copy(),
        "heading": bodies.heading.copy(),
        "charge": bodies.charge.copy(),
        "alive": bodies.alive.copy(),
        "contact": bodies.contact.copy(),
        "minds": minds.own.copy(),
        "sending": minds.own["thinks"].copy(),
        "avoided": minds.avoided.copy(),
        "given up": minds.given_up.copy(),
        "action": mission.action.copy(),
        "plan": mission.planner.table.state.copy(),
        "routes": mission.planner.table.cells.copy(),
    }


def digest(mission: Mission) -> str:
    """One number for a mission's whole state."""
    told = hashlib.sha256()
    for name, array in state_of(mission).items():
        told.update(name.encode() + np.ascontiguousarray(array).tobytes())
    for array in (mission.map_of(0).evidence, mission.map_of(0).labels, mission.map.evidence):
        told.update(np.ascontiguousarray(array).tobytes())
    told.update(repr(sorted(mission.summary().items(), key=lambda item: item[0])).encode())
    return told.hexdigest()


CLOSET = """
########
#......#
#..S...#
#......#
#......#
########
"""


def closet() -> World:
    """A closed room whose walls stand on borders of map cells; seen in some dozen steps."""
    return world_from_ascii(CLOSET, name="closet", pieces=5)


__all__ = ["LITERAL", "Tape", "closet", "digest", "scenario_of", "small_world", "state_of"]
