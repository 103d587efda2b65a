"""How well every selector explores, and what a decision costs: the tables of docs/selectors.md.

    python benchmarks/selectors_table.py [--seeds 20] [--jobs 2] [--only SECTION]

rewrites what stands between the page's two markers. All selectors run with the same seeds, so
robots start at the same places with the same charge and noise, and ratios are paired. Neither these
worlds nor these seeds were used for tuning (that was done with seeds from 1000 on). Intervals are
95 %: BCa bootstrap at 20 or more missions, Student's t below.
"""

from __future__ import annotations

import argparse
import platform
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path
from time import process_time
from typing import Any

import numpy as np
from intervals import interval
from numpy.typing import NDArray

import swarmscout
from swarmscout import Mission, Scenario, load_world
from swarmscout.destinations.registry import RECOMMENDED, make_selector, selectors
from swarmscout.destinations.selector import Choice, Selector
from swarmscout.minds.view import LeaderView

BEGIN, END = "<!-- tables begin -->", "<!-- tables end -->"
SECTIONS = ("Explored area", "Cost", "Other starts and team sizes")
NAMES = ("lava-tube", "lava-tube-braided", "lava-tube-wide", "lava-maze")
WORLD_SEEDS = (0, 1, 2, 3)
AT_STEPS = (100, 200, 300)
SENSING_LIMIT_M2 = 138.0
"""What one robot that drives straight in the open maps in 300 steps."""

Values = NDArray[np.float64]
load = cache(load_world)


@dataclass(frozen=True)
class Case:
    """Missions of one selector, which differ in world and seed alone."""

    selector: str
    start: str = "one-place"
    team_size: int = 5
    world_seeds: tuple[int, ...] = (0,)


def areas(job: tuple[Case, str, int, int]) -> list[list[float]]:
    """Explored area in m² at AT_STEPS, for each seed of a case in one world."""
    case, name, world_seed, seeds = job
    world = load(name, world_seed)
    found = []
    for seed in range(seeds):
        scenario = Scenario.model_validate(
            {
                "world": name,
                "world_seed": world_seed,
                "start": case.start,
                "destinations": case.selector,
                "seed": seed,
                "teams": {"desired_size": case.team_size},
            }
        )
        curve = [0.0]
        Mission(scenario, world=world).run(lambda m, kept=curve: kept.append(m.explored_m2))
        found.append([curve[min(step, len(curve) - 1)] for step in AT_STEPS])
    return found


def measure(cases: list[Case], seeds: int, jobs: int) -> dict[Case, Values]:
    """[worlds × seeds, 3] explored areas of each case."""
    todo = [(c, name, w, seeds) for c in cases for name in NAMES for w in c.world_seeds]
    found: dict[Case, list[list[float]]] = {case: [] for case in cases}
    with ProcessPoolExecutor(jobs) as pool:
        for job, result in zip(todo, pool.map(areas, todo), strict=True):
            found[job[0]] += result
    return {case: np.array(result) for case, result in found.items()}


def with_interval(values: Values) -> str:
    """The mean and its interval."""
    low, high = interval(values)
    return f"{values.mean():.2f} [{low:.2f}, {high:.2f}]"


@dataclass
class Timed:
    """A selector whose decisions are timed."""

    rule: Selector
    seconds: list[float] = field(default_factory=list)
    frontiers: list[int] = field(default_factory=list)
    teams: list[int] = field(default_factory=list)

    def choose(self, view: LeaderView, memory: Any) -> Choice:
        """What the rule chooses; all that it makes the view work out counts as its time."""
        started = process_time()
        choice = self.rule.choose(view, memory)
        self.seconds.append(process_time() - started)
        self.frontiers.append(len(view.frontiers))
        self.teams.append(len(view.others.leaders))
        return choice


@dataclass(frozen=True)
class Cost:
    """What a selector's decisions cost in missions of 100 robots."""

    decision_ms: float
    step_ms: float
    frontiers: float
    teams: float


def costs(repeats: int) -> dict[str, Cost]:
    """CPU times of each selector, the least of several repeats, one process at a time."""
    found = {}
    world = load("lava-tube-wide", 0)
    for name in selectors():
        decision, step = [], []
        for _ in range(repeats + 1):
            scenario = Scenario(world="lava-tube-wide", robots=100, destinations=name)
            mission = Mission(scenario, world=world)
            timed = Timed(make_selector(name))
            mission.destinations.selector = timed
            mission.run()
            decision.append(1e3 * float(np.mean(timed.seconds)))
            plain = Mission(scenario, world=world)
            started = process_time()
            plain.run()
            step.append(1e3 * (process_time() - started) / plain.step_number)
        # The first mission may have compiled something.
        found[name] = Cost(
            min(decision[1:]),
            min(step[1:]),
            float(np.mean(timed.frontiers)),
            float(np.mean(timed.teams)),
        )
    return found


