"""What the tube in 3D costs, and how well it agrees with its 2.5-D world: a table in Markdown.

    python benchmarks/tube_mesh.py [--resolution 0.2] [--seed 0] [--only lava-maze]

Needs ``pip install 'swarmscout[mesh,bench]'`` (embreex casts the rays). Each world has a process of
its own, so that its memory is its own. CPU time is that of ``tube_mesh`` alone, memory the process'
highest. Heights are compared by vertical rays in every twentieth free cell.
"""

from __future__ import annotations

import argparse
import multiprocessing
import resource
import tempfile
from dataclasses import replace
from pathlib import Path
from time import process_time

import numpy as np

from swarmscout.worlds import generate_tube, named_worlds, tube_mesh, write_mesh
from swarmscout.worlds.catalogue import NAMED_TUBES

EVERY = 20


def row(name: str, seed: int, resolution_m: float) -> str:
    """One line of the table."""
    parameters = replace(NAMED_TUBES[name][1], seed=seed)
    world = generate_tube(parameters)
    began = process_time()
    mesh = tube_mesh(parameters, mesh_resolution_m=resolution_m)
    seconds = process_time() - began
    memory_mb = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e3
    with tempfile.TemporaryDirectory() as folder:
        size_mb = write_mesh(mesh, Path(folder) / "cave.ply").stat().st_size / 1e6
    floor, ceiling = heights_off(world, mesh)
    free_m2 = float(np.count_nonzero(world.free)) * world.resolution_m**2
    return (
        f"| `{name}` | {free_m2:,.0f} | {seconds:.1f} | {memory_mb:.0f} | {len(mesh.triangles):,} "
        f"| {size_mb:.1f} | {np.mean(np.abs(floor) <= 0.05):.3f} "
        f"| {np.mean(np.abs(ceiling) <= 0.1):.3f} |"
    )


def heights_off(world, mesh) -> tuple[np.ndarray, np.ndarray]:
    """By how many metres the mesh's floor and ceiling differ from the world's, in free cells."""
    import trimesh
    from trimesh.ray.ray_pyembree import RayMeshIntersector

    caster = RayMeshIntersector(trimesh.Trimesh(mesh.vertices_m, mesh.triangles, process=False))
    rows, columns = (part[::EVERY] for part in np.nonzero(world.free))
    ground, ceiling = world.ground_m[rows, columns], world.ceiling_m[rows, columns]
    eyes = np.column_stack(
        (
            (columns + 0.5) * world.resolution_m,
            (rows + 0.5) * world.resolution_m,
            ground + 0.3 * (ceiling - ground),
        )
    )
    found = []
    for way, heights in ((-1.0, ground), (1.0, ceiling)):
        ways = np.tile((0.0, 0.0, way), (len(eyes), 1))
        places, ray, _ = caster.intersects_location(eyes, ways, multiple_hits=False)
        off = np.full(len(eyes), np.inf)
        off[ray] = places[:, 2] - heights[ray]
        found.append(off)
    return found[0], found[1]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--resolution", type=float, default=0.2)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--only", nargs="*", default=list(named_worlds()))
    given = parser.parse_args()
    print("| world | free m² | CPU s | memory MB | triangles | PLY MB | floor | ceiling |")
    print("|---|---|---|---|---|---|---|---|")
    context = multiprocessing.get_context("spawn")
    for name in given.only:
        with context.Pool(1) as pool:
            print(pool.apply(row, (name, given.seed, given.resolution)), flush=True)


if __name__ == "__main__":
    main()
