"""A world as a folder: ``world.toml`` and its rasters.

``free.npy`` holds the free raster packed to bits, ``ground.npy`` and ``ceiling.npy`` the heights,
``vertices.npy`` and ``triangles.npy`` the mesh. Where most heights are one number, as far from a
cave, only the others are kept, and ``inside.npy`` says which those are. The same world gives the
same bytes. A digest of the free raster and where it lies is checked when a folder is read, and so
are those of the files.
"""

from __future__ import annotations

import hashlib
import io
import tomllib
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import tomli_w
from numpy.typing import NDArray

from swarmscout.core.errors import WorldError
from swarmscout.worlds.arrays import world_from_array
from swarmscout.worlds.meshes.mesh import Mesh
from swarmscout.worlds.resampling import check_size
from swarmscout.worlds.world import World, shown

__all__ = ["WORLD_FILE", "load_folder", "save_world"]

WORLD_FILE = "world.toml"
_FORMAT = 1
_HEIGHTS = ("ground", "ceiling")
_MESH = ("vertices", "triangles")
_INSIDE = "inside"


def save_world(world: World, folder: Path | str) -> Path:
    """Write a world into a folder, which is made where it is missing.

    Args:
        world: a world.
        folder: where to; a world in it is replaced.

    Returns:
        The folder.

    Raises:
        OSError: it cannot be written.
    """
    target = Path(folder)
    target.mkdir(parents=True, exist_ok=True)
    rasters = {"free": _bytes(np.packbits(world.free != 0, axis=1))}
    given = zip(_HEIGHTS, (world.ground_m, world.ceiling_m), strict=True)
    heights = {name: raster for name, raster in given if raster is not None}
    fill, inside = _mostly_the_same(list(heights.values()))
    for name, raster in heights.items():
        kept = raster if inside is None else raster[inside]
        rasters[name] = _bytes(np.ascontiguousarray(kept, dtype=np.float32))
    if inside is not None:
        rasters[_INSIDE] = _bytes(np.packbits(inside, axis=1))
    if world.mesh is not None:
        arrays = (world.mesh.vertices_m, world.mesh.triangles)
        rasters |= {name: _bytes(array) for name, array in zip(_MESH, arrays, strict=True)}
    facts: dict[str, Any] = {
        "format": _FORMAT,
        "name": world.name,
        "rows": int(world.free.shape[0]),
        "columns": int(world.free.shape[1]),
        "resolution_m": float(world.resolution_m),
        "origin_m": [float(part) for part in world.origin_m],
        "digest": world.digest,
    }
    if world.start_m is not None:
        facts["start_m"] = [float(part) for part in world.start_m]
    if world.stations_m is not None:
        facts["stations_m"] = [[float(x), float(y)] for x, y in world.stations_m]
    if inside is not None:
        facts["fill_m"] = dict(zip(heights, fill, strict=True))
    facts["rasters"] = {name: _sha(packed) for name, packed in rasters.items()}
    facts["source"] = _plain(world.source)
    for name in (*_HEIGHTS, *_MESH, _INSIDE):
        if name not in rasters:
            (target / f"{name}.npy").unlink(missing_ok=True)
    for name, packed in rasters.items():
        (target / f"{name}.npy").write_bytes(packed)
    (target / WORLD_FILE).write_text(tomli_w.dumps(facts), encoding="utf-8", newline="\n")
    return target


def load_folder(folder: Path | str) -> World:
    """Read a world that :func:`save_world` wrote.

    Args:
        folder: where it lies.

    Returns:
        The world, with read-only rasters.

    Raises:
        WorldError: a file is missing or damaged.
    """
    home = Path(folder)
    facts = _facts(home / WORLD_FILE)
    try:
        rows, columns = int(facts["rows"]), int(facts["columns"])
        digests = {str(name): str(sha) for name, sha in facts["rasters"].items()}
        origin, start, stations = facts["origin_m"], facts.get("start_m"), facts.get("stations_m")
        named, resolution_m, digest = facts["name"], facts["resolution_m"], facts["digest"]
        source = facts.get("source", {})
        fill = {str(name): float(height) for name, height in facts.get("fill_m", {}).items()}
        if not isinstance(source, Mapping) or rows < 1 or columns < 1:
            raise ValueError("rows, columns or source is impossible")
    except (KeyError, TypeError, ValueError, AttributeError, OverflowError) as error:
        why = f"key {error} is missing" if isinstance(error, KeyError) else str(error)
        raise WorldError(f"'{home / WORLD_FILE}' is damaged: {why}") from None
    check_size((rows, columns), f"'{home / WORLD_FILE}'")
    shape = (rows, columns)
    free = _bits(home, "free", digests, shape)
    inside = _bits(home, _INSIDE, digests, shape) != 0 if fill else None
    heights = {}
    for name in _HEIGHTS:
        if name in fill and inside is not None:
            heights[name] = np.full(shape, fill[name], dtype=np.float32)
            count = int(np.count_nonzero(inside))
            heights[name][inside] = _read(home, name, digests, (count,), np.float32)
            heights[name].setflags(write=False)
        elif name in digests:
            heights[name] = _read(home, name, digests, shape, np.float32)
    world = world_from_array(
        free,
        resolution_m,
        name=str(named),
        origin_m=origin,
        start_m=start,
        stations_m=stations,
        ground_m=heights.get("ground"),
        ceiling_m=heights.get("ceiling"),
        mesh=_mesh(home, digests),
        source=source,
    )
    if world.digest != digest:
        raise WorldError(f"'{home}' is damaged: its raster does not have the digest {digest}")
    return world


