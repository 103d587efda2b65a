"""A world reader of your own: a class with suffixes and one method, read(path, seed)."""

import tempfile
from pathlib import Path

import numpy as np

import swarmscout as ss
from swarmscout.testing import check_world_reader
from swarmscout.worlds import world_from_array

STEPS = 100


class CsvReader:
    """Comma-separated cells of 0.1 m: 1 is a wall, 0 is free; the first line is the lowest."""

    suffixes = (".csv",)

    def read(self, path, seed):
        occupied = np.loadtxt(path, delimiter=",", dtype=int)
        return world_from_array(occupied == 0, resolution_m=0.1, name=path.stem)


plan = np.ones((80, 120), dtype=int)
plan[5:75, 5:55] = plan[5:75, 60:115] = plan[30:45, 55:60] = 0  # Two rooms and a door.
with tempfile.TemporaryDirectory() as folder:
    file = Path(folder) / "plan.csv"
    np.savetxt(file, plan, fmt="%d", delimiter=",")
    check_world_reader(CsvReader, [file])
    world = CsvReader().read(file, seed=0)
run = ss.explore(world, robots=4, steps=STEPS)
print(f"{run.summary['explored_fraction']:.0%} of what can be reached is explored")
