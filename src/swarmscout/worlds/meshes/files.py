"""Triangles out of a mesh's file, whatever its form, and what its tags say.

The files are read by trimesh (the extra ``mesh``). It ignores the up axis that a COLLADA file
names; that and the unit are handed on here as what they are: tags, which may be wrong.
"""

from __future__ import annotations

import hashlib
import io
import itertools
import logging
import re
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from swarmscout.core.errors import WorldError
from swarmscout.core.extras import install_command

__all__ = ["MESH_SUFFIXES", "MeshFile", "read_mesh_file"]

MESH_SUFFIXES = (".dae", ".glb", ".gltf", ".obj", ".off", ".ply", ".stl")
_MOST_TRIANGLES = 50_000_000


@dataclass(frozen=True, eq=False)
class MeshFile:
    """A mesh as its file has it.

    Attributes:
        vertices: float64[V, 3], in the file's unit and axes; may hold what is no number.
        triangles: int64[T, 3], rows of vertices.
        up_tag: the up axis that the format or file names, ``"y"``, ``"z"`` or another, or None.
        unit_m: the file's unit in metres as it says itself, or None.
        sha256: of the file.
    """

    vertices: NDArray[np.float64]
    triangles: NDArray[np.int64]
    up_tag: str | None
    unit_m: float | None
    sha256: str


def read_mesh_file(path: Path) -> MeshFile:
    """Read all triangles of a file; the parts of a scene are put where the scene has them.

    Args:
        path: OBJ, STL, PLY, GLB, glTF, DAE or OFF.

    Raises:
        WorldError: the file is missing, broken, of another kind, or has no triangles; or the extra
            is not installed.
    """
    suffix = path.suffix.lower()
    if suffix not in MESH_SUFFIXES:
        known = ", ".join(MESH_SUFFIXES)
        raise WorldError(f"mesh '{path}': unknown kind of file '{suffix}': known are {known}")
    try:
        packed = path.read_bytes()
    except OSError as error:
        raise WorldError(f"cannot read the mesh '{path}': {error.strerror or error}") from None
    if not packed:
        raise WorldError(f"cannot read the mesh '{path}': the file is empty, it has 0 bytes")
    vertices, triangles = _triangles(path, _scene(path, packed))
    up_tag, unit_m = (None, None)
    if suffix in (".glb", ".gltf"):
        up_tag, unit_m = "y", 1.0  # The format knows nothing else.
    elif suffix == ".dae":
        up_tag, unit_m = _collada_tags(packed)
    return MeshFile(vertices, triangles, up_tag, unit_m, hashlib.sha256(packed).hexdigest())


def _scene(path: Path, packed: bytes) -> Any:
    try:
        import trimesh

        if path.suffix.lower() == ".dae":
            import collada  # noqa: F401 - trimesh would only say that it knows no such file.
    except ImportError:
        raise WorldError(
            f"mesh '{path}': reading meshes needs an extra: {install_command('mesh')}"
        ) from None
    # A missing texture is no trouble here; trimesh would print a warning for each.
    log = logging.getLogger("trimesh")
    quiet, log.disabled = log.disabled, True
    try:
        file: Path | io.BytesIO = path
        if path.suffix.lower() == ".off":
            file = io.BytesIO(_off_in_triangles(packed))
        kind = path.suffix[1:].lower()
        return trimesh.load_scene(file, file_type=kind, process=False, skip_materials=True)
    except MemoryError:
        raise
    except Exception as error:  # Each format has its own ways to be broken.
        why = " ".join(str(error).split())[:160] or type(error).__name__
        raise WorldError(f"cannot read the mesh '{path}': {_damaged(path)} ({why})") from None
    finally:
        log.disabled = quiet


def _off_in_triangles(packed: bytes) -> bytes:
    """OFF with its polygons cut into fans: trimesh stumbles over more than four corners."""
    rows = [line.partition(b"#")[0].split() for line in packed.splitlines()]
    rows = [row for row in rows if row]
    if rows and len(rows[0]) > 1:  # The counts may stand in the first line.
        rows[:1] = [rows[0][:1], rows[0][1:]]
    try:
        first = 2 + int(rows[1][0])
        corners = [row[1 : 1 + int(row[0])] for row in rows[first : first + int(rows[1][1])]]
    except (IndexError, ValueError):
        return packed  # What is wrong with it is found on reading.
    if max(map(len, corners), default=0) <= 4:
        return packed
    fans = [(b"3", face[0], *edge) for face in corners for edge in itertools.pairwise(face[1:])]
    counts = (rows[1][0], b"%d" % len(fans), b"0")
    return b"\n".join(b" ".join(row) for row in (rows[0], counts, *rows[2:first], *fans))


def _damaged(path: Path) -> str:
    """What is likely wrong with a file that the library makes nothing of."""
    more = ", or a file that it needs is missing" if path.suffix.lower() == ".gltf" else ""
    return f"it is damaged, cut off, or no {path.suffix[1:].upper()} file{more}"


def _triangles(path: Path, scene: Any) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """All triangles of a scene, each instance of a part in its own place."""
    vertices: list[NDArray[np.float64]] = []
    triangles: list[NDArray[np.int64]] = []
    points = count = first = 0
    for node in scene.graph.nodes_geometry:
        transform, name = scene.graph[node]
        part = scene.geometry[name]
        faces = np.asarray(getattr(part, "faces", ()))
        at = np.asarray(part.vertices, dtype=np.float64)
        points += len(at)
        if faces.ndim != 2 or not len(faces):
            continue
        count += len(faces)
        if count > _MOST_TRIANGLES:
            raise WorldError(
                f"mesh '{path}' has more than {_MOST_TRIANGLES:,} triangles: decimate it first"
            )
        if int(faces.min()) < 0 or int(faces.max()) >= len(at):
            raise WorldError(f"mesh '{path}' is broken: a triangle names a vertex that is missing")
        matrix = np.asarray(transform, dtype=np.float64)
        if not np.array_equal(matrix, np.eye(4)):
            with np.errstate(invalid="ignore", over="ignore"):
                at = at @ matrix[:3, :3].T + matrix[:3, 3]
        vertices.append(at)
        triangles.append(faces.astype(np.int64) + first)
        first += len(at)
    if not count:
        what = f"only {points:,} points; make a surface of them first" if points else _damaged(path)
        raise WorldError(f"mesh '{path}' has no triangles: {what}")
    return np.concatenate(vertices), np.concatenate(triangles)


def _collada_tags(packed: bytes) -> tuple[str | None, float | None]:
    """The up axis and the unit that a COLLADA file names."""
    axis = re.search(rb"<up_axis>\s*([XYZ])_UP", packed)
    unit = re.search(rb"<unit\b[^>]*\bmeter\s*=\s*[\"']([0-9.eE+-]+)[\"']", packed)
    try:
        unit_m = float(unit[1]) if unit else 0.0
    except ValueError:
        unit_m = 0.0
    return (axis[1].decode().lower() if axis else None), (unit_m if 0.0 < unit_m < 1e9 else None)
