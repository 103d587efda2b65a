"""World readers of other packages and of a user's own file.

A world reader turns a file of its kind into a world, or makes a world without a file. Other
packages register theirs under the entry point group ``swarmscout.world_readers``; a class in a file
is named ``path/to/file.py:ClassName``.
"""

from __future__ import annotations

from pathlib import Path
from typing import Protocol, runtime_checkable

from swarmscout.core.errors import WorldError
from swarmscout.core.registry import Registry
from swarmscout.core.tracebacks import describe_error
from swarmscout.worlds.world import World

__all__ = ["READERS", "WorldReader", "read_by", "reader_for", "split_name"]


@runtime_checkable
class WorldReader(Protocol):
    """Reads worlds of one kind of file, or makes them.

    Attributes:
        suffixes: of the files that it reads, in lower case, as ``(".cavex",)``; empty for a reader
            that needs no file.

    Example:
        >>> class Square:
        ...     suffixes = ()
        ...     def read(self, path, seed):
        ...         return world_from_array(np.ones((80, 80), dtype=bool), 0.1)
    """

    suffixes: tuple[str, ...]

    def read(self, path: Path | None, seed: int) -> World:
        """Read or make a world.

        Args:
            path: the file, or None where the reader is named without one.
            seed: which of several worlds; 0 if none was given.

        Returns:
            The world; the same arguments give the same world, bit for bit.

        Raises:
            WorldError: the file cannot be read.
        """
        ...


READERS: Registry[WorldReader] = Registry(
    noun="world reader",
    method="read(path, seed)",
    face=WorldReader,  # type: ignore[type-abstract]
    error=WorldError,
    group="swarmscout.world_readers",
    built_in={},
)


def split_name(what: str) -> tuple[str, str | None] | None:
    """A reader's name and the file that follows it, or None where no reader is named.

    Args:
        what: ``file.py:Name``, ``file.py:Name:data.ext``, a registered name, or one with
            ``:data.ext`` after it.
    """
    head, mark, rest = what.rpartition(".py:")
    if mark:
        name, _, file = rest.partition(":")
        return f"{head}.py:{name}", file or None
    name, _, file = what.partition(":")
    return (name, file or None) if name in READERS.names() else None


def reader_for(suffix: str) -> WorldReader | None:
    """The registered reader of files with a suffix, or None.

    Args:
        suffix: as ``".cavex"``, in lower case.

    Raises:
        WorldError: none reads them, and one cannot be loaded that might.
    """
    failed: WorldError | None = None
    for name in READERS.names():
        try:
            reader = READERS.make(name)
        except WorldError as error:
            failed = error
            continue
        if suffix in reader.suffixes:
            return reader
    if failed is not None:
        raise failed
    return None


def read_by(reader: WorldReader, name: str, path: Path | None, seed: int) -> World:
    """Read a world with a reader, whose errors become one line.

    Args:
        reader: a world reader.
        name: what it is called in errors.
        path: the file, or None.
        seed: which of several worlds.

    Raises:
        WorldError: the reader failed, or did not return a world.
    """
    where = f"world reader '{name}'" + (f" with '{path}'" if path is not None else "")
    try:
        world = reader.read(path, seed)
    except WorldError:
        raise
    except (Exception, SystemExit) as error:
        raise WorldError(f"{where} failed: {describe_error(error)}") from error
    if not isinstance(world, World):
        raise WorldError(f"{where} returned a {type(world).__name__}, expected a World")
    return world
