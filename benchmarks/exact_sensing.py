"""Exact sensing beside the raster and beside Embree: the section of docs/performance.md.

python benchmarks/exact_sensing.py [WORLD_FOLDER …] [--repeats 20]

measures in the generated worlds `lava-tube` and `lava-maze`, and in worlds that
`swarmscout worlds import` made of meshes. Embree comes with pip install 'swarmscout[bench]'.
"""

from __future__ import annotations

import argparse
import dataclasses
import platform
from collections.abc import Callable
from importlib.metadata import version
from pathlib import Path
from time import process_time

import numpy as np
from pages import write_section

import swarmscout
from swarmscout import Mission, Scenario, World, load_world
from swarmscout.robots.bodies import TICKS, heading_table, place_bodies
from swarmscout.robots.sensors.agreement import sensing_agreement
from swarmscout.robots.sensors.fan import Fan
from swarmscout.studies.report_elements import Block, Heading, Table, Text
from swarmscout.worlds.catalogue import NAMED_TUBES
from swarmscout.worlds.ground_plane import stand
from swarmscout.worlds.meshes.tube_mesh import tube_mesh
from swarmscout.worlds.reachability import standing_places

ROBOTS = 1000
HEIGHT_M, RADIUS_M, RANGE_M = 0.2, 0.15, 1.0


def least_us(work: Callable[[], object], repeats: int) -> float:
    """Least CPU time of a number of calls, in µs a robot; the first call compiles."""
    work()
    times = []
    for _ in range(repeats):
        started = process_time()
        work()
        times.append(process_time() - started)
    return 1e6 * min(times) / ROBOTS


class Scan:
    """One scan of a thousand robots at random places of a world, by three ways to cast rays."""

    def __init__(self, world: World) -> None:
        rng = np.random.default_rng(0)
        cells = np.argwhere(standing_places(world, RADIUS_M))
        self.world = world
        position = world.frame.centres_of(cells[rng.integers(len(cells), size=ROBOTS)])
        heading = rng.integers(0, TICKS, ROBOTS)
        self.bodies = place_bodies(position, heading, np.ones(ROBOTS), radius_m=RADIUS_M)
        self.footing = stand(world, position, RADIUS_M)
        keys = {"noise_m": 0.0, "range_m": RANGE_M, "height_m": HEIGHT_M}
        self.raster, self.exact = Fan(**keys), Fan(sensing="mesh", **keys)
        assert world.mesh is not None
        self.mesh = world.mesh

    def on_raster(self) -> None:
        """Rays against the raster."""
        self.raster.scan(self.bodies, self.world, 1)

    def on_mesh(self) -> None:
        """Rays against the mesh, with the footing that a step works out."""
        self.exact.scan(self.bodies, self.world, 1)

    def by_embree(self) -> Callable[[], np.ndarray]:
        """The same rays by Embree: what casts them, and returns ranges."""
        from embreex.mesh_construction import TriangleMesh
        from embreex.rtcore_scene import EmbreeScene

        scene = EmbreeScene()
        TriangleMesh(scene, self.mesh.vertices_m[self.mesh.triangles])
        directions = self.exact.scan(self.bodies, self.world, 1).directions
        level = heading_table()[(self.bodies.heading[:, None] + directions) % TICKS]
        rise = (level * self.footing[:, None, 1:]).sum(axis=2, keepdims=True)
        ways = np.concatenate([level, rise], axis=2).reshape(-1, 3).astype(np.float32)
        starts = np.column_stack([self.bodies.position, self.footing[:, 0] + HEIGHT_M])
        origins = np.repeat(starts, 9, axis=0).astype(np.float32)

        def cast() -> np.ndarray:
            longest = np.full(len(ways), RANGE_M, dtype=np.float32)  # Overwritten.
            return scene.run(origins, ways, dists=longest, query="DISTANCE")

        return cast


def step_ms(world: World, robots: int, sensing: str) -> float:
    """CPU time of a mission's step, in ms, over 200 steps."""
    sensor = {"sensing": sensing, "range_m": RANGE_M}
    keys = {"robots": robots, "steps": 200, "destinations": "multi-criteria", "sensor": sensor}
    mission = Mission(Scenario.model_validate(keys), world=world)
    started = process_time()
    mission.run()
    return 1e3 * (process_time() - started) / mission.step_number


def measured(world: World, repeats: int) -> list[str]:
    """A row of the table."""
    scan = Scan(world)
    raster, mesh = least_us(scan.on_raster, repeats), least_us(scan.on_mesh, repeats)
    cast = scan.by_embree()
    embree = least_us(cast, repeats)
    theirs, ours = cast().reshape(-1, 9), scan.ranges
    met = theirs < RANGE_M
    same = met == np.isfinite(ours)
    both = met & np.isfinite(ours)
    apart_mm = 1e3 * float(np.abs(theirs[both] - ours[both]).max()) if both.any() else 0.0
    agreement = sensing_agreement(world)
    step_ms(world, 100, "mesh")
    steps = [step_ms(world, 100, sensing) for sensing in ("raster", "mesh")]
    return [
        f"`{world.name}`", f"{len(scan.mesh.triangles):,}",
        f"{agreement.hits:.3f}", f"{agreement.alike:.3f}", f"{agreement.walls_alike:.3f}",
        f"{raster:.2f}", f"{mesh:.2f}", f"{embree:.2f}", f"{100 * same.mean():.2f} %",
        f"{apart_mm:.2f}", f"{steps[0]:.2f}", f"{steps[1]:.2f}",
    ]  # fmt: skip


def main() -> None:
    """Measure, and write the section."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("worlds", nargs="*", type=Path)
    parser.add_argument("--repeats", type=int, default=20)
    arguments = parser.parse_args()
    worlds = [
        dataclasses.replace(load_world(name), mesh=tube_mesh(NAMED_TUBES[name][1]))
        for name in ("lava-tube", "lava-maze")
    ]
    worlds += [load_world(folder) for folder in arguments.worlds]
    blocks: list[Block] = [
        Heading("Exact sensing", 3),
        Text(
            f"CPU time of one scan (nine rays of {RANGE_M:g} m) of {ROBOTS} robots at random "
            f"places, in µs a robot, least of {arguments.repeats}: against the raster, against the "
            f"mesh, and by Embree (embreex {version('embreex')}) with the same rays; then how many "
            "rays hit or miss as by Embree and how far ranges lie apart at most; and CPU time of a "
            f"mission's step with 100 robots. swarmscout {swarmscout.__version__}, "
            f"{platform.machine()}."
        ),
        Table(
            ["world", "triangles", "hit or not", "within 0.1 m", "… of walls", "raster µs",
             "mesh µs", "Embree µs", "as Embree", "mm apart", "raster ms/step", "mesh ms/step"],
            [measured(world, arguments.repeats) for world in worlds],
        ),
    ]  # fmt: skip
    write_section(Path("docs/performance.md"), "exact sensing", blocks)


if __name__ == "__main__":
    main()
