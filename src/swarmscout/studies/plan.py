"""A study's missions: every combination of the axes' values with every seed, each with a name.

A mission's name is made of its resolved scenario, of the files that it names, and of the rules'
version. So what was run before is found again, whatever else changes in the study's file, and what
was run by other rules is not mistaken for it.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable
from dataclasses import dataclass
from itertools import product
from pathlib import Path
from typing import Any

from swarmscout.core.errors import StudyError, SwarmscoutError
from swarmscout.destinations.registry import make_selector
from swarmscout.mission.mission import RULES_VERSION
from swarmscout.mission.scenario import Scenario
from swarmscout.mission.scenario_files import load_scenario, make_scenario
from swarmscout.recording.run_folder import default_name
from swarmscout.robots.sensors.parameters import sensor_parameters
from swarmscout.robots.sensors.registry import SENSORS
from swarmscout.studies.study_file import (
    PATH_KEYS,
    Axis,
    StudyFile,
    absolute,
    base_of,
    changes_of,
)
from swarmscout.teams.registry import make_policy
from swarmscout.worlds.catalogue import NAMED_TUBES, load_world

__all__ = ["Planned", "base_scenario", "expand", "scenario_of"]


@dataclass(frozen=True, slots=True)
class Planned:
    """One mission of a study, before or after it was run.

    Attributes:
        name: of its folder.
        values: which value it has of each axis (an index).
        world: the world's name or file.
        world_seed: None for the world's own.
        seed: the mission's.
        steps: its length.
        robots: N.
    """

    name: str
    values: tuple[int, ...]
    world: str
    world_seed: int | None
    seed: int
    steps: int
    robots: int


def base_scenario(declared: StudyFile, folder: Path) -> Scenario:
    """The scenario that a study starts from.

    Raises:
        ScenarioError: it cannot be read, or a change is impossible.
    """
    return load_scenario(base_of(declared, folder), changes_of(declared, folder))


def expand(declared: StudyFile, axes: list[Axis], base: Scenario, folder: Path) -> list[Planned]:
    """Every mission of a study, world by world, so that worlds are loaded seldom.

    Args:
        declared: the study.
        axes: its axes.
        base: the scenario that it starts from.
        folder: for relative paths.

    Raises:
        StudyError: a combination is impossible, or names something that does not exist.
    """
    known_good: dict[Any, str] = {}
    planned = []
    for values in product(*(range(len(axis.values)) for axis in axes)):
        first = scenario_of(axes, base, folder, values, declared.first_seed)
        try:
            files = [
                _check_world(first, known_good),
                _check_rule("destinations", first.destinations, first.selector, known_good),
                _check_rule("policy", first.teams.policy, first.policy, known_good),
                _check_rule(
                    "sensor", first.sensor.model, sensor_parameters(first.sensor), known_good
                ),
            ]
        except SwarmscoutError as error:
            raise StudyError(f"{_where(axes, values)}: {error}") from None
        for trial in range(declared.trials):
            scenario = first.model_copy(update={"seed": declared.first_seed + trial})
            planned.append(
                Planned(
                    name=_name(scenario, files, declared.record),
                    values=values,
                    world=scenario.world,
                    world_seed=scenario.world_seed,
                    seed=scenario.seed,
                    steps=scenario.steps,
                    robots=scenario.robots,
                )
            )
    order = {place: at for at, place in enumerate(dict.fromkeys(map(_place, planned)))}
    planned.sort(key=lambda mission: (order[_place(mission)], mission.seed))
    return planned


def scenario_of(
    axes: list[Axis], base: Scenario, folder: Path, values: tuple[int, ...], seed: int
) -> Scenario:
    """The resolved scenario of one mission.

    Raises:
        StudyError: the combination of values is impossible.
    """
    keys: dict[str, Any] = {}
    for axis, index in zip(axes, values, strict=True):
        for key, value in axis.values[index].keys.items():
            keys[key] = absolute(value, folder) if key in PATH_KEYS else value
    try:
        return make_scenario(base.model_dump(), {**keys, "seed": seed})
    except SwarmscoutError as error:
        raise StudyError(f"{_where(axes, values)}: {error}") from None


def _place(mission: Planned) -> tuple[str, int | None]:
    return mission.world, mission.world_seed


def _where(axes: list[Axis], values: tuple[int, ...]) -> str:
    told = (f"{a.name} = {a.values[i].label}" for a, i in zip(axes, values, strict=True))
    return f"the combination {', '.join(told)}"


def _check_world(scenario: Scenario, known: dict[Any, str]) -> str:
    """What a world's file holds, as a digest; empty for a named world, whose name says it all."""
    key = ("world", scenario.world, scenario.world_seed)
    if key not in known:
        known[key] = ""
        if scenario.world not in NAMED_TUBES:
            world = load_world(scenario.world, seed=scenario.world_seed)
            stations = None if world.stations_m is None else world.stations_m.tolist()
            known[key] = f"{world.digest} {world.start_m} {stations}"
    return known[key]


_MAKERS: dict[str, Callable[..., object]] = {
    "destinations": make_selector,
    "policy": make_policy,
    "sensor": SENSORS.make,
}


def _check_rule(kind: str, name: str, parameters: dict[str, Any], known: dict[Any, str]) -> str:
    """Digest of a selector's, policy's or sensor's file; empty for one that has a name."""
    key = (kind, name, json.dumps(parameters, sort_keys=True, default=str))
    if key not in known:
        _MAKERS[kind](name, parameters)
        path, colon, _ = name.rpartition(":")
        is_file = colon and path.endswith(".py")
        known[key] = hashlib.sha256(Path(path).read_bytes()).hexdigest() if is_file else ""
    return known[key]


def _name(scenario: Scenario, files: list[str], record: str) -> str:
    """``<world>-<selector>-n<robots>-s<seed>-<digest>``: to be read, and not to be mistaken."""
    data = scenario.model_dump(mode="json")
    world, selector, policy, sensor = files
    # A file is known by what it holds, and not by where it lies.
    if world:
        data["world"] = world
    if selector:
        data["destinations"] = f"{scenario.destinations.rpartition(':')[2]} {selector}"
    if policy:
        data["teams"]["policy"] = f"{scenario.teams.policy.rpartition(':')[2]} {policy}"
    if sensor:
        data["sensor"]["model"] = f"{scenario.sensor.model.rpartition(':')[2]} {sensor}"
    told = json.dumps([data, RULES_VERSION, record], sort_keys=True)
    return f"{default_name(scenario)}-{hashlib.sha256(told.encode()).hexdigest()[:12]}"
