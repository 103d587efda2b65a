"""A world of your own from an array: True where a robot can be, row 0 is the lowest."""

import numpy as np

import swarmscout as ss
from swarmscout.worlds import check_world, world_from_array

STEPS = 150

free = np.ones((150, 250), dtype=bool)  # 15 m x 25 m, in cells of 0.1 m.
free[[0, -1], :] = free[:, [0, -1]] = False  # Walls around it,
free[:, 120:123] = False  # a wall in the middle,
free[60:80, 120:123] = True  # and a door of 2 m in that wall.

world = world_from_array(
    free,
    resolution_m=0.1,
    name="two-rooms",
    start_m=(3.0, 3.0),
    stations_m=[(2.0, 2.0), (4.0, 2.0)],
)
check_world(world, robots=6)
run = ss.explore(world, robots=6, steps=STEPS)
print(f"{run.summary['explored_fraction']:.0%} of what can be reached is explored")
