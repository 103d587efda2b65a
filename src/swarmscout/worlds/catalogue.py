"""Worlds by name, and one function that loads a world of any kind."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from numpy.typing import ArrayLike

from swarmscout.core.errors import WorldError, did_you_mean
from swarmscout.core.paths import expanded
from swarmscout.worlds.arrays import load_array, with_places
from swarmscout.worlds.folder import WORLD_FILE, load_folder
from swarmscout.worlds.images import IMAGE_SUFFIXES, load_image
from swarmscout.worlds.meshes.files import MESH_SUFFIXES
from swarmscout.worlds.movingai import load_movingai
from swarmscout.worlds.nav2 import load_nav2
from swarmscout.worlds.readers import READERS, read_by, reader_for, split_name
from swarmscout.worlds.tube import generate_tube
from swarmscout.worlds.tube_parameters import TubeParameters
from swarmscout.worlds.world import World

__all__ = ["NAMED_TUBES", "known_kinds", "load_world", "named_worlds"]

NAMED_TUBES: dict[str, tuple[str, TubeParameters]] = {
    "lava-tube": (
        "a winding tube with two arms that rejoin, blind branches, pillars and breakdown",
        TubeParameters(),
    ),
    "lava-tube-braided": (
        "a tube with many arms that leave and rejoin it: several ways to everywhere",
        TubeParameters(
            size_m=112.0, width_m=5.6, braids=7, branches=5, winding=0.8, pillars=6, piles=14
        ),
    ),
    "lava-tube-wide": (
        "broad halls, 5 to 12 m, with many pillars: room for large swarms",
        TubeParameters(
            size_m=116.0, length_m=210.0, width_m=9.0, narrowest_m=5.0, width_variation=0.35,
            branches=6, branch_length_m=30.0, pillars=36, piles=24, height_m=5.0,
        ),
    ),
    "lava-tube-small": (
        "a short tube with one arm and a few branches on 60 m × 60 m: quick to explore",
        TubeParameters(
            size_m=52.0, length_m=95.0, width_m=5.2, braids=1, branches=5, branch_length_m=16.0,
            pillars=4, piles=8,
        ),
    ),
    "lava-maze": (
        "a maze of small tubes, 3 to 6 m wide, with many loops and dead ends",
        TubeParameters(
            layout="maze", size_m=84.0, width_m=4.0, narrowest_m=3.0, widest_m=6.5, winding=1.3,
            braids=0, branches=0, pillars=4, piles=14, roughness_m=0.5, height_m=2.6,
        ),
    ),
    "lava-network": (
        "a network of tubes, 25 km of them on 640 m × 640 m: room for 20,000 robots",
        TubeParameters(
            layout="maze", size_m=620.0, width_m=7.5, narrowest_m=4.0, winding=1.0,
            braids=0, branches=0, pillars=40, piles=60, resolution_m=0.2,
        ),
    ),
}  # fmt: skip
"""Name → one line and parameters."""


def named_worlds() -> dict[str, str]:
    """The worlds that come with the package: name → one line."""
    return {name: line for name, (line, _) in NAMED_TUBES.items()}


def load_world(
    what: str | Path | World,
    seed: int | None = None,
    *,
    resolution_m: float | None = None,
    cell_m: float | None = None,
    free: str | None = None,
    occupied: str | None = None,
    start_m: ArrayLike | None = None,
    stations_m: ArrayLike | None = None,
    base: Path | None = None,
) -> World:
    """Load or generate a world.

    Args:
        what: a name (see :func:`named_worlds`), a nav2 ``.yaml``, a MovingAI ``.map``, an image, a
            ``.npy``, a world folder, a world reader (``FILE.py:Name``, ``FILE.py:Name:DATA`` or a
            file with a suffix that another package registered), or a world, which is returned.
        seed: which world of that name; None for 0. Named worlds and world readers have seeds.
        resolution_m: edge of a raster cell, in metres; None: the map's own, cut up until it is at
            most 0.1 m.
        cell_m: edge of a file's cell or pixel, in metres (``.map``: 0.5, images and ``.npy``: 0.1).
        free: values of an image or array that are free, as ``"0"``, ``"0..49"`` or ``"0,205"``;
            None: pixels of at least 60 % brightness, and 1 in arrays.
        occupied: values of an image or array that are not free, in the same form.
        start_m: ``(x, y)`` of the start, in metres, instead of the world's own.
        stations_m: [k, 2] charging stations, in metres, instead of the world's own.
        base: relative paths are tried from here first, and then from the working directory.

    Returns:
        The world.

    Raises:
        WorldError: the name or file is unknown or damaged, or an option does not belong to it.

    Example:
        >>> load_world("lava-tube-small", seed=3).name
        'lava-tube-small'
    """
    if isinstance(what, World):
        _refuse(f"world '{what.name}'", "a world in memory", seed=seed, cell_m=cell_m,
                resolution_m=resolution_m, free=free, occupied=occupied)  # fmt: skip
        world = what
    elif not isinstance(what, str | Path):
        raise WorldError(
            f"a world is given by its name or the path of a map, not by a {type(what).__name__}"
        )
    elif str(what) in NAMED_TUBES:
        _refuse(f"world '{what}'", "a generated world", free=free, occupied=occupied)
        world = _named(str(what), seed, resolution_m, cell_m)
    else:
        options = {
            "cell_m": cell_m, "resolution_m": resolution_m, "free": free, "occupied": occupied,
        }  # fmt: skip
        world = _from_reader(str(what), seed, options, base) or _from_file(
            _find(what, base), seed, options
        )
    return with_places(world, start_m, stations_m)


def _named(name: str, seed: int | None, resolution_m: float | None, cell_m: float | None) -> World:
    _refuse(f"world '{name}'", "a generated world (use resolution_m)", cell_m=cell_m)
    changes: dict[str, Any] = {}
    if seed is not None:
        changes["seed"] = seed
    if resolution_m is not None:
        changes["resolution_m"] = resolution_m
    return generate_tube(dataclasses.replace(NAMED_TUBES[name][1], **changes), name)


def _from_reader(
    what: str, seed: int | None, options: Mapping[str, Any], base: Path | None
) -> World | None:
    """The world that a named reader reads or makes; None where no reader is named."""
    named = split_name(what)
    if named is None or _exists(Path(what)):
        return None
    name, file = named
    _refuse(f"world '{what}'", "a world reader", **options)
    reader = READERS.make(name, base=base)
    path = None if file is None else _find(file, base)
    return read_by(reader, name, path, seed or 0)


def _find(what: str | Path, base: Path | None) -> Path:
    """The file or folder that is meant."""
    given = expanded(what)
    tried = [given] if base is None or given.is_absolute() else [base / given, given]
    for path in tried:
        if _exists(path):
            return path
    if given.suffix or len(given.parts) > 1:
        places = " and ".join(f"'{path.absolute()}'" for path in dict.fromkeys(tried))
        raise WorldError(f"world '{what}' does not exist: looked for {places}")
    raise WorldError(f"unknown world '{what}': {did_you_mean(str(what), NAMED_TUBES)}")


def _exists(path: Path) -> bool:
    try:
        return path.exists()
    except (OSError, ValueError):  # Not a path: too long, or with a NUL in it.
        return False


def _from_file(path: Path, seed: int | None, options: Mapping[str, Any]) -> World:
    where = f"world '{path}'"
    suffix = path.suffix.lower()
    if not path.is_dir() and not path.is_file():
        raise WorldError(f"{where} is neither a file nor a folder")
    cell_m, resolution_m = options["cell_m"], options["resolution_m"]
    values = {"free": options["free"], "occupied": options["occupied"]}
    if path.is_dir() or path.name == WORLD_FILE:
        _refuse(where, "a world folder", seed=seed, **options)
        return load_folder(path if path.is_dir() else path.parent)
    if suffix in MESH_SUFFIXES:
        raise WorldError(
            f"{where} is a mesh: make a world of it first, which takes a while and some decisions: "
            f"swarmscout worlds import {path} --out FOLDER"
        )
    if suffix in (".yaml", ".yml"):
        _refuse(where, "a nav2 map, which says it itself", seed=seed, cell_m=cell_m, **values)
        return load_nav2(path, resolution_m)
    if suffix == ".map":
        _refuse(where, "a map", seed=seed, **values)
        return load_movingai(path, cell_m, resolution_m)
    if suffix == ".npy" or suffix in IMAGE_SUFFIXES:
        _refuse(where, "a map", seed=seed)
        load = load_array if suffix == ".npy" else load_image
        return load(path, cell_m, resolution_m, **values)
    reader = reader_for(suffix)
    if reader is None:
        raise WorldError(f"{where}: unknown kind of file '{suffix}': {known_kinds()}")
    _refuse(where, "a file of another package's reader", **options)
    return read_by(reader, type(reader).__name__, path, seed or 0)


def known_kinds() -> str:
    """The kinds of files that make worlds, for error messages."""
    maps = ", ".join([".yaml", ".yml", ".map", ".npy", *sorted(IMAGE_SUFFIXES)])
    return f"known are {maps}; and, with worlds import, the meshes {', '.join(MESH_SUFFIXES)}"


def _refuse(where: str, kind: str, **options: Any) -> None:
    """Refuse options that would have no effect."""
    for name, value in options.items():
        if value is not None:
            raise WorldError(f"{where}: {name} = {value} has no meaning for {kind}: leave it out")
