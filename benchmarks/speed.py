"""How fast missions run: a table in Markdown, with ratios measured in one run.

    python benchmarks/speed.py [--repeats 7] [--out docs/performance-table.md]

Every figure is the least CPU time of several repeats, compile time apart: on a machine that others
use too, the least is what the code itself takes. The unit is a fixed reference kernel, timed in the
same process between the missions, so that tables from two machines can be compared. Missions run
through the public ``Mission`` with the default scenario; only what a row names is changed. IR-SIM
(``pip install 'swarmscout[bench]'``) stands beside it where it can do the same part of the work.
"""

from __future__ import annotations

import argparse
import platform
import tempfile
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from time import perf_counter, process_time
from typing import Any

import numba
import numpy as np
from irsim_sensing import irsim_sensing_seconds

import swarmscout
from swarmscout import Mission, Scenario, load_world, record_mission


@dataclass(frozen=True)
class Row:
    """One mission to be timed."""

    what: str
    scenario: Scenario
    record: bool = False


@numba.njit
def _reference(n: int) -> int:
    """A fixed amount of integer work: n steps of a xorshift generator."""
    x = np.uint64(88172645463325252)
    for _ in range(n):
        x ^= x << np.uint64(13)
        x ^= x >> np.uint64(7)
        x ^= x << np.uint64(17)
    return x


REFERENCE_STEPS = 10_000_000

HEADER = (
    "| mission | CPU seconds | units | µs per step | robot-steps per second |\n"
    "|---|---:|---:|---:|---:|"
)


RECOMMENDED = "multi-criteria"


def rows() -> list[Row]:
    """What is measured in the world `lava-tube`."""
    found = []
    for rule in (RECOMMENDED, "quantile"):
        for start in ("one-place", "spread"):
            for robots in (15, 100, 1000):
                what = f"`{rule}`, N = {robots}, {start.replace('-', ' ')}"
                found.append(Row(what, Scenario(destinations=rule, robots=robots, start=start)))
    found += [
        Row(f"N = {n}, recorded in full", Scenario(destinations=RECOMMENDED, robots=n), record=True)
        for n in (15, 1000)
    ]
    apart = {"model": "disc", "range_m": 8.0}
    found += [
        Row(
            f"N = {n}, spread, links of 8 m",
            Scenario(destinations=RECOMMENDED, robots=n, start="spread", steps=100, radio=apart),
        )
        for n in (15, 100)
    ]
    found.append(Row("`paper-literal`, N = 15", swarmscout.load_scenario("paper-literal")))
    return found


def large_rows() -> list[Row]:
    """What is measured in the world `lava-network`."""
    return [
        Row(
            f"`{rule}`, N = {n:,}, {start.replace('-', ' ')}",
            Scenario(world="lava-network", destinations=rule, robots=n, start=start, steps=steps),
        )
        for rule in (RECOMMENDED, "quantile")
        for n, start, steps in (
            (100, "spread", 300), (1000, "spread", 100), (10_000, "spread", 30),
            (10_000, "one-place", 30),
        )
    ]  # fmt: skip


PHASES = {
    "sense": ("localization.read", "sensing.scan"),
    "map": ("_integrate",),
    "exchange": ("_exchange",),
    "charge": ("_charge_and_modes",),
    "teams": ("sizes.decide", "formation.reorganize"),
    "destinations": ("destinations.decide",),
    "routes": ("planner.plan",),
    "steer": ("planner.steer",),
    "act": ("motion.carry_out",),
    "judge": ("_judge",),
}
"""Phases of a step, and the methods of a mission's parts that make them."""


def phase_seconds(scenario: Scenario, world: swarmscout.World) -> dict[str, float]:
    """CPU seconds of each phase of one mission; the clock's own time is counted too."""
    mission = Mission(scenario, world=world)
    seconds = dict.fromkeys(PHASES, 0.0)

    def timed(phase: str, method: Callable[..., Any]) -> Callable[..., Any]:
        def call(*arguments: Any, **keys: Any) -> Any:
            started = perf_counter()
            result = method(*arguments, **keys)
            seconds[phase] += perf_counter() - started
            return result

        return call

    for phase, methods in PHASES.items():
        for path in methods:
            owner: Any = mission
            *parts, name = path.split(".")
            for part in parts:
                owner = getattr(owner, part)
            setattr(owner, name, timed(phase, getattr(owner, name)))
    mission.run()
    return seconds


def phase_lines(world: swarmscout.World, repeats: int) -> list[str]:
    """µs per robot-step of each phase, by number of robots."""
    scenarios = {n: Scenario(destinations=RECOMMENDED, robots=n) for n in (15, 100, 1000)}
    best: dict[int, dict[str, float]] = {}
    for n, scenario in scenarios.items():
        runs = [phase_seconds(scenario, world) for _ in range(repeats)]
        best[n] = {phase: min(run[phase] for run in runs) for phase in PHASES}
    lines = [
        f"µs per robot-step of each phase (`{RECOMMENDED}`, one place, least of {repeats}):",
        "",
        "| phase | " + " | ".join(f"N = {n}" for n in scenarios) + " |",
        "|---|" + "---:|" * len(scenarios),
    ]
    for phase in PHASES:
        cells = (1e6 * best[n][phase] / (n * scenarios[n].steps) for n in scenarios)
        lines.append(f"| {phase} | " + " | ".join(f"{cell:.3f}" for cell in cells) + " |")
    return lines


