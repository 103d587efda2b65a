"""Export a run's tables as CSV, for a spreadsheet or R."""

import tempfile
from pathlib import Path

import polars as pl

import swarmscout as ss

STEPS = 100

run = ss.explore(robots=6, steps=STEPS)
with tempfile.TemporaryDirectory() as folder:
    for name in ("coverage", "steps", "decisions", "events"):
        file = Path(folder) / f"{name}.csv"
        run.table(name).write_csv(file)
        print(f"{file.name}: {pl.read_csv(file).height} rows, {file.stat().st_size} bytes")
