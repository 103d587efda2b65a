"""How a body stands on the ground: its height and the slope under it."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
from numpy.typing import NDArray

from swarmscout.core.jit import inlined, kernel
from swarmscout.worlds.world import World

__all__ = ["pitch_and_roll", "stand", "without_steep"]


def stand(world: World, points_m: NDArray[np.float64], radius_m: float) -> NDArray[np.float64]:
    """The plane that bodies stand on: fitted to the free ground under them by least squares.

    Args:
        world: a world; without heights its ground is flat at 0.
        points_m: float64[N, 2], where bodies stand, in metres.
        radius_m: their radius; ground within one and a half raster cells counts at least.

    Returns:
        float64[N, 3]: height in metres at the point, and how much the ground rises per metre
        along x and along y.
    """
    footing = np.zeros((len(points_m), 3))
    if world.ground_m is not None:
        points = np.ascontiguousarray(points_m, dtype=np.float64)
        (ox, oy), res = world.origin_m, world.resolution_m
        ground = world.ground_m.view()
        ground.setflags(write=False)  # As the raster is: the kernel has one signature.
        fit_planes(world.free, ground, ox, oy, res, points, radius_m, footing)
    return footing


def pitch_and_roll(
    footing: NDArray[np.float64], heading_rad: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Pitch and roll [N] in radians of bodies on the ground, as ROS counts them.

    Source: REP 103 (x forward, y left, z up; yaw, then pitch, then roll): positive pitch is nose
    down, positive roll is left side up.

    Args:
        footing: float64[N, 3] from :func:`stand`.
        heading_rad: float64[N], counter-clockwise from +x.
    """
    cos, sin = np.cos(heading_rad), np.sin(heading_rad)
    ahead = footing[:, 1] * cos + footing[:, 2] * sin
    left = footing[:, 2] * cos - footing[:, 1] * sin
    return np.arctan(-ahead), np.arcsin(left / np.sqrt(1.0 + ahead**2 + left**2))


def without_steep(world: World, slope_deg: float, radius_m: float) -> World:
    """A world without the places where the ground under a body is too steep for it.

    Args:
        world: a world; it is returned as it is where it has no heights or nothing is too steep.
        slope_deg: steepest ground that a body drives over, in degrees; 90 for any.
        radius_m: the body's radius, in metres.
    """
    if world.ground_m is None or slope_deg >= 90.0:
        return world
    changed = world.once(
        ("without steep", slope_deg, radius_m), lambda: _without_steep(world, slope_deg, radius_m)
    )
    return world if changed is None else changed


def _without_steep(world: World, slope_deg: float, radius_m: float) -> World | None:
    """Such a world, or None where nothing is too steep."""
    cells = np.argwhere(world.free != 0)
    footing = stand(world, world.frame.centres_of(cells), radius_m)
    limit = math.tan(math.radians(slope_deg))
    steep = cells[footing[:, 1] ** 2 + footing[:, 2] ** 2 > limit * limit]
    if not len(steep):
        return None
    free = world.free.copy()
    free[steep[:, 0], steep[:, 1]] = 0
    return dataclasses.replace(world, free=free)


@inlined
def _solve(n, sx, sy, sz, sxx, sxy, syy, sxz, syz, plane):  # type: ignore[no-untyped-def]
    """The least-squares plane through n points, from the sums over them; level through a line."""
    mx, my, mz = sx / n, sy / n, sz / n
    cxx, cxy, cyy = sxx - n * mx * mx, sxy - n * mx * my, syy - n * my * my
    cxz, cyz = sxz - n * mx * mz, syz - n * my * mz
    determinant = cxx * cyy - cxy * cxy
    plane[0], plane[1], plane[2] = mz, 0.0, 0.0
    if determinant > 1e-6 * (cxx + cyy) * (cxx + cyy):
        plane[1] = (cxz * cyy - cyz * cxy) / determinant
        plane[2] = (cyz * cxx - cxz * cxy) / determinant
        plane[0] = mz - plane[1] * mx - plane[2] * my


@kernel
def fit_planes(free, ground, ox, oy, res, points, radius, footing):  # type: ignore[no-untyped-def]
    """Fit a plane to the free ground round each point; see :func:`stand`."""
    rows, columns = free.shape
    reach = max(radius, 1.5 * res)
    for i in range(points.shape[0]):
        x, y = points[i, 0], points[i, 1]
        low_row = max(0, int(math.floor((y - reach - oy) / res)))
        high_row = min(rows - 1, int(math.floor((y + reach - oy) / res)))
        low_col = max(0, int(math.floor((x - reach - ox) / res)))
        high_col = min(columns - 1, int(math.floor((x + reach - ox) / res)))
        n = 0
        sx = sy = sz = sxx = sxy = syy = sxz = syz = 0.0
        for row in range(low_row, high_row + 1):
            dy = oy + (row + 0.5) * res - y
            for col in range(low_col, high_col + 1):
                dx = ox + (col + 0.5) * res - x
                if dx * dx + dy * dy > reach * reach or free[row, col] == 0:
                    continue
                z = ground[row, col]
                n += 1
                sx += dx
                sy += dy
                sz += z
                sxx += dx * dx
                sxy += dx * dy
                syy += dy * dy
                sxz += dx * z
                syz += dy * z
        if n > 0:
            _solve(n, sx, sy, sz, sxx, sxy, syy, sxz, syz, footing[i])
        else:
            row = min(rows - 1, max(0, int(math.floor((y - oy) / res))))
            col = min(columns - 1, max(0, int(math.floor((x - ox) / res))))
            footing[i, 0], footing[i, 1], footing[i, 2] = ground[row, col], 0.0, 0.0
