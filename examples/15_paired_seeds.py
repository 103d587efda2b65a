"""A paired comparison: the same worlds, starts and noise for both selectors."""

import numpy as np
from scipy import stats

import swarmscout as ss

STEPS = 100
SEEDS = 6


def explored(selector, seed):
    """Explored area in a cave of its own for each seed."""
    run = ss.explore(
        "lava-tube-small", robots=10, steps=STEPS, destinations=selector, seed=seed,
        world_seed=seed, record="summary",
    )  # fmt: skip
    return run.summary["explored_m2"]


gain = np.array([explored("nearest", seed) - explored("quantile", seed) for seed in range(SEEDS)])
low, high = stats.t.interval(0.95, SEEDS - 1, gain.mean(), stats.sem(gain))
print(
    f"nearest explores {gain.mean():+.1f} m² more than quantile (95 %: {low:+.1f} to {high:+.1f})"
)
