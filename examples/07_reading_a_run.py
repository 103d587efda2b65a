"""Record a mission into a folder, open it again, and query its tables (Polars)."""

import tempfile

import polars as pl

import swarmscout as ss

STEPS = 200

with tempfile.TemporaryDirectory() as folder:
    ss.explore(robots=10, steps=STEPS, seed=1, out=folder)
    run = ss.Run.open(folder)  # Works for missions that were killed, too.

    print(run.coverage.columns)
    print(run.steps.filter(pl.col("robot") == 0).tail(2))
    by_cause = run.decisions.group_by("cause").agg(pl.len(), pl.col("distance_m").mean())
    print(by_cause.sort("len", descending=True))
    print(run.events.group_by("kind").len())
