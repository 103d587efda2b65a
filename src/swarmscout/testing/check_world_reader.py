"""A conformance check for world readers: run it in the tests of your own.

It reads worlds with a reader and reports in one error which part of the contract of
:class:`swarmscout.worlds.readers.WorldReader` is broken, and how.
"""

from __future__ import annotations

import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from swarmscout.core.errors import WorldError
from swarmscout.testing.fingerprints import drawn_from, global_states, seeded_globals
from swarmscout.testing.harness import Report, instance_of
from swarmscout.worlds.checks import check_world
from swarmscout.worlds.folder import load_folder, save_world
from swarmscout.worlds.readers import READERS, WorldReader, read_by
from swarmscout.worlds.world import World

__all__ = ["check_world_reader"]

CHECKS = (
    "has read(path, seed), and suffixes in lower case that begin with a dot",
    "returns a World in which a mission can start",
    "gives the same world, bit for bit, for the same file and seed",
    "neither draws from nor depends on the global generators of random and numpy.random",
    "its world can be written into a folder and read back",
    "reports a damaged file by an error",
)
_DAMAGED = b"\x00\xff no world \xfe" * 3


def check_world_reader(
    reader: Any, files: Sequence[Path | str] = (), *, robots: int = 3, seed: int = 0
) -> Report:
    """Check that a world reader keeps to its contract.

    Args:
        reader: an instance, a class that needs no arguments, a registered name, or
            ``path/to/file.py:ClassName``.
        files: files to read; none for a reader that makes its worlds.
        robots: the number of robots for which a world must have room.
        seed: the first of three seeds that are tried.

    Returns:
        What was checked; print it if you like.

    Raises:
        WorldError: which part of the contract was broken, with which file.

    Example:
        >>> class Square:
        ...     suffixes = ()
        ...     def read(self, path, seed):
        ...         return world_from_array(np.ones((80, 80), dtype=bool), 0.1)
        >>> check_world_reader(Square).name
        'Square'
    """
    kind, name = instance_of(READERS, reader)
    _check_suffixes(kind, name)
    if kind.suffixes and not files:
        raise WorldError(f"world reader '{name}' reads {kind.suffixes}: give some (files=...)")
    tried = []
    paths: list[Path | None] = [Path(file) for file in files]
    for path in paths or [None]:
        for each in range(seed, seed + 3):
            where = f"'{path}', seed {each}" if path is not None else f"seed {each}"
            _check_world(kind, name, path, each, where, robots)
            tried.append(where)
    for suffix in kind.suffixes:
        _check_damaged(kind, name, suffix)
        tried.append(f"a damaged file '*{suffix}'")
    return Report("world reader", name, CHECKS, tuple(tried), 3 * len(tried))


def _check_suffixes(reader: WorldReader, name: str) -> None:
    suffixes = getattr(reader, "suffixes", None)
    if not isinstance(suffixes, tuple) or not all(
        isinstance(suffix, str) and suffix.startswith(".") and suffix == suffix.lower()
        for suffix in suffixes
    ):
        raise WorldError(
            f"world reader '{name}': suffixes = {suffixes!r}, expected a tuple such as ('.cavex',)"
        )


def _check_world(
    reader: WorldReader, name: str, path: Path | None, seed: int, where: str, robots: int
) -> None:
    states = global_states()
    world = read_by(reader, name, path, seed)
    if drawn_from(states):
        raise WorldError(f"world reader '{name}' draws from a global random generator ({where})")
    try:
        check_world(world, robots)
    except WorldError as error:
        raise WorldError(f"world reader '{name}', {where}: {error}") from None
    with seeded_globals(seed + 1):
        again = read_by(reader, name, path, seed)
    if _content(again) != _content(world):
        raise WorldError(f"world reader '{name}' gives another world the second time ({where})")
    with tempfile.TemporaryDirectory() as folder:
        kept = load_folder(save_world(world, Path(folder) / "world"))
    if _content(kept) != _content(world):
        raise WorldError(f"world reader '{name}': its world changes when it is kept ({where})")


def _check_damaged(reader: WorldReader, name: str, suffix: str) -> None:
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / f"damaged{suffix}"
        file.write_bytes(_DAMAGED)
        try:
            reader.read(file, 0)
        except Exception:
            return
    raise WorldError(f"world reader '{name}' makes a world of a damaged file: raise WorldError")


def _content(world: World) -> tuple[Any, ...]:
    """What must be equal in equal worlds."""
    heights = (world.ground_m, world.ceiling_m, world.stations_m)
    arrays = [None if array is None else np.asarray(array).tobytes() for array in heights]
    mesh = None if world.mesh is None else world.mesh.vertices_m.tobytes()
    return world.digest, world.start_m, *arrays, mesh
