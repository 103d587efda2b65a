"""Tune the parameters of selectors, each with the same number of missions.

    python benchmarks/tune_selectors.py multi-criteria utility [--rounds 6] [--jobs 2]

The method is the cross-entropy method: a round draws settings from a normal distribution over the
ranges below (their logarithms where a range spans a factor of four or more), tries all of them in
the same missions, and moves the distribution to the best quarter. The first setting tried is the
selector's own. At the end, the middle of the distribution and the best settings of all rounds meet
the selector's own in missions that none has seen; the best there is printed.

What is maximised is the mean ratio to `quantile` in the same mission (N = 15, 300 steps, teams of
5, from one place, limited charge). Worlds have seeds from 100 on and missions from 1000 on;
the tables of docs/selectors.md use neither.
"""

from __future__ import annotations

import argparse
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from swarmscout import Mission, Scenario, load_world
from swarmscout.destinations.registry import SELECTORS, make_selector

NAMES = ("lava-tube", "lava-tube-braided", "lava-tube-wide", "lava-maze")
FIRST_WORLD, FIRST_MISSION = 100, 1000

Ranges = dict[str, tuple[float, float]]
RANGES: dict[str, Ranges] = {
    "quantile-local": {"radius_m": (2.0, 20.0)},
    "utility": {"range_m": (2.0, 40.0), "beta_per_m": (0.02, 1.0)},
    "information-gain": {"reach_m": (0.8, 4.0), "decay_per_m": (0.05, 2.0)},
    "potential": {"range_m": (2.0, 40.0), "push_m3": (1.0, 3000.0)},
    "llm-like": {
        "apart_m": (2.0, 30.0),
        "shyness_m": (0.5, 30.0),
        "frontier_m": (0.02, 2.0),
        "obstacle_m": (0.2, 20.0),
    },
    "multi-criteria": {
        "way": (0.05, 2.0),
        "front": (0.2, 3.0),
        "turn_m": (0.15, 3.0),
        "near_gain": (0.1, 4.0),
        "open_gain": (0.1, 4.0),
        "open_m": (1.4, 3.3),
        "wall": (0.7, 10.0),
        "apart": (0.5, 15.0),
        "apart_m": (2.0, 12.0),
        "ahead": (0.1, 5.0),
        "keep": (0.2, 0.9),
    },
}
"""What is tuned; a rule that is not named here has no parameters, or those of the paper."""

Vector = NDArray[np.float64]
load = cache(load_world)


@dataclass(frozen=True)
class Budget:
    """How much is tried.

    Attributes:
        rounds: of the search; settings: tried in each; missions: for each setting in a round.
        finals: settings that meet at the end, in three times as many missions.
        spread: of the first settings, as a share of each range.
    """

    rounds: int
    settings: int
    missions: int
    finals: int
    spread: float


@dataclass(frozen=True)
class Place:
    """A mission that settings are tried in."""

    world: str
    world_seed: int
    seed: int


