"""The map of one robot for the page, where robots have maps of their own."""

from __future__ import annotations

import gzip
import threading
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

import numpy as np

from swarmscout.core.errors import ViewError
from swarmscout.recording.own_maps import OwnMaps
from swarmscout.viewing.player.packets import differences, pack, smallest

if TYPE_CHECKING:
    from swarmscout.recording.run import Run

__all__ = ["MOST_ROBOTS", "Beliefs", "chosen_robots", "packed_beliefs"]

MOST_ROBOTS = 100
"""Files of larger swarms hold robots' own maps on request only."""


class Beliefs:
    """Robots' maps, computed on request.

    Args:
        begin: makes the maps of some robots, before the first step.
    """

    def __init__(self, begin: Callable[[Sequence[int]], OwnMaps]) -> None:
        self._begin = begin
        self._maps: dict[int, OwnMaps] = {}
        self._lock = threading.Lock()

    def packet(self, robot: int, first: int, last: int) -> bytes:
        """The changes of a robot's map in the steps `first` to `last`, as a packet."""
        with self._lock:
            if robot not in self._maps:
                self._maps[robot] = self._begin([robot])
            maps = self._maps[robot]
            maps.advance(last)
            return _packet(maps, robot, first, last)


def packed_beliefs(run: Run, robots: Sequence[int]) -> dict[int, bytes]:
    """The maps of some robots over all of a run: gzipped packets by robot.

    Raises:
        RunError: the robot does not exist, or its map was not recorded.
    """
    if not robots:
        return {}
    maps = run.robot_maps(robots)
    maps.advance(run.last_step)
    return {
        robot: gzip.compress(_packet(maps, robot, 0, run.last_step), compresslevel=6, mtime=0)
        for robot in robots
    }


def chosen_robots(run: Run, text: str | None) -> list[int]:
    """The robots whose own maps a file holds.

    Args:
        run: the run.
        text: ``all``, ``none``, or robots' numbers as in ``0,3,7``; None: all, or none of a swarm
            of more than :data:`MOST_ROBOTS`.

    Raises:
        RunError: the robot does not exist.
        ViewError: the text is not a selection of robots, or one map served all robots.
    """
    every_robot = list(range(run.scenario.robots))
    if text is None:
        return every_robot if run.own_maps and len(every_robot) <= MOST_ROBOTS else []
    if text == "none":
        return []
    words = text.split(",")
    if text != "all" and not all(
        word.strip().isascii() and word.strip().isdecimal() for word in words
    ):
        raise ViewError(f"own maps of '{text}': write all, none, or robots' numbers as in 0,3,7")
    robots = every_robot if text == "all" else sorted({int(word) for word in words})
    for robot in robots:
        run.check_robot(robot)
    if not run.own_maps:
        raise ViewError("in this mission one map served all robots: robots have no own maps")
    return robots


def _packet(maps: OwnMaps, robot: int, first: int, last: int) -> bytes:
    changes = maps.changes(robot, first)
    steps = last + 1 - first
    return pack(
        {"robot": robot, "first": first, "steps": steps},
        {
            "map.counts": np.bincount(changes.step - first, minlength=steps).astype(np.uint32),
            "map.cells": smallest(differences(changes.cell)),
            "map.log_odds": changes.log_odds.astype(np.int16),
        },
    )
