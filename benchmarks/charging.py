"""How many robots a fault-free swarm loses for want of charge, in worlds with enough places.

    python benchmarks/charging.py [--seeds 8] [--steps 3000] [--robots 1 15 50 100 200]

Prints a line for each world and number of robots, and what all lost together. The goal is 2 %.
"""

from __future__ import annotations

import argparse

from swarmscout import Mission, Scenario

WORLDS = ("lava-tube", "lava-tube-braided", "lava-tube-wide", "lava-maze")


def main() -> None:
    """Run the missions one after the other."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seeds", type=int, default=8)
    parser.add_argument("--steps", type=int, default=3000)
    parser.add_argument("--robots", type=int, nargs="+", default=[1, 15, 50, 100, 200])
    given = parser.parse_args()
    lost = robots = worst = 0
    for world in WORLDS:
        for n in given.robots:
            stranded, charges, area = [], 0, 0.0
            for seed in range(given.seeds):
                scenario = Scenario(
                    world=world, world_seed=seed, robots=n, steps=given.steps, seed=seed,
                    destinations="multi-criteria", battery={"return_rule": "distance"},
                )  # fmt: skip
                summary = Mission(scenario).run()
                stranded.append(int(summary["stranded"]))
                charges += int(summary["charges"])
                area += float(summary["explored_m2"]) / given.seeds
            lost += sum(stranded)
            robots += n * given.seeds
            worst = max(worst, max(stranded) / n)
            print(
                f"{world}, {n} robots: lost {stranded}, "
                f"{charges / (n * given.seeds):.1f} charges per robot, {area:.0f} m²",
                flush=True,
            )
    print(f"lost {lost} of {robots} robots, {lost / robots:.1%}; at worst {worst:.1%} of a swarm")


if __name__ == "__main__":
    main()
