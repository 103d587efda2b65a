"""The sensing limit: the area that robots would map if they always drove straight in the open.

No selector exceeds it with the same bodies and sensors, so it is a yardstick that does not depend
on another selector.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from swarmscout.mission.mission import Mission
from swarmscout.mission.scenario import Scenario
from swarmscout.robots.bodies import TICKS, heading_table
from swarmscout.worlds.world import World

__all__ = ["sensing_limit_m2"]

_HEADINGS = 8
_LATE, _EARLY = 120, 60  # From the early step on, area grows at a constant rate.


def sensing_limit_m2(scenario: Scenario) -> float:
    """Area in m² that a scenario's robots would map in the open, each driving straight alone.

    It is measured: one robot with the scenario's body and sensor is moved straight ahead in eight
    directions, and its area per step is extrapolated to all robots and steps.

    Args:
        scenario: only its body, sensor, map, number of robots and number of steps matter.
    """
    start_m2, rate_m2 = _measure(
        scenario.body.model_dump_json(), scenario.sensor.model_dump_json(),
        scenario.map.model_dump_json(),
    )  # fmt: skip
    return scenario.robots * (start_m2 + rate_m2 * scenario.steps)


def _field(reach_m: float) -> World:
    """Open ground for at least `reach_m` on each side of its middle."""
    resolution_m = 0.1
    cells = 2 * int(np.ceil(reach_m / resolution_m))
    half_m = cells * resolution_m / 2
    return World(
        "an open field", np.ones((cells, cells), dtype=np.uint8), resolution_m,
        (-half_m, -half_m), (0.0, 0.0), np.array([[-half_m + 1.0, -half_m + 1.0]]),
    )  # fmt: skip


@lru_cache(maxsize=64)
def _measure(body: str, sensor: str, grid: str) -> tuple[float, float]:
    """Area in m² at the start and per step, both as means over the headings."""
    import json

    keys = {"body": json.loads(body), "sensor": json.loads(sensor), "map": json.loads(grid)}
    scenario = Scenario.model_validate(
        {
            **keys,
            "robots": 1,
            "steps": _LATE,
            "destinations": "nearest",
            "battery": {"enabled": False},
        }
    )
    range_m = Mission(scenario, world=_field(2.0)).sensing.last.max_range_m
    reach_m = _LATE * scenario.body.forward_m + range_m + 2 * scenario.map.cell_m
    field = _field(reach_m + 2.0)
    early, late = [], []
    for heading in range(_HEADINGS):
        mission = Mission(scenario, world=field)
        ticks = round((heading + 0.5) * TICKS / _HEADINGS) % TICKS
        mission.bodies.position[:] = 0.03 * heading  # Off the grid, a little more each time.
        mission.bodies.heading[:] = ticks
        ahead_m = scenario.body.forward_m * heading_table()[ticks]
        for step in range(_LATE):
            position = mission.bodies.position + ahead_m
            mission.step()
            if step + 1 == _EARLY:
                early.append(mission.explored_m2)
            # Straight on, where the mission's own planning would turn.
            mission.bodies.position[:], mission.bodies.heading[:] = position, ticks
        late.append(mission.explored_m2)
    rate = float(np.mean(late) - np.mean(early)) / (_LATE - _EARLY)
    return float(np.mean(early)) - rate * _EARLY, rate
