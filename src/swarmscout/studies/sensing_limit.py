"""The sensing limit: what robots could map that always drove straight through the open.

No rule can do better with these bodies and sensors, and none gets near: it is the yardstick that
does not depend on another rule.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from swarmscout.core.enums import FORWARD
from swarmscout.mission.mission import Mission
from swarmscout.mission.scenario import Scenario
from swarmscout.robots.bodies import TICKS
from swarmscout.worlds.world import World

__all__ = ["sensing_limit_m2"]

_HEADINGS = 8
_LATE, _EARLY = 120, 60  # What comes later in a mission comes at the same rate.


def sensing_limit_m2(scenario: Scenario) -> float:
    """What a scenario's robots would map in the open, driving straight and never meeting.

    It is measured: one robot of the scenario's body and sensor drives straight in eight directions,
    and its area per step is taken for all robots and steps.

    Args:
        scenario: its body, sensor, map, robots and steps count.
    """
    start_m2, rate_m2 = _measure(
        scenario.body.model_dump_json(), scenario.sensor.model_dump_json(),
        scenario.map.model_dump_json(),
    )  # fmt: skip
    return scenario.robots * (start_m2 + rate_m2 * scenario.steps)


def _straight_on(minds: object, grids: object, contact: object, action: NDArray[np.int64]) -> None:
    action.fill(FORWARD)


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
    """Area at the start, and per step, in m²; both are means over the headings."""
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
        mission.bodies.position[:] = 0.03 * heading  # Off the grid, a little more each time.
        mission.bodies.heading[:] = round((heading + 0.5) * TICKS / _HEADINGS) % TICKS
        # A robot that knows one action.
        mission.planner.steer = _straight_on  # type: ignore[method-assign,assignment]
        for _ in range(_EARLY):
            mission.step()
        early.append(mission.explored_m2)
        for _ in range(_LATE - _EARLY):
            mission.step()
        late.append(mission.explored_m2)
    rate = float(np.mean(late) - np.mean(early)) / (_LATE - _EARLY)
    return float(np.mean(early)) - rate * _EARLY, rate
