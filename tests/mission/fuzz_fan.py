"""Random small missions with members that fan out: none may end in robots that turn for ever.

    python tests/mission/fuzz_fan.py 10000 [FIRST]

A mission is a livelock if a robot that wants to drive gets nowhere in its last 150 steps, although
its team has a destination that it could reach. The seeds of those are printed.
"""

from __future__ import annotations

import sys

import numpy as np
from numpy.typing import NDArray

from swarmscout import Mission, Scenario
from swarmscout.worlds.world import World

STEPS, LAST, WITHIN_M = 500, 150, 0.5


def rooms(rng: np.random.Generator) -> World:
    """Two rows of rooms along a corridor, with doors and pillars anywhere."""
    res, columns = 0.25, int(rng.integers(40, 80))
    room, hall = int(rng.integers(8, 16)), int(rng.integers(6, 14))
    rows = 2 * room + hall + 4
    free = np.ones((rows, columns), dtype=np.uint8)
    free[[0, room + 1, room + hall + 2, -1]] = 0
    free[:, [0, -1]] = 0
    for row in (room + 1, room + hall + 2):
        for _ in range(int(rng.integers(2, 5))):
            door = int(rng.integers(2, columns - 8))
            free[row, door : door + int(rng.integers(4, 8))] = 1
    for wall in range(int(rng.integers(12, 20)), columns - 6, int(rng.integers(12, 24))):
        free[: room + 2, wall] = 0
        free[room + hall + 2 :, wall] = 0
    for _ in range(int(rng.integers(0, 6))):
        row, col = (int(rng.integers(2, size - 4)) for size in (rows, columns))
        free[row : row + 2, col : col + 2] = 0
    free[room + 2 : room + hall + 2, 1:5] = 1
    start = (3 * res, (room + 2 + hall / 2) * res)
    return World("rooms", free, res, (0.0, 0.0), start_m=start)


def is_livelock(seed: int) -> bool:
    """Whether a random mission ends in robots that want to drive and get nowhere."""
    rng = np.random.default_rng(seed)
    robots = int(rng.integers(2, 5))
    scenario = Scenario.model_validate({
        "robots": robots, "steps": STEPS, "seed": int(rng.integers(1 << 31)),
        "destinations": "multi-criteria", "battery": {"enabled": False},
        "teams": {"members": "fan", "desired_size": robots},
    })  # fmt: skip
    mission = Mission(scenario, world=rooms(rng))
    places: list[NDArray[np.float64]] = []
    wanting: list[NDArray[np.bool_]] = []
    while not mission.done:
        mission.step()
        own, routes = mission.minds.own, mission.planner.table.state
        places.append(mission.bodies.position.copy())
        wanting.append((own["target"] >= 0) & (routes["failed_until"] == 0))
    if len(places) < STEPS:
        return False
    last = np.array(places[-LAST:])
    away = np.hypot(*np.moveaxis(last - last[0], -1, 0)).max(axis=0)
    return bool(((away < WITHIN_M) & np.array(wanting[-LAST:]).all(axis=0)).any())


def main() -> None:
    """Try so many missions; a status of 1 if one is a livelock."""
    count = int(sys.argv[1]) if len(sys.argv) > 1 else 100
    first = int(sys.argv[2]) if len(sys.argv) > 2 else 0
    found = []
    for seed in range(first, first + count):
        if is_livelock(seed):
            found.append(seed)
            print(f"livelock: seed {seed}", flush=True)
    print(f"{count} missions from seed {first}: {len(found)} livelocks {found}")
    sys.exit(bool(found))


if __name__ == "__main__":
    main()
