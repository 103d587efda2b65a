"""How much robots stand in each other's way: stuck robots, blocked moves, explored area.

A robot is stuck while it explores, has somewhere to go, is away from charging stations, and stays
within 0.5 m for 60 steps or more; all steps of such a stretch count.

    python benchmarks/jams.py --worlds lava-tube-wide lava-tube --robots 50 100 --seeds 2
"""

from __future__ import annotations

import argparse
import time
from typing import Any

import numpy as np
from numpy.typing import NDArray

from swarmscout import Mission, Scenario, load_world
from swarmscout.core.enums import EXPLORE

WINDOW_STEPS, WITHIN_M, OFF_STATION_M = 60, 0.5, 3.0


def stuck_steps(places: NDArray[np.float64], wanting: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Which steps belong to a stretch of 60 in which a robot wants to drive and gets nowhere.

    Args:
        places: float64[T, N, 2] in metres, after each step. wanting: bool[T, N].

    Returns:
        bool[T, N].
    """
    steps = len(places)
    stuck = np.zeros(wanting.shape, dtype=np.bool_)
    for end in range(WINDOW_STEPS, steps):
        window = slice(end - WINDOW_STEPS, end)
        away = np.hypot(*np.moveaxis(places[window] - places[end - WINDOW_STEPS], -1, 0))
        stuck[window] |= (away.max(axis=0) < WITHIN_M) & wanting[window].all(axis=0)
    return stuck


def measure(world: str, robots: int, seed: int, keys: dict[str, Any]) -> dict[str, float]:
    """One mission's figures."""
    scenario = Scenario.model_validate(
        {"world": world, "robots": robots, "seed": seed, "world_seed": seed, **keys}
    )
    mission = Mission(scenario, world=load_world(world, seed=seed))
    places, wanting = [], []
    started = time.process_time()
    while not mission.done:
        mission.step()
        own, bodies = mission.minds.own, mission.bodies
        places.append(bodies.position.copy())
        off = np.ones(robots, dtype=np.bool_)
        for x_m, y_m in mission.stations_m:
            off &= np.hypot(*(bodies.position - (x_m, y_m)).T) > OFF_STATION_M
        wanting.append(own["thinks"] & (own["mode"] == EXPLORE) & (own["target"] >= 0) & off)
    summary = mission.summary()
    want = np.array(wanting)
    stuck = stuck_steps(np.array(places), want)
    alive = summary["steps"] * robots
    return {
        "explored": summary["explored_m2"],
        "blocked": 100.0 * summary["blocked_share"],
        "stuck": 100.0 * stuck.sum() / alive,
        "stuck robots": int(stuck.any(axis=0).sum()),
        "longest": int(longest_run(stuck)),
        "stranded": summary["stranded"],
        "steps": summary["steps"],
        "s": time.process_time() - started,
    }


def longest_run(stuck: NDArray[np.bool_]) -> int:
    """The longest stretch of stuck steps of any robot."""
    run = np.zeros(stuck.shape[1], dtype=np.int64)
    longest = 0
    for row in stuck:
        run = np.where(row, run + 1, 0)
        longest = max(longest, int(run.max()))
    return longest


def main() -> None:
    """Print a line per mission, and the means."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--worlds", nargs="+", default=["lava-tube-wide", "lava-tube"])
    parser.add_argument("--robots", nargs="+", type=int, default=[100])
    parser.add_argument("--seeds", type=int, default=2)
    parser.add_argument("--steps", type=int, default=600)
    parser.add_argument("--destinations", default="multi-criteria")
    parser.add_argument("--members", default="shared")
    parser.add_argument("--battery", choices=["off", "threshold", "distance"], default="off")
    parser.add_argument("--start", default="")
    given = parser.parse_args()
    keys: dict[str, Any] = {
        "steps": given.steps,
        "destinations": given.destinations,
        "teams": {"members": given.members},
        "battery": {"enabled": False} if given.battery == "off" else {"return_rule": given.battery},
    }
    if given.start:
        keys["start"] = given.start
    for world in given.worlds:
        for robots in given.robots:
            rows = [measure(world, robots, seed, keys) for seed in range(given.seeds)]
            for seed, row in enumerate(rows):
                figures = "  ".join(f"{name} {value:.6g}" for name, value in row.items())
                print(f"{world} N {robots} seed {seed}: {figures}", flush=True)
            means = {name: float(np.mean([row[name] for row in rows])) for name in rows[0]}
            figures = "  ".join(f"{name} {value:.4g}" for name, value in means.items())
            print(f"{world} N {robots} MEAN: {figures}", flush=True)


if __name__ == "__main__":
    main()