def places(count: int, first: int) -> list[Place]:
    """Missions `first` … of an endless list that goes round the worlds, each with its own seeds."""
    kinds = len(NAMES)
    return [
        Place(NAMES[k % kinds], FIRST_WORLD + k // kinds % 8, FIRST_MISSION + k)
        for k in range(first, first + count)
    ]


def area(job: tuple[str, dict[str, float], Place]) -> float:
    """Explored area in m² after a mission."""
    name, parameters, place = job
    scenario = Scenario(world=place.world, world_seed=place.world_seed, seed=place.seed)
    world = load(place.world, place.world_seed)
    mission = Mission(scenario, world=world, selector=make_selector(name, parameters))
    mission.run()
    return mission.explored_m2


class Trial:
    """Tries settings in missions, and remembers how the baseline fared in each."""

    def __init__(self, pool: ProcessPoolExecutor, name: str) -> None:
        self.pool = pool
        self.name = name
        self.missions = 0
        self._base: dict[Place, float] = {}

    def ratios(self, settings: list[dict[str, float]], where: list[Place]) -> Vector:
        """[settings, places], areas over the baseline's."""
        new = [place for place in where if place not in self._base]
        jobs: list[tuple[str, dict[str, float], Place]] = [("quantile", {}, p) for p in new]
        jobs += [(self.name, setting, place) for setting in settings for place in where]
        found = list(self.pool.map(area, jobs, chunksize=4))
        self._base.update(zip(new, found, strict=False))
        self.missions += len(jobs) - len(new)
        base = np.array([self._base[place] for place in where])
        return np.array(found[len(new) :]).reshape(len(settings), len(where)) / base


class Space:
    """Settings as vectors: each parameter in [0, 1] over its range."""

    def __init__(self, ranges: Ranges) -> None:
        self.names = list(ranges)
        self.low = np.array([low for low, _ in ranges.values()])
        self.high = np.array([high for _, high in ranges.values()])
        self.as_logarithm = (self.low > 0.0) & (self.high >= 4.0 * self.low)

    def setting(self, vector: Vector) -> dict[str, float]:
        """The parameters that a vector stands for, to three digits."""
        safe = np.where(self.as_logarithm, self.low, 1.0)
        ratio = np.where(self.as_logarithm, self.high / safe, 1.0)
        values = np.where(
            self.as_logarithm, safe * ratio**vector, self.low + vector * (self.high - self.low)
        )
        pairs = zip(self.names, values.tolist(), strict=True)
        return {name: float(f"{value:.3g}") for name, value in pairs}

    def vector(self, selector: Any) -> Vector:
        """Where a selector's own parameters stand."""
        values = np.array([getattr(selector, name) for name in self.names])
        inside = np.clip(values, self.low, self.high)
        safe = np.where(self.as_logarithm, self.low, 1.0)
        ratio = np.where(self.as_logarithm, self.high / safe, np.e)
        logarithm = np.log(np.where(self.as_logarithm, inside, 1.0) / safe) / np.log(ratio)
        return np.where(self.as_logarithm, logarithm, (inside - self.low) / (self.high - self.low))


def tune(trial: Trial, space: Space, budget: Budget) -> None:
    """Search, and print what is found."""
    rng = np.random.default_rng(0)
    own = space.vector(make_selector(trial.name))
    mean, sigma = own.copy(), np.full(len(own), budget.spread)
    best: list[tuple[float, dict[str, float]]] = []
    for number in range(budget.rounds):
        drawn = rng.normal(mean, sigma, (budget.settings, len(own)))
        # What leaves the range comes back in from its end, so that ends are not crowded.
        drawn = 1.0 - np.abs(1.0 - np.abs(drawn) % 2.0)
        drawn[0] = mean
        where = places(budget.missions, number * budget.missions)
        tried = [space.setting(vector) for vector in drawn]
        ratios = trial.ratios(tried, where).mean(axis=1)
        order = np.argsort(-ratios)
        elite = drawn[order[: max(2, budget.settings // 4)]]
        mean = 0.3 * mean + 0.7 * elite.mean(axis=0)
        sigma = 0.3 * sigma + 0.7 * np.maximum(elite.std(axis=0), 0.03)
        best += [(ratios[k] - ratios.mean(), tried[k]) for k in order[:2]]
        print(f"round {number + 1}: {ratios[order[0]]:.3f} {tried[order[0]]}", flush=True)
    best.sort(key=lambda pair: -pair[0])
    # What the selector has now stands first, and a better one has to beat it.
    candidates = [{}, space.setting(mean), *[setting for _, setting in best[: budget.finals - 2]]]
    where = places(3 * budget.missions, budget.rounds * budget.missions)
    ratios = trial.ratios(candidates, where)
    for values, setting in zip(ratios, candidates, strict=True):
        error = values.std(ddof=1) / np.sqrt(len(values))
        print(f"final: {values.mean():.3f} ± {error:.3f} {setting or 'as it is'}", flush=True)
    chosen = candidates[int(ratios.mean(axis=1).argmax())]
    print(f"{trial.name}: {chosen or 'as it is'} after {trial.missions} missions", flush=True)


def main() -> None:
    """Tune what is named, or all that have ranges."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("selectors", nargs="*", metavar="SELECTOR", help=", ".join(RANGES))
    parser.add_argument("--rounds", type=int, default=6)
    parser.add_argument("--settings", type=int, default=16, help="tried in each round")
    parser.add_argument("--missions", type=int, default=12, help="for each setting in a round")
    parser.add_argument("--finals", type=int, default=6, help="settings that meet at the end")
    parser.add_argument("--spread", type=float, default=0.2, help="at first, of the whole range")
    parser.add_argument("--jobs", type=int, default=2)
    given = parser.parse_args()
    names = given.selectors or list(RANGES)
    unknown = [name for name in names if name not in RANGES]
    if unknown:
        known = ", ".join(RANGES)
        count = len(SELECTORS.built_in)
        parser.error(f"nothing to tune in '{unknown[0]}' (of {count} rules): {known}")
    budget = Budget(given.rounds, given.settings, given.missions, given.finals, given.spread)
    with ProcessPoolExecutor(given.jobs) as pool:
        for name in names:
            print(f"{name}: {RANGES[name]}", flush=True)
            tune(Trial(pool, name), Space(RANGES[name]), budget)


if __name__ == "__main__":
    main()
