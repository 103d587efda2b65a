"""What the desired team size is worth: the tables of docs/policies.md.

    python benchmarks/policies_table.py [--seeds 20] [--jobs 2] [--only SECTION]

rewrites what stands between the page's two markers, each section as soon as it is measured. All
policies run with the same worlds and seeds, so robots start at the same places with the same
charge and noise, and ratios are paired. Neither these worlds nor these seeds were used for tuning
(that was done with world seeds from 100 and mission seeds from 1000 on). Intervals are 95 %: BCa
bootstrap at 20 or more missions, Student's t below.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from functools import cache, partial
from pathlib import Path
from time import process_time

import numpy as np
from intervals import interval
from numpy.typing import NDArray
from selectors_table import NAMES, with_interval, write_section

from swarmscout import Mission, Scenario, load_world
from swarmscout.teams.registry import policies

SIZES = (1, 2, 3, 5, 8)
ADAPTIVE = tuple(name for name in policies() if name != "by-mode")
SECTIONS = {
    "15 robots from one place": (15, "one-place", 1.0),
    "50 robots from one place": (50, "one-place", 0.5),
    "15 robots, spread": (15, "spread", 0.25),
    "50 robots, spread": (50, "spread", 0.1),
}
"""Number of robots, start, and the share of the mission seeds (larger missions take longer)."""
WORLD_SEEDS = (0, 1, 2, 3)
SELECTORS = ("quantile", "multi-criteria")

Values = NDArray[np.float64]
load = cache(load_world)


@dataclass(frozen=True)
class Case:
    """Missions that differ in world and seed alone."""

    selector: str
    robots: int
    start: str
    policy: str
    size: int = 5
    leave_rule: str = "general"

    @property
    def label(self) -> str:
        """What its row is called."""
        if self.policy == "by-mode":
            return f"always {self.size}"
        splits = "" if self.leave_rule == "general" else ", without splitting"
        return f"`{self.policy}`{splits}"


def areas(job: tuple[Case, str, int, int]) -> list[float]:
    """Explored area in m² at the end, for each seed of a case in one world."""
    case, name, world_seed, seeds = job
    world = load(name, world_seed)
    found = []
    for seed in range(seeds):
        scenario = Scenario.model_validate(
            {
                "world": name,
                "world_seed": world_seed,
                "robots": case.robots,
                "start": case.start,
                "destinations": case.selector,
                "seed": seed,
                "teams": {
                    "policy": case.policy,
                    "desired_size": case.size,
                    "leave_rule": case.leave_rule,
                },
            }
        )
        mission = Mission(scenario, world=world)
        mission.run()
        found.append(mission.explored_m2)
    return found


def cases(selector: str, robots: int, start: str) -> list[Case]:
    """One for each row; the first is what all are compared with."""
    make = partial(Case, selector, robots, start)
    constant = [make("by-mode", size, "charge") for size in SIZES]
    adaptive = [make(name, leave_rule=rule) for name in ADAPTIVE for rule in ("general", "charge")]
    return constant + adaptive


def table(robots: int, start: str, seeds: int, jobs: int) -> Iterator[str]:
    """Explored area under each policy."""
    rows = {selector: cases(selector, robots, start) for selector in SELECTORS}
    every = [case for selector in SELECTORS for case in rows[selector]]
    todo = [(c, name, w, seeds) for c in every for name in NAMES for w in WORLD_SEEDS]
    found: dict[Case, list[float]] = {case: [] for case in every}
    with ProcessPoolExecutor(jobs) as pool:
        for job, result in zip(todo, pool.map(areas, todo), strict=True):
            found[job[0]] += result
    values = {case: np.array(result) for case, result in found.items()}
    missions = len(values[every[0]])
    worlds = ", ".join(f"`{name}`" for name in NAMES)
    yield (
        f"Explored area in m² after 300 steps, limited charge; worlds {worlds} with world seeds "
        f"{WORLD_SEEDS[0]} to {WORLD_SEEDS[-1]}, mission seeds 0 to {seeds - 1}: {missions} "
        "missions a cell. *Times 5*: over the paper's constant size 5, paired."
    )
    yield ""
    columns = " | ".join(f"`{selector}`, m² | times 5" for selector in SELECTORS)
    yield f"| desired size | {columns} |"
    yield "|---|" + "---:|---:|" * len(SELECTORS)
    for row in zip(*rows.values(), strict=True):
        cells = []
        for case in row:
            five = values[Case(case.selector, robots, start, "by-mode", 5, "charge")]
            low, high = interval(values[case])
            cells.append(f"{values[case].mean():.0f} [{low:.0f}, {high:.0f}]")
            cells.append(with_interval(values[case] / five))
        yield f"| {row[0].label} | " + " | ".join(cells) + " |"
    for name in ADAPTIVE:
        yield ""
        yield f"`{name}` over each constant size, by selector:"
        yield ""
        yield "| over | " + " | ".join(f"`{selector}`" for selector in SELECTORS) + " |"
        yield "|---|" + "---:|" * len(SELECTORS)
        for size in SIZES:
            cells = []
            for selector in SELECTORS:
                mine = values[Case(selector, robots, start, name)]
                constant = values[Case(selector, robots, start, "by-mode", size, "charge")]
                cells.append(with_interval(mine / constant))
            yield f"| always {size} | " + " | ".join(cells) + " |"


def cost_table(repeats: int) -> Iterator[str]:
    """What asking a policy costs."""
    yield (
        f"CPU time of asking once for all robots, the least mean of {repeats} repeats over the "
        "steps of a mission (`lava-tube-wide`, `quantile`, one place)."
    )
    yield ""
    numbers = (15, 50, 100)
    yield "| policy | " + " | ".join(f"{n} robots, µs" for n in numbers) + " |"
    yield "|---|" + "---:|" * len(numbers)
    world = load("lava-tube-wide", 0)
    for name in policies():
        cells = []
        for robots in numbers:
            scenario = Scenario.model_validate({"robots": robots, "teams": {"policy": name}})
            least = np.inf
            for _ in range(repeats):
                mission = Mission(scenario, world=world)
                spent, asked = 0.0, 0
                while not mission.done and mission.step_number < 100:
                    mission.step()
                    started = process_time()
                    for _ in range(20):
                        mission.sizes.decide(mission.minds, mission.grids, mission.step_number)
                    spent += process_time() - started
                    asked += 20
                least = min(least, 1e6 * spent / asked)
            cells.append(f"{least:.1f}")
        yield f"| `{name}` | " + " | ".join(cells) + " |"


def main() -> None:
    """Measure, print, and write the tables into the page, each as soon as it is done."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seeds", type=int, default=20)
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--page", type=Path, default=Path("docs/policies.md"))
    parser.add_argument("--only", choices=[*SECTIONS, "Cost"], help="measure one section alone")
    arguments = parser.parse_args()
    makers = {
        title: partial(table, robots, start, max(2, round(share * arguments.seeds)), arguments.jobs)
        for title, (robots, start, share) in SECTIONS.items()
    }
    makers["Cost"] = partial(cost_table, 3)
    for title, make in makers.items():
        if arguments.only in (None, title):
            text = "\n".join(make())
            print(f"### {title}\n\n{text}\n", flush=True)
            write_section(arguments.page, title, text, tuple(makers))


if __name__ == "__main__":
    main()
