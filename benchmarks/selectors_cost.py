"""What a decision of each selector costs: the table "Cost" of docs/selectors.md.

python benchmarks/selectors_cost.py [--repeats 3]
"""

from __future__ import annotations

import argparse
import platform
from dataclasses import dataclass, field
from pathlib import Path
from time import process_time
from typing import Any

import numpy as np
from pages import write_section

import swarmscout
from swarmscout import Mission, Scenario, load_world
from swarmscout.destinations.registry import make_selector, selectors
from swarmscout.destinations.selector import Choice, Selector
from swarmscout.destinations.view import LeaderView
from swarmscout.studies.report_elements import Block, Heading, Table, Text


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
    world = load_world("lava-tube-wide", 0)
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


def cost_blocks(repeats: int) -> list[Block]:
    """Decision time per call, and a step's time."""
    found = costs(repeats)
    base = found["quantile"].step_ms
    rows = [
        [
            f"`{name}`", f"{cost.decision_ms:.3f}", f"{cost.frontiers:.0f}", f"{cost.teams:.0f}",
            f"{cost.step_ms:.2f}", f"{cost.step_ms / base:.2f}",
        ]
        for name, cost in found.items()
    ]  # fmt: skip
    return [
        Heading("Cost", 3),
        Text(
            "CPU time in missions of 100 robots (`lava-tube-wide`, 300 steps), the least mean of "
            f"{repeats} repeats; all that a rule asks of its view counts. swarmscout "
            f"{swarmscout.__version__}, Python {platform.python_version()}, NumPy "
            f"{np.__version__}, {platform.machine()}."
        ),
        Table(
            ["selector", "ms a decision", "frontiers", "other teams", "ms per step",
             "times `quantile`"],
            rows,
        ),
    ]  # fmt: skip


def main() -> None:
    """Measure, and write the section."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--repeats", type=int, default=3)
    write_section(Path("docs/selectors.md"), "cost", cost_blocks(parser.parse_args().repeats))


if __name__ == "__main__":
    main()
