"""Meshes for tests: a world's raster as upright walls on its floor."""

from __future__ import annotations

import numpy as np

from swarmscout.worlds import Mesh, World


def extruded(world: World, wall_m: float = 1.0) -> Mesh:
    """The floor of a flat world as squares, and walls along the edges of its raster's free cells.

    Triangles face this way and that, and none is joined to its neighbour.
    """
    free = np.pad(world.free != 0, 1)
    (ox, oy), res = world.origin_m, world.resolution_m
    quads = []
    for row, col in np.argwhere(free):
        x, y = ox + (col - 1) * res, oy + (row - 1) * res
        corners = [(x, y), (x + res, y), (x + res, y + res), (x, y + res)]
        quads.append([(*corner, 0.0) for corner in corners])
        for k, (down, right) in enumerate(((-1, 0), (0, 1), (1, 0), (0, -1))):
            if not free[row + down, col + right]:
                (ax, ay), (bx, by) = corners[k], corners[(k + 1) % 4]
                quads.append([(ax, ay, 0.0), (bx, by, 0.0), (bx, by, wall_m), (ax, ay, wall_m)])
    vertices = np.array(quads, dtype=np.float32).reshape(-1, 3)
    first = 4 * np.arange(len(quads))[:, None]
    return Mesh(vertices, np.vstack([first + np.array(half) for half in ((0, 1, 2), (3, 2, 0))]))
