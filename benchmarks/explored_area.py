"""How much three selectors explore: a table in Markdown, over paired seeds.

    python benchmarks/explored_area.py [--seeds 20] [--jobs 2] [--out docs/explored-area-table.md]

Every mission has N = 15 robots, 300 steps and the default scenario; the same seeds are used for
all selectors, so robots start at the same places with the same charge and noise. Intervals are
95 %: BCa bootstrap at 20 or more seeds, Student's t below. Ratios to the baseline are paired.
"""

from __future__ import annotations

import argparse
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path

import numpy as np
from intervals import interval

from swarmscout import Mission, Scenario, load_world

WORLDS = ("lava-tube", "lava-tube-braided")
STARTS = ("one-place", "spread")
SELECTORS = ("quantile", "nearest", "random")


def areas(case: tuple[str, str, str, int]) -> list[float]:
    """Explored areas in m² of one case over its seeds."""
    world_name, start, selector, seeds = case
    world = load_world(world_name)
    return [
        Mission(
            Scenario(world=world_name, start=start, destinations=selector, seed=seed), world=world
        ).run()["explored_m2"]
        for seed in range(seeds)
    ]


def table(seeds: int, jobs: int) -> str:
    """The whole table in Markdown."""
    cases = [(w, st, se, seeds) for w in WORLDS for st in STARTS for se in SELECTORS]
    with ProcessPoolExecutor(jobs) as pool:
        found = {
            case[:3]: np.array(result)
            for case, result in zip(cases, pool.map(areas, cases), strict=True)
        }
    lines = [
        f"N = 15, 300 steps, {seeds} paired seeds, mean [95 % interval].",
        "",
        "| world | start | selector | explored m² | standard deviation | times `quantile` |",
        "|---|---|---|---:|---:|---:|",
    ]
    for (world, start, selector), values in found.items():
        low, high = interval(values)
        ratio = values / found[world, start, "quantile"]
        ratio_low, ratio_high = interval(ratio)
        lines.append(
            f"| `{world}` | {start} | `{selector}` | {values.mean():.1f} [{low:.1f}, {high:.1f}] "
            f"| {values.std(ddof=1):.1f} "
            f"| {ratio.mean():.2f} [{ratio_low:.2f}, {ratio_high:.2f}] |"
        )
    return "\n".join(lines) + "\n"


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seeds", type=int, default=20)
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--out", type=Path, help="also write the table to this file")
    arguments = parser.parse_args()
    text = table(arguments.seeds, arguments.jobs)
    print(text)
    if arguments.out is not None:
        arguments.out.write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