def main_table(seeds: int, jobs: int) -> Iterator[str]:
    """Explored area at three times, ratios, share of the limit."""
    cases = {name: Case(name, world_seeds=WORLD_SEEDS) for name in selectors()}
    found = measure(list(cases.values()), seeds, jobs)
    base = found[cases["quantile"]][:, -1]
    best = found[cases[RECOMMENDED]][:, -1]
    worlds = ", ".join(f"`{name}`" for name in NAMES)
    yield (
        f"N = 15, desired team size 5, from one place, limited charge; worlds {worlds} with world "
        f"seeds {WORLD_SEEDS[0]} to {WORLD_SEEDS[-1]}, mission seeds 0 to {seeds - 1}: "
        f"{len(base)} missions a row. *Limit*: share of {15 * SENSING_LIMIT_M2:.0f} m², what 15 "
        f"robots that drive straight in the open would map. The last column is the area of "
        f"`{RECOMMENDED}` over that of the row: above 1 in its whole interval means better."
    )
    yield ""
    header = " | ".join(f"m² at {step}" for step in AT_STEPS)
    yield f"| selector | {header} | times `quantile` | limit | `{RECOMMENDED}` over it |"
    yield "|---|" + "---:|" * (len(AT_STEPS) + 3)
    order = sorted(cases, key=lambda name: found[cases[name]][:, -1].mean())
    for name in order:
        values = found[cases[name]]
        low, high = interval(values[:, -1])
        early = " | ".join(f"{mean:.0f}" for mean in values[:, :-1].mean(axis=0))
        yield (
            f"| `{name}` | {early} | {values[:, -1].mean():.0f} [{low:.0f}, {high:.0f}] "
            f"| {with_interval(values[:, -1] / base)} "
            f"| {100 * values[:, -1].mean() / (15 * SENSING_LIMIT_M2):.1f} % "
            f"| {with_interval(best / values[:, -1])} |"
        )
    yield ""
    yield f"`{RECOMMENDED}` over `quantile` by world:"
    yield ""
    yield "| world | " + " | ".join(f"seed {w}" for w in WORLD_SEEDS) + " |"
    yield "|---|" + "---:|" * len(WORLD_SEEDS)
    by_world = (best / base).reshape(len(NAMES), len(WORLD_SEEDS), seeds)
    for name, ratios in zip(NAMES, by_world, strict=True):
        yield f"| `{name}` | " + " | ".join(with_interval(r) for r in ratios) + " |"


def settings_table(seeds: int, jobs: int) -> Iterator[str]:
    """Other starts and team sizes: explored area at the end, and the ratio to the baseline."""
    settings = [("spread", 5), *(("one-place", size) for size in (1, 3, 8))]
    cases = [Case(name, start, size) for name in selectors() for start, size in settings]
    found = measure(cases, seeds, jobs)
    yield (
        f"Area in m² after {AT_STEPS[-1]} steps, and times `quantile` in the same setting; world "
        f"seed 0 of the same worlds, {len(NAMES) * seeds} missions a cell."
    )
    yield ""
    yield (
        "| selector | " + " | ".join(f"{start}, teams of {size}" for start, size in settings) + " |"
    )
    yield "|---|" + "---:|" * len(settings)
    for name in selectors():
        cells = []
        for start, size in settings:
            values = found[Case(name, start, size)][:, -1]
            base = found[Case("quantile", start, size)][:, -1]
            cells.append(f"{values.mean():.0f}: {with_interval(values / base)}")
        yield f"| `{name}` | " + " | ".join(cells) + " |"


def cost_table(repeats: int) -> Iterator[str]:
    """Decision time per call, and a step's time."""
    found = costs(repeats)
    base = found["quantile"].step_ms
    yield (
        "CPU time in missions of 100 robots (`lava-tube-wide`, 300 steps), the least mean of "
        f"{repeats} repeats; all that a rule asks of its view counts. swarmscout "
        f"{swarmscout.__version__}, Python {platform.python_version()}, NumPy {np.__version__}, "
        f"{platform.machine()}."
    )
    yield ""
    yield "| selector | ms a decision | frontiers | other teams | ms per step | times `quantile` |"
    yield "|---|---:|---:|---:|---:|---:|"
    for name, cost in found.items():
        yield (
            f"| `{name}` | {cost.decision_ms:.3f} | {cost.frontiers:.0f} | {cost.teams:.0f} "
            f"| {cost.step_ms:.2f} | {cost.step_ms / base:.2f} |"
        )


def write_section(page: Path, title: str, text: str, order: tuple[str, ...] = SECTIONS) -> None:
    """Put a section between the page's markers, in the place of the one with the same title."""
    before, _, rest = page.read_text(encoding="utf-8").partition(BEGIN)
    inside, _, after = rest.partition(END)
    sections = {}
    for part in inside.split("### ")[1:]:
        heading, _, body = part.partition("\n")
        sections[heading.strip()] = body.strip()
    sections[title] = text
    body = "\n\n".join(f"### {t}\n\n{sections[t]}" for t in order if t in sections)
    page.write_text(f"{before}{BEGIN}\n\n{body}\n\n{END}{after}", encoding="utf-8")


def main() -> None:
    """Measure, print, and write the tables into the page, each as soon as it is done."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seeds", type=int, default=20)
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--repeats", type=int, default=3)
    parser.add_argument("--page", type=Path, default=Path("docs/selectors.md"))
    parser.add_argument("--only", choices=list(SECTIONS), help="measure one section alone")
    arguments = parser.parse_args()
    seeds, jobs = arguments.seeds, arguments.jobs
    makers = (
        lambda: main_table(seeds, jobs),
        lambda: cost_table(arguments.repeats),
        lambda: settings_table(seeds // 2, jobs),
    )
    for title, make in zip(SECTIONS, makers, strict=True):
        if arguments.only in (None, title):
            text = "\n".join(make())
            print(f"### {title}\n\n{text}\n", flush=True)
            write_section(arguments.page, title, text)


if __name__ == "__main__":
    main()
