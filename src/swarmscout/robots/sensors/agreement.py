"""How well sensing against a world's raster agrees with exact sensing against its mesh."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from swarmscout.core.errors import WorldError
from swarmscout.core.streams import stream
from swarmscout.robots.bodies import TICKS, place_bodies
from swarmscout.robots.sensors.fan import Fan
from swarmscout.worlds.reachability import standing_places
from swarmscout.worlds.world import World

__all__ = ["Agreement", "sensing_agreement"]

WITHIN_M = 0.1


@dataclass(frozen=True)
class Agreement:
    """Rays cast against a world's raster and against its mesh, compared.

    Attributes:
        rays: number of rays compared.
        hits: share of rays that met a wall in both or in neither.
        alike: share of rays that moreover measured the same within 0.1 m.
        walls_alike: the same share among the rays that met a wall in at least one; most rays meet
            none in both.
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
    sensor: Fan | None = None,
    radius_m: float = 0.15,
) -> Agreement:
    """Compare scans without noise, from random places that a robot can reach.

    Args:
        world: a world with a mesh.
        scans: number of scans. seed: names their places and headings.
        sensor: a fan without noise, by default the paper's. radius_m: the robot's radius.

    Raises:
        WorldError: the world has no mesh, no robot can stand in it, or there are no scans.
    """
    if scans < 1:
        raise WorldError(f"scans = {scans}: expected 1 or more")
    if world.mesh is None:
        raise WorldError(f"world '{world.name}' has no mesh to compare its raster with")
    rng = stream(seed, "agreement")
    cells = np.argwhere(standing_places(world, radius_m))
    position = world.frame.centres_of(cells[rng.integers(len(cells), size=scans)])
    bodies = place_bodies(
        position, rng.integers(0, TICKS, scans), np.ones(scans), radius_m=radius_m
    )
    fan = sensor or Fan(noise_m=0.0)
    on_raster, on_mesh = (
        fan.model_copy(update={"sensing": sensing}).scan(bodies, world, 0).ranges
        for sensing in ("raster", "mesh")
    )
    met, touched = np.isfinite(on_raster), np.isfinite(on_mesh)
    both = met & touched
    near = np.zeros_like(both)
    near[both] = np.abs(on_raster[both] - on_mesh[both]) <= WITHIN_M
    return Agreement(
        rays=on_mesh.size,
        hits=float((met == touched).mean()),
        alike=float((near | (~met & ~touched)).mean()),
        walls_alike=float(near[met | touched].mean()) if (met | touched).any() else 1.0,
        raster_hits=float(met.mean()),
        mesh_hits=float(touched.mean()),
    )