def least(run: Callable[[], float], repeats: int) -> tuple[float, float]:
    """The least of a number of repeats, and the least in units of the reference kernel.

    The reference is timed before each repeat, so that the unit has the machine's speed of that
    moment.
    """
    seconds, units = [], []
    for _ in range(repeats):
        unit = reference_seconds()
        seconds.append(run())
        units.append(seconds[-1] / unit)
    return min(seconds), min(units)


def reference_seconds() -> float:
    """CPU seconds of the reference kernel, once."""
    started = process_time()
    _reference(REFERENCE_STEPS)
    return process_time() - started


def mission_seconds(row: Row, world: swarmscout.World) -> float:
    """CPU seconds of one mission; setting it up is not counted, recording is."""
    if row.record:
        with tempfile.TemporaryDirectory() as folder:
            started = process_time()
            record_mission(row.scenario, world=world, out=Path(folder) / "run")
            return process_time() - started
    mission = Mission(row.scenario, world=world)
    started = process_time()
    mission.run()
    return process_time() - started


def sensing_seconds(world: swarmscout.World, robots: int, steps: int) -> float:
    """CPU seconds of sensing and moving alone, without any mind."""
    mission = Mission(Scenario(robots=robots), world=world)
    started = process_time()
    for step in range(1, steps + 1):
        mission.localization.read(mission.bodies, step, mission.minds.own)
        mission.sensing.scan(mission.bodies, step)
    return process_time() - started


def table(repeats: int) -> str:
    """The whole table in Markdown."""
    world = load_world("lava-tube")
    _reference(10)
    for row in rows():
        small = Scenario.model_validate({**row.scenario.model_dump(), "robots": 15, "steps": 60})
        Mission(small, world=world).run()
    unit = min(reference_seconds() for _ in range(3 * repeats))
    lines = [
        f"swarmscout {swarmscout.__version__}, Python {platform.python_version()}, "
        f"NumPy {np.__version__}, Numba {numba.__version__}, {platform.machine()}; one core; "
        f"least CPU time of {repeats} repeats; 300 steps in the world `lava-tube`. The reference "
        f"kernel ({REFERENCE_STEPS:,} xorshift steps) took {1e3 * unit:.1f} ms: one *unit*.",
        "",
        HEADER,
    ]
    lines += [line_of(row, world, repeats) for row in rows()]
    lines += ["", *phase_lines(world, repeats), "", *irsim_lines(world, repeats)]
    network = load_world("lava-network")
    lines += [
        "",
        "In the world `lava-network` (once each; to make the mission is not counted):",
        "",
        HEADER,
        *(line_of(row, network, 1) for row in large_rows()),
    ]
    return "\n".join(lines) + "\n"


def line_of(row: Row, world: swarmscout.World, repeats: int) -> str:
    """A line of the table."""
    seconds, units = least(lambda: mission_seconds(row, world), repeats)
    steps, robots = row.scenario.steps, row.scenario.robots
    return (
        f"| {row.what} | {seconds:.3f} | {units:.2f} | {1e6 * seconds / steps:,.0f} "
        f"| {robots * steps / seconds:,.0f} |"
    )


def irsim_lines(world: swarmscout.World, repeats: int) -> list[str]:
    """Sensing alone beside IR-SIM, both measured in this run."""
    robots, steps = 15, 60
    ours = least(lambda: sensing_seconds(world, robots, 20 * steps), repeats)[0] / 20
    recommended = Row("", Scenario(destinations=RECOMMENDED))
    whole = least(lambda: mission_seconds(recommended, world), repeats)[0]
    whole_rate = 300 * robots / whole
    theirs = irsim_sensing_seconds(robots, steps, repeats)
    if theirs is None:
        return ["IR-SIM is not installed here (`pip install 'swarmscout[bench]'`): not compared."]
    name, seconds = theirs
    rate, our_rate = robots * steps / seconds, robots * steps / ours
    return [
        f"Beside {name}, N = {robots}, nine rays of 1 m over 140° with noise:",
        "",
        "| | robot-steps per second | ratio |",
        "|---|---:|---:|",
        f"| {name}: sensing and motion alone | {rate:,.0f} | 1 |",
        f"| swarmscout: sensing alone | {our_rate:,.0f} | {our_rate / rate:,.0f} |",
        "| swarmscout: the whole mission (sensing, mapping, teams, destinations, routes, motion) "
        f"| {whole_rate:,.0f} | {whole_rate / rate:,.0f} |",
    ]


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--repeats", type=int, default=7)
    parser.add_argument("--out", type=Path, help="also write the table to this file")
    arguments = parser.parse_args()
    text = table(arguments.repeats)
    print(text)
    if arguments.out is not None:
        arguments.out.write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
