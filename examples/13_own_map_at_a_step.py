"""What one robot knew at a step, compared with what all robots together knew."""

import numpy as np

import swarmscout as ss

STEPS = 90
ROBOTS = 6

alone = np.zeros((ROBOTS, ROBOTS), dtype=bool)  # No robot hears another.
run = ss.explore("lava-tube-small", robots=ROBOTS, steps=STEPS, links=lambda step: alone)

for step in (STEPS // 3, 2 * STEPS // 3, STEPS):
    together = np.count_nonzero(run.map_at(step))
    own = [np.count_nonzero(run.map_at(step, robot=robot)) for robot in range(ROBOTS)]
    print(f"step {step:3}: {together} cells known in all, by each robot {own}")

log_odds = run.map_at(STEPS, robot=0)  # int32[rows, cols], in 1/1000 nat; above 0 is occupied.
cells = np.argwhere(log_odds < 0)  # (row, col) of the free ones.
left, low = run.frame.centres_of(cells).min(axis=0)
right, high = run.frame.centres_of(cells).max(axis=0)
print(f"robot 0 found {len(cells)} free cells within {right - left:.1f} m x {high - low:.1f} m")
