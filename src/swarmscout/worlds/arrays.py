"""Worlds from arrays and from small drawings in text."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from swarmscout.core.errors import WorldError
from swarmscout.worlds.meshes.mesh import Mesh
from swarmscout.worlds.resampling import check_length, check_size, refined
from swarmscout.worlds.values import free_by_value
from swarmscout.worlds.world import World, raster_digest, shown

__all__ = ["first_line", "load_array", "with_places", "world_from_array", "world_from_ascii"]

_WALL, _FREE, _START, _STATION = "#", ". ", "S", "C"


def world_from_array(
    free: ArrayLike,
    resolution_m: float = 0.1,
    *,
    name: str = "array",
    origin_m: tuple[float, float] = (0.0, 0.0),
    start_m: tuple[float, float] | None = None,
    stations_m: ArrayLike | None = None,
    ground_m: NDArray[np.float32] | None = None,
    ceiling_m: NDArray[np.float32] | None = None,
    mesh: Mesh | None = None,
    source: Mapping[str, Any] | None = None,
) -> World:
    """A world from a raster in memory.

    Args:
        free: [rows, cols] booleans or whole numbers, 1 where a robot may be, 0 for wall; row 0 is
            the lowest.
        resolution_m: edge of a cell, in metres.
        name: its name.
        origin_m: ``(x, y)`` of the lower left corner, in metres.
        start_m: ``(x, y)`` of the start, in metres; None: a roomy place is found when needed.
        stations_m: [k, 2] charging stations, in metres; None: derived for a number of robots.
        ground_m: float32[rows, cols] heights, or None for a flat floor.
        ceiling_m: float32[rows, cols] heights, or None for open sky.
        mesh: the cave's surface in the same frame, or None.
        source: where it came from.

    Returns:
        The world, with read-only rasters.

    Raises:
        WorldError: the array is not a raster of 0 and 1, nothing is free, or a number is
            impossible.

    Example:
        >>> world_from_array([[1, 1], [0, 1]], resolution_m=0.5).extent
        (0.0, 1.0, 0.0, 1.0)
    """
    check_length("resolution_m", resolution_m)
    raster = _raster(free, name)
    stations = None
    if stations_m is not None and len(np.asarray(stations_m)):
        stations = _points("stations_m", stations_m)
    start = None if start_m is None else _point("start_m", start_m)
    place = _point("origin_m", origin_m)
    # With the digest a later reader sees whether the source still describes the raster.
    facts = {"file": "an array in memory"} if source is None else dict(source)
    facts["digest"] = raster_digest(raster, float(resolution_m), place)
    return World(
        name=name,
        free=raster,
        resolution_m=float(resolution_m),
        origin_m=place,
        start_m=start,
        stations_m=stations,
        ground_m=ground_m,
        ceiling_m=ceiling_m,
        mesh=mesh,
        source=facts,
    )


def world_from_ascii(
    text: str, resolution_m: float = 0.5, *, name: str = "ascii", pieces: int = 1
) -> World:
    """A world from a drawing: ``#`` wall, ``.`` or space free, ``S`` start, ``C`` station.

    Args:
        text: the first line is the top; blank lines before and after do not count, and short lines
            are filled up with wall.
        resolution_m: edge of a character, in metres.
        name: its name.
        pieces: raster cells along the edge of a character.

    Returns:
        The world; its lower left corner is (0, 0).

    Raises:
        WorldError: an unknown character, two starts, or nothing free.

    Example:
        >>> world_from_ascii('''
        ... ######
        ... #S..C#
        ... ######
        ... ''').start_m
        (0.75, 0.75)
    """
    check_length("resolution_m", resolution_m)
    lines = text.split("\n")
    while lines and not lines[0].strip():
        lines.pop(0)
    while lines and not lines[-1].strip():
        lines.pop()
    width = max((len(line) for line in lines), default=0)
    check_size((len(lines) * pieces, width * pieces), "the drawing")
    free = np.zeros((len(lines), width), dtype=np.uint8)
    marks: dict[str, list[tuple[float, float]]] = {_START: [], _STATION: []}
    for row, line in enumerate(reversed(lines)):
        for col, character in enumerate(line):
            if character == _WALL:
                continue
            if character not in _FREE + _START + _STATION:
                raise WorldError(
                    f"world '{name}', line {len(lines) - row}, column {col + 1}: unknown character "
                    f"{character!r}: known are '#' wall, '.' and ' ' free, 'S' start, 'C' station"
                )
            free[row, col] = 1
            if character in marks:
                marks[character].append(((col + 0.5) * resolution_m, (row + 0.5) * resolution_m))
    if len(marks[_START]) > 1:
        raise WorldError(f"world '{name}' has {len(marks[_START])} starts 'S': expected one")
    return world_from_array(
        free.repeat(pieces, axis=0).repeat(pieces, axis=1),
        resolution_m / pieces,
        name=name,
        start_m=next(iter(marks[_START]), None),
        stations_m=marks[_STATION] or None,
        source={"file": "a drawing in text"},
    )


def with_places(
    world: World, start_m: ArrayLike | None = None, stations_m: ArrayLike | None = None
) -> World:
    """The same world with another start or other charging stations.

    Args:
        world: a world.
        start_m: ``(x, y)`` in metres, or None to keep what the world has.
        stations_m: [k, 2] in metres, or None to keep what the world has.

    Raises:
        WorldError: these are not points.
    """
    changes: dict[str, Any] = {}
    if start_m is not None:
        changes["start_m"] = _point("start_m", start_m)
    if stations_m is not None:
        changes["stations_m"] = _points("stations_m", stations_m)
    return dataclasses.replace(world, **changes) if changes else world


def load_array(
    path: Path,
    cell_m: float | None,
    resolution_m: float | None,
    free: str | None = None,
    occupied: str | None = None,
) -> World:
    """A world from a ``.npy`` file: a raster of 0 and 1, row 0 the lowest.

    Args:
        path: the file.
        cell_m: edge of a cell, in metres; None for 0.1.
        resolution_m: as for :func:`swarmscout.worlds.resampling.refined`.
        free: values that are free instead of 1, as for
            :func:`swarmscout.worlds.values.free_by_value`.
        occupied: values that are not free.

    Raises:
        WorldError: the file is missing or damaged, or holds other values than 0 and 1.
    """
    cell = 0.1 if cell_m is None else cell_m
    check_length("cell_m", cell)
    try:
        # Mapped first: a header that promises more than the file holds must not allocate memory.
        mapped = np.load(path, mmap_mode="r", allow_pickle=False)
        check_size(mapped.shape, f"'{path}'")
        array = np.array(mapped)
    except (OSError, ValueError, EOFError, SyntaxError, OverflowError) as error:
        raise WorldError(f"cannot read the array '{path}': {first_line(error)}") from None
    facts: dict[str, Any] = {"file": path.name, "cell_m": cell}
    if free is not None or occupied is not None:
        if array.dtype.kind not in "buif" or array.ndim != 2:
            raise WorldError(
                f"'{path}' holds {array.dtype}{list(array.shape)}, expected numbers in rows and "
                "columns"
            )
        array = free_by_value(array, free, occupied)
        facts |= {"free": free, "occupied": occupied}
    else:
        facts["meaning"] = "1 is free"
    raster, edge = refined(_raster(array, path.stem), cell, resolution_m)
    return world_from_array(raster, edge, name=path.stem, source=facts)


def first_line(error: Exception) -> str:
    """The first line of an error's text, or the error's kind if it has none."""
    words = str(error).splitlines()
    return words[0] if words else type(error).__name__


def _raster(free: ArrayLike, name: str) -> NDArray[np.uint8]:
    """A read-only raster of 0 and 1 out of what was given."""
    array = np.asarray(free)
    if array.dtype.kind not in "bui":
        raise WorldError(
            f"world '{name}': free has dtype {array.dtype}, expected booleans or whole numbers, 1 "
            "where free; apply a threshold first, or say which values of a file are free (--free)"
        )
    if array.ndim != 2 or not array.size:
        raise WorldError(f"world '{name}': free has shape {array.shape}, expected (rows, columns)")
    check_size(array.shape, f"world '{name}'")
    if array.dtype.kind != "b" and (int(array.max()) > 1 or int(array.min()) < 0):
        raise WorldError(
            f"world '{name}': free holds numbers from {array.min()} to {array.max()}, expected 1 "
            "where free and 0 elsewhere: if high values are wall, give `array < 50`, or --free "
            "0..49 for a file"
        )
    raster = np.array(array, dtype=np.uint8, order="C")
    if not raster.any():
        raise WorldError(
            f"world '{name}': nothing is free in {array.shape[0]} × {array.shape[1]} cells"
        )
    raster.setflags(write=False)
    return raster


def _point(name: str, given: ArrayLike) -> tuple[float, float]:
    point = _floats(given)
    if point.shape != (2,) or not np.isfinite(point).all():
        raise WorldError(f"{name} = {shown(given)}: expected finite x, y in metres")
    return float(point[0]), float(point[1])


def _points(name: str, given: ArrayLike) -> NDArray[np.float64]:
    points = _floats(given)
    if points.ndim != 2 or points.shape[1] != 2 or not np.isfinite(points).all():
        raise WorldError(f"{name} = {shown(given)}: expected pairs of finite x, y in metres")
    points.setflags(write=False)
    return points


def _floats(given: ArrayLike) -> NDArray[np.float64]:
    try:
        return np.array(given, dtype=np.float64)
    except (TypeError, ValueError, OverflowError):
        return np.empty(0)
