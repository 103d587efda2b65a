"""Generate a lava tube from parameters, draw it, and keep it in a folder."""

import dataclasses
import tempfile
from pathlib import Path

import swarmscout as ss
from swarmscout.viewing.world_picture import world_picture
from swarmscout.worlds import TubeParameters, generate_tube, save_world

STEPS = 100

parameters = TubeParameters(seed=7, length_m=60, width_m=6, braids=1, branches=2)
with tempfile.TemporaryDirectory() as folder:
    for seed in (7, 8):
        world = generate_tube(dataclasses.replace(parameters, seed=seed), f"tube-{seed}")
        kept = Path(folder) / world.name
        save_world(world, kept)
        print(f"{kept.name}: {world_picture(world, kept / 'world.png').stat().st_size} bytes")
        run = ss.explore(kept, robots=5, steps=STEPS)
        print(f"{run.summary['explored_m2']:.0f} of {run.summary['reachable_m2']:.0f} m²")
