"""Phase 1 of a step: bodies sense, and minds get what was sensed.

Walls are those of the world's raster, or in 3D the triangles of its mesh.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from swarmscout.core.streams import stream
from swarmscout.minds.minds import Minds
from swarmscout.mission.scenario import Scenario
from swarmscout.robots.bodies import TICKS, Bodies, to_ticks
from swarmscout.robots.mesh_sensor import bucket_triangles, scan_mesh
from swarmscout.robots.range_sensor import RangeSensor, cast_rays, mark_clear
from swarmscout.worlds.ground_plane import stand
from swarmscout.worlds.meshes.mesh import Mesh
from swarmscout.worlds.world import World

__all__ = ["Senses"]

BLOCK_STEPS = 50
"""Noise is drawn for so many steps at once, for all robots, whether they live or not."""


class Senses:
    """The range sensor and the sense of place, with their noise.

    Attributes:
        sensor: the fan of rays.
        ranges: float64[N, rays], what was measured last.

    Args:
        scenario: which sensor.
        world: what it meets.
        headings: float64[3600, 2], (cos, sin).
        mesh: the cave's surface, for exact sensing.
    """

    def __init__(
        self,
        scenario: Scenario,
        world: World,
        headings: NDArray[np.float64],
        mesh: Mesh | None = None,
    ) -> None:
        sensor, body = scenario.sensor, scenario.body
        self.sensor = RangeSensor(sensor.rays, sensor.fan_deg, sensor.range_m)
        self.ranges = np.full((scenario.robots, sensor.rays), np.inf)
        self._headings = headings
        self._world = world
        self._triangles = None if mesh is None else bucket_triangles(mesh)
        if mesh is None:
            self._raster = mark_clear(world.free, world.resolution_m, sensor.range_m)
        self._seed = scenario.seed
        self._noise_m = sensor.noise_m
        self._height_m = sensor.height_m
        self._radius_m = body.radius_m
        self._position_noise_m = body.position_noise_m
        self._heading_noise_ticks = to_ticks(body.heading_noise_deg)
        self._block = -1
        self._noise = np.zeros((BLOCK_STEPS, scenario.robots, sensor.rays))
        self._pose_noise = np.zeros((BLOCK_STEPS, scenario.robots, 3))

    def read(self, bodies: Bodies, minds: Minds, step: int) -> NDArray[np.float64]:
        """Sense once with all robots; where they believe to be goes into ``minds.own``.

        Returns:
            float64[N, rays], measured ranges in metres, inf where nothing was met.
        """
        self._draw(step)
        own = minds.own
        own["x_m"], own["y_m"] = bodies.position[:, 0], bodies.position[:, 1]
        own["heading"] = bodies.heading
        if self._position_noise_m > 0.0:
            own["x_m"] += self._pose_noise[step % BLOCK_STEPS, :, 0]
            own["y_m"] += self._pose_noise[step % BLOCK_STEPS, :, 1]
        if self._heading_noise_ticks > 0:
            noise = np.rint(self._pose_noise[step % BLOCK_STEPS, :, 2]).astype(np.int64)
            own["heading"] = (own["heading"] + noise) % TICKS
        self._cast(bodies, self._noise[step % BLOCK_STEPS])
        return self.ranges

    def _cast(self, bodies: Bodies, noise: NDArray[np.float64]) -> None:
        sensor, world, triangles = self.sensor, self._world, self._triangles
        if triangles is None:
            cast_rays(
                self._raster, *world.origin_m, world.resolution_m,
                bodies.position, bodies.heading, bodies.alive,
                sensor.offsets, self._headings, sensor.range_m, noise, self.ranges,
            )  # fmt: skip
            return
        footing = stand(world, bodies.position, self._radius_m)
        scan_mesh(
            triangles, bodies.position, footing, self._height_m, bodies.heading, bodies.alive,
            sensor, self._headings, noise, self.ranges,
        )  # fmt: skip

    def _draw(self, step: int) -> None:
        block = step // BLOCK_STEPS
        if block == self._block:
            return
        self._block = block
        if self._noise_m > 0.0:
            stream(self._seed, "sensor", block).standard_normal(out=self._noise)
            self._noise *= self._noise_m
        if self._position_noise_m > 0.0 or self._heading_noise_ticks > 0:
            stream(self._seed, "pose", block).standard_normal(out=self._pose_noise)
            self._pose_noise[:, :, :2] *= self._position_noise_m
            self._pose_noise[:, :, 2] *= self._heading_noise_ticks
