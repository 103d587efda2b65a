"""A lava tube in 3D: the mesh that goes with a generated world."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from swarmscout.core.errors import WorldError
from swarmscout.worlds.meshes.blocks import breakdown_blocks
from swarmscout.worlds.meshes.decimation import decimated
from swarmscout.worlds.meshes.files import check_mesh_extra
from swarmscout.worlds.meshes.mesh import Mesh
from swarmscout.worlds.meshes.skylights import place_skylights
from swarmscout.worlds.meshes.surfacing import Triangles, largest_part, surface_of
from swarmscout.worlds.meshes.tube_surface import TubeSurface
from swarmscout.worlds.tube import tube_fields
from swarmscout.worlds.tube_parameters import TubeParameters
from swarmscout.worlds.world import World

__all__ = ["check_tube_mesh", "generated_mesh", "tube_mesh"]

_STEPS_M = (0.05, 0.5)
_MOST_SKYLIGHTS = 100


def check_tube_mesh(mesh_resolution_m: float = 0.2, skylights: int = 0) -> None:
    """Say what would keep :func:`tube_mesh` from its work, before it begins.

    Raises:
        WorldError: a number is impossible, or a package is missing.
    """
    low, high = _STEPS_M
    if not math.isfinite(mesh_resolution_m) or not low <= mesh_resolution_m <= high:
        raise WorldError(f"mesh_resolution_m = {mesh_resolution_m}: expected {low:g} to {high:g}")
    if isinstance(skylights, bool) or not isinstance(skylights, int):
        raise WorldError(f"skylights = {skylights!r}: expected a whole number")
    if not 0 <= skylights <= _MOST_SKYLIGHTS:
        raise WorldError(f"skylights = {skylights}: expected 0 to {_MOST_SKYLIGHTS}")
    check_mesh_extra("making a mesh")


def tube_mesh(
    parameters: TubeParameters,
    *,
    mesh_resolution_m: float = 0.2,
    skylights: int = 0,
    on_progress: Callable[[int, int], None] | None = None,
) -> Mesh:
    """Make the mesh of a lava tube.

    It is made of the same fields as the world of :func:`swarmscout.worlds.generate_tube`: in free
    cells its floor is the world's ground and the roof above is the world's ceiling, and at a
    sensor's height walls and breakdown stand where the world has them.

    Args:
        parameters: the tube's looks and its seed; the same parameters give the same mesh, bit for
            bit.
        mesh_resolution_m: distance of the points that the surface is found on, in
            metres, 0.05 to 0.5.
        skylights: holes in the roof, up to the open sky; fewer where there is no room. The world's
            raster does not have them.
        on_progress: called with the work that is done and all of it.

    Returns:
        The tube as one closed surface (with skylights it is open at their upper rims, and nowhere
        else), and each boulder of breakdown as a closed convex one. All triangles face the open.

    Raises:
        WorldError: a number is impossible, the mesh would be too large, or the extra ``mesh`` is
            not installed.

    Example:
        >>> from swarmscout.worlds import TubeParameters, tube_mesh
        >>> mesh = tube_mesh(TubeParameters(size_m=30, length_m=25, branches=0))
        >>> mesh.vertices_m.shape[1]
        3
    """
    check_tube_mesh(mesh_resolution_m, skylights)
    fields = tube_fields(parameters)
    holes = place_skylights(fields, parameters, skylights)
    surface = TubeSurface(fields, parameters, mesh_resolution_m, holes)
    # Finding the surface takes as long as making it simpler: each counts for a half.
    report = on_progress or (lambda done, total: None)
    found = largest_part(surface_of(surface, lambda done, total: report(done, 2 * total)))
    shells = [_facing_open(decimated(found))]
    shells += breakdown_blocks(fields, surface.base_m, parameters)
    report(1, 1)
    counts = np.cumsum([0] + [len(vertices) for vertices, _ in shells[:-1]])
    return Mesh(
        np.concatenate([vertices for vertices, _ in shells]).astype(np.float32),
        np.concatenate(
            [triangles + count for (_, triangles), count in zip(shells, counts, strict=True)]
        ).astype(np.int32),
    )


def generated_mesh(world: World) -> Mesh | None:
    """The mesh of a world that :func:`swarmscout.worlds.generate_tube` made; None of any other.

    It is made once and kept with the world.

    Raises:
        WorldError: the extra ``mesh`` is not installed.
    """
    source = world.source
    if source.get("generator") != "lava-tube" or source.get("digest") != world.digest:
        return None
    return world.once("mesh", lambda: tube_mesh(TubeParameters.of(source)))


def _facing_open(surface: Triangles) -> Triangles:
    """The triangles of a cave turned so that they face its inside."""
    vertices, triangles = surface
    corners = vertices[triangles] - vertices.mean(axis=0)
    volume = np.einsum("ij,ij->i", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])).sum()
    return (vertices, triangles[:, ::-1]) if volume > 0.0 else surface
