"""Triangles of a mesh file of any supported format, and what its tags say.

Every mission imports this module for the list of formats; the readers are imported by who reads.
"""

from __future__ import annotations

import hashlib
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from swarmscout.core.errors import WorldError
from swarmscout.core.extras import install_command

if TYPE_CHECKING:
    from swarmscout.worlds.meshes.polygons import Polygons

__all__ = ["MESH_SUFFIXES", "MeshFile", "check_mesh_extra", "read_mesh_file"]

MESH_SUFFIXES = (".dae", ".glb", ".gltf", ".obj", ".off", ".ply", ".stl")
_MOST_TRIANGLES = 50_000_000


@dataclass(frozen=True, eq=False)
class MeshFile:
    """A mesh as its file has it.

    Attributes:
        vertices: float64[V, 3], in the unit and axes of the file; may hold values that are not
            finite.
        triangles: int64[T, 3], rows of ``vertices``.
        up_tag: the up axis that the format or the file names, ``"y"``, ``"z"`` or another, or None.
        unit_m: the unit in metres that the file names, or None.
        sha256: of the file.
        crossing: the number of polygons that cross themselves, whose surface is ambiguous.
    """

    vertices: NDArray[np.float64]
    triangles: NDArray[np.int64]
    up_tag: str | None
    unit_m: float | None
    sha256: str
    crossing: int = 0


def read_mesh_file(path: Path) -> MeshFile:
    """Read all triangles of a file; the parts of a scene are put where the scene has them.

    Args:
        path: an OBJ, STL, PLY, GLB, glTF, DAE or OFF file.

    Raises:
        WorldError: the file is missing, damaged, of another kind, or has no triangles; or the extra
            ``mesh`` is not installed.
    """
    suffix = path.suffix.lower()
    if suffix not in MESH_SUFFIXES:
        known = ", ".join(MESH_SUFFIXES)
        raise WorldError(f"mesh '{path}': unknown kind of file '{suffix}': known are {known}")
    check_mesh_extra(f"mesh '{path}': reading meshes")
    try:
        packed = path.read_bytes()
    except OSError as error:
        raise WorldError(f"cannot read the mesh '{path}': {error.strerror or error}") from None
    if not packed:
        raise WorldError(f"cannot read the mesh '{path}': the file is empty, it has 0 bytes")
    from swarmscout.worlds.meshes.polygons import triangulated

    try:
        polygons, up_tag, unit_m = _polygons(packed, suffix, path.parent)
        if not len(polygons.counts):
            raise WorldError(_without_surface(polygons, suffix))
        if int(polygons.counts.sum()) - 2 * len(polygons.counts) > _MOST_TRIANGLES:
            raise WorldError(f"it has more than {_MOST_TRIANGLES:,} triangles: decimate it first")
        triangles, crossing = triangulated(polygons.check())
    except WorldError as error:
        raise WorldError(f"cannot read the mesh '{path}': {error}") from None
    sha256 = hashlib.sha256(packed).hexdigest()
    return MeshFile(polygons.vertices, triangles, up_tag, unit_m, sha256, crossing)


def _polygons(
    packed: bytes, suffix: str, folder: Path
) -> tuple[Polygons, str | None, float | None]:
    """The surface, the up axis and the unit, as far as the file names them."""
    from swarmscout.worlds.meshes.formats.collada import read_collada
    from swarmscout.worlds.meshes.formats.gltf import read_gltf
    from swarmscout.worlds.meshes.formats.obj import read_obj
    from swarmscout.worlds.meshes.formats.off import read_off
    from swarmscout.worlds.meshes.formats.ply import read_ply
    from swarmscout.worlds.meshes.formats.stl import read_stl

    if suffix == ".dae":
        return read_collada(packed)
    if suffix in (".glb", ".gltf"):
        # Their standard has no other axis and unit.
        return read_gltf(packed, folder, suffix[1:].upper()), "y", 1.0
    plain = {".obj": read_obj, ".off": read_off, ".ply": read_ply, ".stl": read_stl}
    return plain[suffix](packed), None, None


def check_mesh_extra(what: str) -> None:
    """Complain where the packages of the extra ``mesh`` are missing.

    Args:
        what: what needs them, as the beginning of a sentence.

    Raises:
        WorldError: with the command that installs them.
    """
    for package in ("fast_simplification", "mapbox_earcut", "plyfile", "skimage", "trimesh"):
        if not _is_installed(package):
            raise WorldError(f"{what} needs an extra: {install_command('mesh')}")


def _is_installed(package: str) -> bool:
    try:
        return find_spec(package) is not None
    except ValueError:
        return False


def _without_surface(polygons: Polygons, suffix: str) -> str:
    if len(polygons.vertices):
        return (
            f"it has no triangles: only {len(polygons.vertices):,} points; make a surface of them "
            "first"
        )
    return f"it has no triangles: damaged, cut off, or no {suffix[1:].upper()} file"
