"""Worlds: places to explore, their sources, and the start of a mission in them.

They are ground truth: only bodies, judging, recording, viewing and the ``worlds`` commands import
this room; robots' minds never do.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from swarmscout.worlds.arrays import world_from_array, world_from_ascii
from swarmscout.worlds.catalogue import load_world, named_worlds
from swarmscout.worlds.checks import check_world
from swarmscout.worlds.folder import load_folder, save_world
from swarmscout.worlds.meshes.mesh import Mesh
from swarmscout.worlds.placement import place_robots, place_stations
from swarmscout.worlds.reachability import reachable
from swarmscout.worlds.tube import generate_tube
from swarmscout.worlds.tube_parameters import TubeParameters
from swarmscout.worlds.world import World

if TYPE_CHECKING:
    from swarmscout.worlds.meshes.importing import import_mesh
    from swarmscout.worlds.meshes.tube_mesh import tube_mesh
    from swarmscout.worlds.meshes.writing import write_mesh

__all__ = [
    "Mesh",
    "TubeParameters",
    "World",
    "check_world",
    "generate_tube",
    "import_mesh",
    "load_folder",
    "load_world",
    "named_worlds",
    "place_robots",
    "place_stations",
    "reachable",
    "save_world",
    "tube_mesh",
    "world_from_array",
    "world_from_ascii",
    "write_mesh",
]


_OF_MESHES = {"import_mesh": "importing", "tube_mesh": "tube_mesh", "write_mesh": "writing"}


def __getattr__(name: str) -> Any:
    """Load what meshes need when it is first used: most missions need none of it."""
    if name not in _OF_MESHES:
        raise AttributeError(f"module 'swarmscout.worlds' has no attribute '{name}'")
    from importlib import import_module

    return getattr(import_module(f"swarmscout.worlds.meshes.{_OF_MESHES[name]}"), name)
