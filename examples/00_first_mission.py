"""Run a mission and print what came of it."""

import swarmscout as ss

STEPS = 300

run = ss.explore(world="lava-tube", robots=15, steps=STEPS, seed=0)

print(f"explored {run.summary['explored_m2']:.0f} m² of {run.summary['reachable_m2']:.0f} m²")
print(f"team sizes at the end: {run.summary['teams']}")
print(run.coverage.select("step", "explored_m2").tail(3))
