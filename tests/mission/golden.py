"""Explored areas of whole missions, kept as numbers; run this file to make them anew.

They say how much a mission explores on average and how widely that varies, so that a change of
behaviour that nobody meant is noticed. After one that was meant: raise RULES_VERSION and run
``python tests/mission/golden.py``.
"""

from __future__ import annotations

import json
import sys
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np

from swarmscout.mission.mission import RULES_VERSION, Mission
from swarmscout.mission.scenario import Scenario
from swarmscout.worlds.catalogue import load_world

FILE = Path(__file__).with_name("golden_missions.json")
WORLDS: tuple[dict[str, Any], ...] = (
    {"world": "lava-tube", "world_seed": 0},
    {"world": "lava-tube-small", "world_seed": 0},
)
SELECTORS = ("quantile", "nearest", "random")
STARTS = ("one-place", "spread")
ROBOTS, STEPS = 15, 300
SEEDS_MADE, SEEDS_TESTED = 20, 4


def cases() -> list[tuple[str, dict[str, Any]]]:
    """Names of the missions, each with what it is run with."""
    return [
        (f"{world['world']}, {selector}, {start}", {**world, "selector": selector, "start": start})
        for world, selector, start in product(WORLDS, SELECTORS, STARTS)
    ]


def areas(case: dict[str, Any], seeds: int) -> list[float]:
    """Explored areas in m² with the first so many seeds."""
    world = load_world(case["world"], seed=case["world_seed"])
    found = []
    for seed in range(seeds):
        scenario = Scenario(
            robots=ROBOTS,
            steps=STEPS,
            seed=seed,
            start=case["start"],
            destinations=case["selector"],
        )
        found.append(Mission(scenario, world=world).run()["explored_m2"])
    return found


def main() -> None:
    """Make the file anew."""
    missions = {}
    for name, case in cases():
        found = np.array(areas(case, SEEDS_MADE))
        missions[name] = {
            "mean_m2": round(float(found.mean()), 3),
            "sd_m2": round(float(found.std(ddof=1)), 3),
        }
        print(f"{name}: {missions[name]}", file=sys.stderr)
    told = {
        "made_by": "python tests/mission/golden.py",
        "what": f"explored area of {ROBOTS} robots after {STEPS} steps, scenario 'paper', "
        f"mean and standard deviation over seeds 0 to {SEEDS_MADE - 1}",
        "rules_version": RULES_VERSION,
        "missions": missions,
    }
    FILE.write_text(json.dumps(told, indent=1) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
