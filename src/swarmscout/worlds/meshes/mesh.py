"""A cave's surface as triangles, in the frame of its world."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from swarmscout.core.errors import WorldError

__all__ = ["Mesh"]


@dataclass(frozen=True, eq=False)
class Mesh:
    """Triangles in 3D: x right, y up on the map, z up from the ground.

    A mesh need not be closed, and its triangles need not face any way.

    Attributes:
        vertices_m: float32[V, 3], places in metres, in the frame of the world it belongs to.
        triangles: int32[T, 3], each the rows of its three vertices.

    Raises:
        WorldError: the arrays have another shape, a number is not finite, or a triangle names a
            vertex that is not there.

    Example:
        >>> Mesh([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]]).bounds_m[1].tolist()
        [1.0, 1.0, 0.0]
    """

    vertices_m: NDArray[np.float32] = field(repr=False)
    triangles: NDArray[np.int32] = field(repr=False)

    def __post_init__(self) -> None:
        vertices = np.ascontiguousarray(self.vertices_m, dtype=np.float32)
        triangles = np.ascontiguousarray(self.triangles, dtype=np.int32)
        for name, array in (("vertices_m", vertices), ("triangles", triangles)):
            if array.ndim != 2 or array.shape[1] != 3:
                raise WorldError(f"mesh: {name} has shape {list(array.shape)}, expected [n, 3]")
        if not np.isfinite(vertices).all():
            raise WorldError("mesh: a vertex has a coordinate that is not a finite number")
        if len(triangles) and not 0 <= triangles.min() <= triangles.max() < len(vertices):
            raise WorldError(f"mesh: a triangle names a vertex outside 0 to {len(vertices) - 1}")
        for name, array in (("vertices_m", vertices), ("triangles", triangles)):
            # An array that its owner can still write to is copied: a mesh does not change.
            theirs = array is getattr(self, name) and array.flags.writeable
            frozen = array.copy() if theirs else array
            frozen.setflags(write=False)
            object.__setattr__(self, name, frozen)

    @property
    def bounds_m(self) -> NDArray[np.float64]:
        """float64[2, 3]: least and greatest x, y, z in metres; zeros for a mesh of nothing."""
        if not len(self.vertices_m):
            return np.zeros((2, 3))
        return np.array([self.vertices_m.min(axis=0), self.vertices_m.max(axis=0)], np.float64)