def _mostly_the_same(
    rasters: Sequence[NDArray[np.float32]],
) -> tuple[list[float], NDArray[np.bool_] | None]:
    """The height that fills most of each raster, and where any differs (None: not worth it)."""
    if not rasters:
        return [], None
    fill = [float(raster.flat[0]) for raster in rasters]
    inside = np.zeros(rasters[0].shape, dtype=np.bool_)
    for raster, height in zip(rasters, fill, strict=True):
        inside |= raster != np.float32(height)
    return fill, inside if np.count_nonzero(inside) < inside.size // 2 else None


def _bits(
    home: Path, name: str, digests: Mapping[str, str], shape: tuple[int, int]
) -> NDArray[np.uint8]:
    bits = _read(home, name, digests, (shape[0], (shape[1] + 7) // 8), np.uint8)
    return np.unpackbits(bits, axis=1, count=shape[1])


def _mesh(home: Path, digests: Mapping[str, str]) -> Mesh | None:
    if not set(_MESH) <= digests.keys():
        return None
    vertices = _read(home, "vertices", digests, (None, 3), np.float32)
    return Mesh(vertices, _read(home, "triangles", digests, (None, 3), np.int32))


def _facts(path: Path) -> dict[str, Any]:
    try:
        facts = tomllib.loads(path.read_text(encoding="utf-8"))
    except FileNotFoundError:
        raise WorldError(f"'{path.parent}' is not a world folder: it has no {path.name}") from None
    except OSError as error:
        raise WorldError(f"cannot read '{path}': {error.strerror or error}") from None
    except (ValueError, RecursionError) as error:
        why = str(error).splitlines()[0][:160] if str(error) else "too many nested brackets"
        raise WorldError(f"'{path}' is damaged: {why}") from None
    if facts.get("format") != _FORMAT:
        raise WorldError(
            f"'{path}': format = {shown(facts.get('format'))}, expected {_FORMAT}: it was written "
            "by another version of swarmscout, or is not a world"
        )
    return facts


def _read(
    home: Path,
    name: str,
    digests: Mapping[str, str],
    shape: tuple[int | None, ...],
    dtype: type,
) -> NDArray[Any]:
    path = home / f"{name}.npy"
    try:
        packed = path.read_bytes()
    except OSError as error:
        raise WorldError(f"'{home}' is damaged: {path.name}: {error.strerror or error}") from None
    if _sha(packed) != digests.get(name):
        raise WorldError(f"'{home}' is damaged: {path.name} is not the file that was written")
    try:
        array: NDArray[Any] = np.load(io.BytesIO(packed), allow_pickle=False)
    except (ValueError, EOFError, OSError) as error:
        raise WorldError(f"'{home}' is damaged: {path.name}: {error}") from None
    if shape[0] is None and array.ndim:
        shape = (array.shape[0], *shape[1:])
    if array.shape != shape or array.dtype != dtype:
        raise WorldError(
            f"'{home}' is damaged: {path.name} holds {array.dtype}{list(array.shape)}, "
            f"expected {np.dtype(dtype)}{list(shape)}"
        )
    array.setflags(write=False)
    return array


def _bytes(array: NDArray[Any]) -> bytes:
    packed = io.BytesIO()
    np.save(packed, array, allow_pickle=False)
    return packed.getvalue()


def _sha(packed: bytes) -> str:
    return hashlib.sha256(packed).hexdigest()


def _plain(source: Mapping[str, Any]) -> dict[str, Any]:
    """What TOML can hold."""
    return {
        str(key): value if isinstance(value, str | bool | int | float) else str(value)
        for key, value in source.items()
        if value is not None
    }
