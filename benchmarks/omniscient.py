"""What a selector could gain if it knew which ground is open: a measure of what is left.

    python benchmarks/omniscient.py [--seeds 5] [--jobs 2]

`multi-criteria` weighs the unknown ground round a frontier, less where walls are known. Here the
same rule knows the truth: only ground that is unknown *and* can be driven on counts. No robot
could know that. The worlds are those of studies/selectors.toml; the section is in
docs/selectors.md.
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from pages import write_section
from scipy.signal import fftconvolve

from swarmscout import Mission, Scenario
from swarmscout.core.enums import UNKNOWN
from swarmscout.destinations.multi_criteria import MultiCriteria
from swarmscout.destinations.registry import make_selector
from swarmscout.destinations.selector import Choice
from swarmscout.destinations.view import LeaderView
from swarmscout.studies.formatting import with_interval
from swarmscout.studies.intervals import by_unit, mean_interval
from swarmscout.studies.report_elements import Block, Table, Text

WORLDS = ("lava-tube", "lava-tube-braided", "lava-tube-wide", "lava-maze")
WORLD_SEEDS = range(4)
INFORMED = "`multi-criteria`, knowing what is open"


class Told:
    """A view that counts open ground as unknown, and knows of no walls besides."""

    def __init__(self, view: LeaderView, mission: Mission) -> None:
        self._view = view
        self._mission = mission

    def __getattr__(self, name: str) -> Any:
        return getattr(self._view, name)

    def unknown_m2(self, reach_m: float) -> NDArray[np.float64]:
        """float64[F], unknown ground within reach of each frontier that robots can drive on."""
        frame = self._mission.frame
        drivable = self._mission.judge.truth.reachable.reshape(frame.shape) > 0
        left = drivable & (self._mission.map.labels == UNKNOWN)
        cells = int(reach_m / frame.cell_m)
        down, across = np.mgrid[-cells : cells + 1, -cells : cells + 1]
        disc = down**2 + across**2 <= cells**2
        counts = fftconvolve(left.astype(float), disc.astype(float), "same")
        rows, columns = self._view.frontiers.T
        area: NDArray[np.float64] = np.rint(counts[rows, columns]) * frame.cell_m**2
        return area

    def area_m2(self, kind: str, reach_m: float) -> NDArray[np.float64]:
        """Zeros: what is open is known, so walls say nothing more."""
        return np.zeros(len(self._view.frontiers))


class Omniscient:
    """`multi-criteria` with another view."""

    def __init__(self) -> None:
        self._rule = MultiCriteria()
        self.mission: Mission | None = None

    def choose(self, view: LeaderView, memory: Any) -> Choice:
        """See :class:`swarmscout.destinations.selector.Selector`."""
        assert self.mission is not None
        return self._rule.choose(Told(view, self.mission), memory)  # type: ignore[arg-type]


def area_m2(rule: str, place: tuple[str, int, int]) -> float:
    """Explored area after a mission."""
    world, world_seed, seed = place
    scenario = Scenario(world=world, world_seed=world_seed, seed=seed)
    selector = Omniscient() if rule == INFORMED else make_selector(rule)
    mission = Mission(scenario, selector=selector)
    if isinstance(selector, Omniscient):
        selector.mission = mission
    mission.run()
    return mission.explored_m2


def main(argv: Sequence[str] | None = None) -> None:
    """Fly, and write the section."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seeds", type=int, default=5)
    parser.add_argument("--jobs", type=int, default=2)
    given = parser.parse_args(argv)
    places = [(w, k, s) for w in WORLDS for k in WORLD_SEEDS for s in range(given.seeds)]
    units = [f"{world} {world_seed}" for world, world_seed, _ in places]
    rules = ("quantile", "multi-criteria", INFORMED)
    with ProcessPoolExecutor(given.jobs) as pool:
        areas = {
            rule: np.array(list(pool.map(partial(area_m2, rule), places, chunksize=4)))
            for rule in rules
        }
    rows = []
    for rule, its in areas.items():
        ratio = its / areas["quantile"]
        name = rule if rule == INFORMED else f"`{rule}`"
        cells = [with_interval(mean_of(values, units)) for values in (its, ratio)]
        rows.append([name, cells[0], "1" if rule == "quantile" else cells[1]])
    blocks: list[Block] = [
        Text(
            f"{len(places)} missions of 15 robots and 300 steps for each rule, from one place, in "
            f"{len(set(units))} worlds, seeds 0 to {given.seeds - 1}; means with 95 % intervals "
            "that rest on worlds."
        ),
        Table(["rule", "m² at 300", "times `quantile`"], rows),
    ]
    write_section(Path("docs/selectors.md"), "omniscient", blocks)


def mean_of(values: NDArray[np.float64], units: list[str]) -> Any:
    """The mean over worlds of the mean over seeds, with its interval."""
    return mean_interval([float(unit.mean()) for unit in by_unit(values, units)])


if __name__ == "__main__":
    main()
