"""From a mesh's own axes and unit to a world's frame: z up, metres, not far from the origin."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from swarmscout.core.errors import WorldError
from swarmscout.worlds.meshes.files import MeshFile

__all__ = ["Alignment", "align", "with_ground"]

_FAR_M = 10_000.0
"""Beyond this a float32 is coarser than a millimetre."""
_AXES = ("z", "y", "x")
_CLEARLY, _VERY_CLEARLY = 2.0, 4.0
"""By this factor the shape of a mesh must contradict its tag (or the habit of its format).

Meshes with x up are rare, and a narrow passage has more wall than floor.
"""
_LEVEL = math.cos(math.radians(30.0))
"""Surfaces that can be driven on are level: mines may be inclined as a whole."""
_BELOW_M = 0.0005
"""An added ground lies under the lower faces of walls that stand on it, not in them."""
_SMALL_M, _LARGE_M = 1.0, 5000.0
"""Places for robots of 0.3 m are this long; anything else is taken for another unit."""


@dataclass(frozen=True, eq=False)
class Alignment:
    """Vertices in a world's frame, and how they came there.

    Attributes:
        vertices_m: float64[V, 3], z up, in metres.
        offset_m: what was taken off the mesh's coordinates (z up, in metres), whole metres.
        up: ``"z"``, ``"y"`` or ``"x"``: the axis of the mesh that points up.
        up_because: why that one.
        scale: metres per unit of the file.
        scale_because: why.
    """

    vertices_m: NDArray[np.float64]
    offset_m: tuple[float, float, float]
    up: str
    up_because: str
    scale: float
    scale_because: str


def align(
    file: MeshFile,
    vertices: NDArray[np.float64],
    triangles: NDArray[np.int32],
    up: str | None,
    scale: float | None,
) -> Alignment:
    """Turn, scale and shift a mesh's vertices.

    Args:
        file: for its tags.
        vertices: float64[V, 3] in the file's axes and unit, finite.
        triangles: int32[T, 3].
        up: the axis that points up, ``"z"``, ``"y"`` or ``"x"``; None: it is guessed.
        scale: metres per unit; None: the file's tag where the size is then plausible, otherwise 1.

    Raises:
        WorldError: the axis or the scale is impossible.
    """
    if up not in (None, *_AXES):
        raise WorldError(f"up = {up!r}: expected 'z', 'y' or 'x', the axis of the mesh that is up")
    if scale is not None and not (isinstance(scale, int | float) and 0.0 < scale < math.inf):
        raise WorldError(f"scale = {scale!r}: expected metres per unit of the file, as 0.001")
    up_because = "as given"
    if up is None:
        up, up_because = _guess_up(file.up_tag, vertices, triangles)
    scale_because = "as given"
    if scale is None:
        scale, scale_because = _guess_scale(file.unit_m, vertices)
    turned = vertices * float(scale)
    if up == "y":
        turned = np.stack((turned[:, 0], -turned[:, 2], turned[:, 1]), axis=1)
    elif up == "x":
        turned = turned[:, [1, 2, 0]]
    offset = np.zeros(3)
    if len(turned) and np.abs(turned).max() > _FAR_M:
        low, high = turned.min(axis=0), turned.max(axis=0)
        # Only axes that are far off, by whole metres.
        far = np.maximum(np.abs(low), np.abs(high)) > _FAR_M
        offset = np.where(far, np.floor((low + high) / 2.0), 0.0)
    x, y, z = offset.tolist()
    return Alignment(turned - offset, (x, y, z), up, up_because, float(scale), scale_because)


def with_ground(
    at: Alignment, triangles: NDArray[np.int32], ground_m: float | str
) -> tuple[Alignment, NDArray[np.int32]]:
    """Add a level rectangle under a mesh, as large as the mesh is seen from above.

    Args:
        at: the mesh in its world's frame.
        triangles: int32[T, 3].
        ground_m: its height in metres, before the shift to the world's frame; or ``"lowest"``.

    Raises:
        WorldError: the height is neither.
    """
    low, high = at.vertices_m.min(axis=0), at.vertices_m.max(axis=0)
    try:
        height = float(low[2]) if ground_m == "lowest" else float(ground_m) - at.offset_m[2]
    except (TypeError, ValueError):
        height = math.nan
    if not math.isfinite(height):
        raise WorldError(f"ground = {ground_m!r}: expected a height in metres, or 'lowest'")
    corners = [(x, y, height - _BELOW_M) for y in (low[1], high[1]) for x in (low[0], high[0])]
    first = len(at.vertices_m)
    sheet = np.array([[0, 1, 3], [0, 3, 2]], dtype=np.int32) + np.int32(first)
    vertices = np.concatenate((at.vertices_m, np.array(corners)))
    return replace(at, vertices_m=vertices), np.concatenate((triangles, sheet))


def _guess_up(
    tag: str | None, vertices: NDArray[np.float64], triangles: NDArray[np.int32]
) -> tuple[str, str]:
    """The tag, or z without one, unless level surfaces and the extents clearly speak against it."""
    expected = tag if tag in _AXES else "z"
    habit = f"the file says {expected}" if tag in _AXES else "most meshes are"
    evidence = {axis: _levelness(vertices, triangles, axis) for axis in _AXES}
    scores = {
        axis: evidence[axis] / (_VERY_CLEARLY if axis == "x" else _CLEARLY)
        for axis in _AXES
        if axis != expected
    }
    other = max(scores, key=lambda axis: scores[axis])
    if scores[other] > evidence[expected]:
        says = f"though the file says {expected}" if tag in _AXES else "unlike most meshes"
        return other, f"its level surfaces say so, {says}"
    return expected, f"{habit}, and its level surfaces do not contradict"


def _levelness(vertices: NDArray[np.float64], triangles: NDArray[np.int32], axis: str) -> float:
    """How well an axis does for up: much level surface, and a mesh that is low along it."""
    number = "xyz".index(axis)
    extent = np.ptp(vertices, axis=0) if len(vertices) else np.ones(3)
    longest = max(float(extent.max()), 1e-300)
    low = float(extent[number]) / longest
    a, b, c = (vertices[triangles[:, corner]] / longest for corner in range(3))
    across = np.cross(b - a, c - a)
    size = np.linalg.norm(across, axis=1)
    upright = np.abs(across[:, number])
    level = float(upright[upright >= _LEVEL * size].sum())
    return level / math.sqrt(low + 0.01)


def _guess_scale(unit_m: float | None, vertices: NDArray[np.float64]) -> tuple[float, str]:
    """The file's own unit where the mesh then has a plausible size."""
    if unit_m is None:
        return 1.0, "the file names no unit"
    if unit_m == 1.0:
        return 1.0, "the file is in metres"
    longest = float(np.ptp(vertices, axis=0).max()) if len(vertices) else 0.0
    if _SMALL_M <= longest * unit_m <= _LARGE_M or not _SMALL_M <= longest <= _LARGE_M:
        return unit_m, f"the file says that its unit is {unit_m:g} m"
    return 1.0, f"the file says {unit_m:g} m, but then it would be {longest * unit_m:,.3g} m long"
