"""What a mission takes of the machine's memory, estimated before anything is made."""

from __future__ import annotations

import math

from swarmscout.core.errors import ScenarioError
from swarmscout.core.grid import GridFrame
from swarmscout.core.memory import machine_memory
from swarmscout.mission.scenario import Scenario
from swarmscout.worlds.world import World

__all__ = ["check_memory", "map_rows", "memory_needed"]

_PROGRAM = 250e6
"""Python, NumPy and compiled kernels, in bytes."""
_RASTER_CELL = 13
"""Per cell of the world: free or not, ground and ceiling, and where bodies can stand and drive."""
_MAP_CELL = 20
"""Per cell of each map: evidence, price, status, weights of occupied cells; a part of it twice
while rows are added."""
_SEARCH_CELL = 100
"""Per map cell, once: routes to cells and to stations, updates of maps, the judge's truth."""
_ROBOT = 100e3
"""Per robot: its mind, route and log, and what its first decision looks at."""
_HEARD = 160
"""Per row and robot: the last beacon, for how long it has stood, how much of its log is known."""


def map_rows(scenario: Scenario, world: World) -> int:
    """How many maps robots may have at most: one each if they do not all hear each other.

    Of a radio from a file or another package this is not known, and one is counted.
    """
    left, right, bottom, top = world.extent
    limited = scenario.radio.model == "disc" and scenario.radio.range_m < math.hypot(
        right - left, top - bottom
    )
    return scenario.robots if limited else 1


def memory_needed(scenario: Scenario, world: World, frame: GridFrame, rows: int) -> int:
    """Bytes of memory that a mission takes at most, about; logs of long missions not counted.

    Args:
        scenario: what is run. world: where. frame: the maps' grid.
        rows: how many maps there are, see :func:`map_rows`.
    """
    maps = rows if rows == 1 else rows + 1  # What the swarm knows together is one more.
    cells = frame.size * (maps * _MAP_CELL + _SEARCH_CELL)
    robots = scenario.robots * (_ROBOT + rows * _HEARD)
    return round(_PROGRAM + world.free.size * _RASTER_CELL + cells + robots)


def check_memory(scenario: Scenario, world: World, frame: GridFrame, rows: int) -> None:
    """Refuse a mission that does not fit into the machine's memory.

    Args:
        scenario, world, frame, rows: see :func:`memory_needed`.

    Raises:
        ScenarioError: it does not fit.
    """
    needed, there = memory_needed(scenario, world, frame, rows), machine_memory()
    if there is None or needed <= there:
        return
    several = f", in up to {rows:,} maps (key 'radio.range_m')" if rows > 1 else ""
    raise ScenarioError(
        f"the mission needs about {needed / 1e9:.1f} GB of memory, and this machine has "
        f"{there / 1e9:.1f} GB: {scenario.robots:,} robots (key 'robots') with {frame.size:,} map "
        f"cells in world '{world.name}' (key 'map.cell_m'){several}; take fewer robots, larger "
        "cells or a smaller world" + (", or radio.model = 'full'" if rows > 1 else "")
    )
