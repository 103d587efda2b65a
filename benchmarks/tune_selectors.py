"""Tune the parameters of selectors, each with the same number of missions.

    python benchmarks/tune_selectors.py multi-criteria utility [--rounds 6] [--jobs 2]

Optuna's sampler (TPE, Bergstra et al. 2011) proposes settings within the ranges below, on a
logarithmic scale where a range spans a factor of four or more. The settings of a round run in the
same missions, and every round has new ones. The first setting is the selector's own. At the end the
best settings of all rounds meet the selector's own in missions that no round used, and the best of
these is printed.

The objective is the mean ratio to `quantile` in the same mission (N = 15, 300 steps, teams of 5,
from one place, limited charge). Worlds have seeds from 100 on and missions from 1000 on; the tables
of docs/selectors.md use neither. Needs Optuna: pip install 'swarmscout[bench]'.
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
"""What is tuned; selectors not named here have no parameters, or those of the paper."""

load = cache(load_world)


@dataclass(frozen=True)
class Budget:
    """The size of a search, the same for every selector.

    Attributes:
        rounds: rounds of the search.
        settings: settings in each round.
        missions: missions of each setting in a round.
        finals: settings compared at the end, in three times as many missions.
    """

    rounds: int
    settings: int
    missions: int
    finals: int


@dataclass(frozen=True)
class Place:
    """A mission that settings run in."""

    world: str
    world_seed: int
    seed: int


def places(count: int, first: int) -> list[Place]:
    """Missions from number `first` on; successive ones take the worlds in turn."""
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


def ratios(
    pool: ProcessPoolExecutor, name: str, settings: list[dict[str, float]], where: list[Place]
) -> NDArray[np.float64]:
    """[settings, places], areas over those of the baseline in the same missions."""
    jobs = [("quantile", {}, place) for place in where]
    jobs += [(name, setting, place) for setting in settings for place in where]
    found = np.array(list(pool.map(area, jobs, chunksize=4)))
    base, areas = found[: len(where)], found[len(where) :]
    return areas.reshape(len(settings), len(where)) / base


def distributions(name: str) -> dict[str, Any]:
    """The ranges of a selector, for Optuna."""
    from optuna.distributions import FloatDistribution

    return {
        key: FloatDistribution(low, high, log=low > 0.0 and high >= 4.0 * low)
        for key, (low, high) in RANGES[name].items()
    }


def rounded(parameters: dict[str, float]) -> dict[str, float]:
    """Parameters to three significant digits."""
    return {key: float(f"{value:.3g}") for key, value in parameters.items()}


def tune(pool: ProcessPoolExecutor, name: str, budget: Budget) -> None:
    """Search, and print what is found."""
    import optuna

    optuna.logging.set_verbosity(optuna.logging.WARNING)
    # Settings of a round are drawn before any of them is known: "constant liar" keeps them apart.
    sampler = optuna.samplers.TPESampler(seed=0, constant_liar=True)
    search = optuna.create_study(sampler=sampler, direction="maximize")
    own = make_selector(name)
    inside = {k: float(np.clip(getattr(own, k), *ends)) for k, ends in RANGES[name].items()}
    search.enqueue_trial(inside)
    best: list[tuple[float, dict[str, float]]] = []
    for number in range(budget.rounds):
        trials = [search.ask(distributions(name)) for _ in range(budget.settings)]
        tried = [rounded(trial.params) for trial in trials]
        where = places(budget.missions, number * budget.missions)
        means = ratios(pool, name, tried, where).mean(axis=1)
        for trial, mean in zip(trials, means.tolist(), strict=True):
            search.tell(trial, mean)
        order = np.argsort(-means)
        # Rounds have different missions, so settings are ranked against their round's mean.
        best += [(float(means[k] - means.mean()), tried[k]) for k in order[:2]]
        print(f"round {number + 1}: {means[order[0]]:.3f} {tried[order[0]]}", flush=True)
    best.sort(key=lambda pair: -pair[0])
    # The selector's present setting stands first, and another has to be better.
    candidates: list[dict[str, float]] = [
        {},
        *[setting for _, setting in best[: budget.finals - 1]],
    ]
    found = ratios(
        pool, name, candidates, places(3 * budget.missions, budget.rounds * budget.missions)
    )
    for values, setting in zip(found, candidates, strict=True):
        error = values.std(ddof=1) / np.sqrt(len(values))
        print(f"final: {values.mean():.3f} ± {error:.3f} {setting or 'as it is'}", flush=True)
    chosen = candidates[int(found.mean(axis=1).argmax())]
    print(f"{name}: {chosen or 'as it is'}", flush=True)


def main() -> None:
    """Tune the named selectors, or all that have ranges."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("selectors", nargs="*", metavar="SELECTOR", help=", ".join(RANGES))
    parser.add_argument("--rounds", type=int, default=6)
    parser.add_argument("--settings", type=int, default=16, help="settings in each round")
    parser.add_argument("--missions", type=int, default=12, help="missions of each setting")
    parser.add_argument("--finals", type=int, default=6, help="settings compared at the end")
    parser.add_argument("--jobs", type=int, default=2)
    given = parser.parse_args()
    names = given.selectors or list(RANGES)
    unknown = [name for name in names if name not in RANGES]
    if unknown:
        known = ", ".join(RANGES)
        parser.error(
            f"nothing to tune in '{unknown[0]}' (of {len(SELECTORS.built_in)} selectors): {known}"
        )
    budget = Budget(given.rounds, given.settings, given.missions, given.finals)
    with ProcessPoolExecutor(given.jobs) as pool:
        for name in names:
            print(f"{name}: {RANGES[name]}", flush=True)
            tune(pool, name, budget)


if __name__ == "__main__":
    main()
