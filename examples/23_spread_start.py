"""Robots that start all over the world, instead of around the charging stations."""

import swarmscout as ss

STEPS = 200

for start in ("one-place", "spread"):
    run = ss.explore(robots=20, steps=STEPS, start=start, seed=2)
    first = run.steps.filter(run.steps["step"] == 0)
    spread_m = float(first["x_m"].max() - first["x_m"].min())
    print(f"{start:9} over {spread_m:5.1f} m: {run.summary['explored_m2']:6.1f} m²")
