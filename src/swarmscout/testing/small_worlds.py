"""Small caves, and short missions in them: one takes milliseconds."""

from __future__ import annotations

import math
from functools import cache

import numpy as np
from numpy.typing import NDArray

from swarmscout.core.streams import stream
from swarmscout.destinations.selector import Selector
from swarmscout.mission.mission import Mission
from swarmscout.mission.scenario import Scenario
from swarmscout.robots.bodies import TICKS, Bodies, place_bodies
from swarmscout.robots.radio.radio import Radio
from swarmscout.robots.sensors.sensor import Sensor
from swarmscout.tasks.task import Task
from swarmscout.teams.policy import DesiredSizePolicy
from swarmscout.worlds.world import World

__all__ = ["DESIRED_SIZE", "SILENCE_STEPS", "places_with_robots", "short_mission", "small_world"]

DESIRED_SIZE = 5
"""``teams.desired_size`` of short missions."""

SILENCE_STEPS = 5
"""``teams.silence_steps`` of them."""


def small_world(seed: int = 0, *, edge_m: float = 14.0, resolution_m: float = 0.1) -> World:
    """A cave of chambers and passages, different for each seed.

    Args:
        seed: names the cave.
        edge_m: it lies in a square of this edge, at least 8.
        resolution_m: edge of a raster cell.

    Returns:
        A world that starts in a chamber in its middle, with room for about 15 robots.

    Example:
        >>> small_world(3).start_m
        (7.0, 7.0)
    """
    rng = stream(seed, "small world")
    cells = round(edge_m / resolution_m)
    y, x = (np.mgrid[0:cells, 0:cells] + 0.5) * resolution_m
    free = np.hypot(x - 0.5 * edge_m, y - 0.5 * edge_m) < 2.4
    for _ in range(3):
        at = np.array([0.5 * edge_m, 0.5 * edge_m])
        angle = rng.uniform(0.0, 2.0 * math.pi)
        for _ in range(int(2.0 * edge_m)):
            angle += rng.normal(0.0, 0.3)
            ahead = at + 0.5 * np.array([math.cos(angle), math.sin(angle)])
            if ahead.min() < 1.5 or ahead.max() > edge_m - 1.5:
                angle += 0.5 * math.pi
                continue
            at = ahead
            free |= np.hypot(x - at[0], y - at[1]) < rng.uniform(0.5, 0.9)
    free[[0, -1], :] = free[:, [0, -1]] = False
    raster = np.ascontiguousarray(free, dtype=np.uint8)
    raster.flags.writeable = False
    start_m = (0.5 * edge_m, 0.5 * edge_m)
    return World(f"small-{seed}", raster, resolution_m, (0.0, 0.0), start_m)


_cave = cache(small_world)


def short_mission(
    seed: int = 0,
    *,
    robots: int = 8,
    own_maps: bool = False,
    selector: Selector | None = None,
    policy: DesiredSizePolicy | None = None,
    sensor: Sensor | None = None,
    radio: Radio | None = None,
    task: Task | None = None,
) -> Mission:
    """A mission of 80 steps in a small cave, with little charge, so that teams lose members.

    Args:
        seed: of the cave and the mission.
        robots: N.
        own_maps: whether links come and go, and each robot has a map of its own.
        selector: chooses destinations; by default ``nearest``.
        policy: sets desired team sizes; by default the paper's.
        sensor, radio, task: by default the paper's.
    """
    scenario = Scenario.model_validate(
        {
            "robots": robots,
            "steps": 80,
            "seed": seed,
            "destinations": "nearest",
            "battery": {"capacity_steps": 120, "start_min": 0.3},
            "teams": {"leave_rule": "general", "desired_size": DESIRED_SIZE},
        }
    )

    def links(step: int) -> NDArray[np.bool_]:
        i, j = np.indices((robots, robots))
        heard: NDArray[np.bool_] = (i + j + step) % 3 != 0
        return heard

    return Mission(
        scenario,
        world=_cave(seed),
        links=links if own_maps else None,
        selector=selector,
        policy=policy,
        sensor=sensor,
        radio=radio,
        task=task,
    )


def places_with_robots(seed: int) -> list[tuple[str, Bodies, World]]:
    """Places to sense in, in words, each with its robots."""
    cave = small_world(seed)
    room = World("room", np.ones((80, 80), dtype=np.uint8), 0.1, (-4.0, 3.0))
    cell = np.zeros((3, 3), dtype=np.uint8)
    cell[1, 1] = 1
    field = World("field", np.ones((3000, 3000), dtype=np.uint8), 0.1)
    return [
        ("robots all over a cave", _robots(cave, 9, seed), cave),
        ("one robot", _robots(cave, 1, seed), cave),
        ("robots in an empty room", _robots(room, 6, seed), room),
        ("a robot with walls all around", _robots(World("cell", cell, 0.5), 2, seed),
         World("cell", cell, 0.5)),
        ("nothing within reach", _robots(field, 3, seed, 150.0), field),
    ]  # fmt: skip


def _robots(world: World, robots: int, seed: int, place_m: float | None = None) -> Bodies:
    rng = stream(seed, "check sensor", robots)
    cells = np.argwhere(world.free)
    position = world.frame.centres_of(cells[rng.integers(len(cells), size=robots)])
    if place_m is not None:
        position = place_m + rng.uniform(-1.0, 1.0, (robots, 2))
    return place_bodies(position, rng.integers(0, TICKS, robots), np.full(robots, 9.0), seed=seed)
