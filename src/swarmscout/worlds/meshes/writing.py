"""Meshes into files that other programs read."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

import numpy as np

from swarmscout.core.errors import WorldError
from swarmscout.worlds.meshes.files import check_mesh_extra
from swarmscout.worlds.meshes.mesh import Mesh

__all__ = ["MESH_SUFFIXES", "check_mesh_file", "write_mesh"]

MESH_SUFFIXES = (".ply", ".obj", ".stl", ".glb", ".off")
_Y_UP = np.array([[1, 0, 0, 0], [0, 0, 1, 0], [0, -1, 0, 0], [0, 0, 0, 1]], dtype=np.float64)


def check_mesh_file(path: Path | str) -> Path:
    """Say what would keep :func:`write_mesh` from writing, before the mesh is made.

    Args:
        path: the file to be written.

    Returns:
        The file.

    Raises:
        WorldError: its kind is unknown, it exists, its folder is missing or closed to
            us, or a package is missing.
    """
    file = Path(path)
    if file.suffix.lower() not in MESH_SUFFIXES:
        raise WorldError(
            f"mesh '{file}': unknown kind of file '{file.suffix}': known are "
            f"{', '.join(MESH_SUFFIXES)}"
        )
    if file.exists():
        raise WorldError(f"mesh '{file}' exists: choose another name")
    if not file.parent.is_dir():
        raise WorldError(f"mesh '{file}': there is no folder '{file.parent}'")
    if not os.access(file.parent, os.W_OK | os.X_OK):
        raise WorldError(f"mesh '{file}': no permission to write into '{file.parent}'")
    check_mesh_extra("writing a mesh")
    return file


def write_mesh(mesh: Mesh, path: Path | str) -> Path:
    """Write a mesh; the suffix says the form: PLY, OBJ, STL, GLB or OFF.

    Lengths are metres and z is up; in GLB y is up, as its standard requires.

    Args:
        mesh: a mesh.
        path: a file that is not there yet.

    Returns:
        The file.

    Raises:
        WorldError: the file cannot be written, or exists, or the extra ``mesh`` is not
            installed.
    """
    file = check_mesh_file(path)
    import trimesh

    form = file.suffix.lower().lstrip(".")
    solid = trimesh.Trimesh(mesh.vertices_m, mesh.triangles, process=False)
    if form == "glb":
        solid.apply_transform(_Y_UP)
    packed: Any = solid.export(file_type=form)
    data = packed.encode() if isinstance(packed, str) else packed
    try:
        with file.open("xb") as target:
            target.write(data)
    except OSError as error:
        if not isinstance(error, FileExistsError):
            file.unlink(missing_ok=True)
        raise WorldError(f"cannot write mesh '{file}': {error.strerror or error}") from None
    return file
