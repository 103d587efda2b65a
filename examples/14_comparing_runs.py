"""Compare runs by their summaries, in one table."""

import polars as pl

import swarmscout as ss

STEPS = 150
COLUMNS = ["selector", "explored_m2", "explored_fraction", "overlap_ratio", "joins", "charges"]

runs = [
    ss.explore(robots=12, steps=STEPS, destinations=name, record="summary")
    for name in ("multi-criteria", "hungarian", "minpos", "quantile", "random")
]
table = pl.DataFrame([{key: run.summary[key] for key in COLUMNS} for run in runs])
print(table.sort("explored_m2", descending=True))
