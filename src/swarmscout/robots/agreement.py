"""How far sensing against a world's raster and exact sensing against its mesh say the same."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from swarmscout.core.errors import WorldError
from swarmscout.core.streams import stream
from swarmscout.robots.bodies import TICKS, heading_table
from swarmscout.robots.mesh_sensor import bucket_triangles, scan_mesh
from swarmscout.robots.range_sensor import RangeSensor, cast_rays
from swarmscout.worlds.ground_plane import stand
from swarmscout.worlds.reachability import standing_places
from swarmscout.worlds.world import World

__all__ = ["Agreement", "sensing_agreement"]

WITHIN_M = 0.1


@dataclass(frozen=True)
class Agreement:
    """What comparing many rays gave.

    Attributes:
        rays: how many were compared.
        hits: share of rays that met a wall on both sides or on neither.
        alike: share of rays that moreover measured the same within 0.1 m.
        walls_alike: the same of those rays alone that met a wall on either side; most rays meet
            none, and agree in that.
        raster_hits, mesh_hits: shares of rays that met a wall.
    """

    rays: int
    hits: float
    alike: float
    walls_alike: float
    raster_hits: float
    mesh_hits: float


def sensing_agreement(
    world: World,
    *,
    scans: int = 3000,
    seed: int = 0,
    rays: int = 9,
    fan_deg: float = 70.0,
    range_m: float = 1.0,
    height_m: float = 0.2,
    radius_m: float = 0.15,
) -> Agreement:
    """Compare scans without noise, from random places that a robot can reach.

    Args:
        world: a world with a mesh.
        scans: how many. seed: which places and headings.
        rays, fan_deg, range_m, height_m: the sensor. radius_m: the robot's.

    Raises:
        WorldError: the world has no mesh, or no robot can stand in it; or there are no scans.
    """
    if scans < 1:
        raise WorldError(f"scans = {scans}: expected 1 or more")
    if world.mesh is None:
        raise WorldError(f"world '{world.name}' has no mesh to compare its raster with")
    rng = stream(seed, "agreement")
    cells = np.argwhere(standing_places(world, radius_m))
    position = world.frame.centres_of(cells[rng.integers(len(cells), size=scans)])
    heading = rng.integers(0, TICKS, scans)
    sensor, table = RangeSensor(rays, fan_deg, range_m), heading_table()
    alive, noise = np.ones(scans, dtype=np.bool_), np.zeros((scans, rays))
    on_raster, on_mesh = np.zeros((scans, rays)), np.zeros((scans, rays))
    cast_rays(
        world.free, *world.origin_m, world.resolution_m, position, heading, alive,
        sensor.offsets, table, range_m, noise, on_raster,
    )  # fmt: skip
    footing = stand(world, position, radius_m)
    scan_mesh(
        bucket_triangles(world.mesh), position, footing, height_m, heading, alive,
        sensor, table, noise, on_mesh,
    )  # fmt: skip
    met, touched = np.isfinite(on_raster), np.isfinite(on_mesh)
    both = met & touched
    near = np.zeros_like(both)
    near[both] = np.abs(on_raster[both] - on_mesh[both]) <= WITHIN_M
    return Agreement(
        rays=scans * rays,
        hits=float((met == touched).mean()),
        alike=float((near | (~met & ~touched)).mean()),
        walls_alike=float(near[met | touched].mean()) if (met | touched).any() else 1.0,
        raster_hits=float(met.mean()),
        mesh_hits=float(touched.mean()),
    )
