"""A study: many missions from one file, with intervals; swarmscout study does it with a report."""

import tempfile
from pathlib import Path

import polars as pl

import swarmscout as ss
from swarmscout.studies.engines import LocalEngine
from swarmscout.studies.scheduler import run_study

STEPS = 60
STUDY = f"""
name = "team-size"
question = "Does a smaller team explore more?"
metric = "explored_m2"
trials = 2
compare = {{ axis = "teams.desired_size", baseline = 5 }}
scenario = {{ world = "lava-tube-small", robots = 8, steps = {STEPS} }}
axes = {{ "teams.desired_size" = [5, 2], world_seed = [0, 1] }}
"""

if __name__ == "__main__":  # Missions run in processes, which import this file.
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "study.toml"
        file.write_text(STUDY, encoding="utf-8")
        study = ss.Study.load(file, out=Path(folder) / "results")
        print(f"{run_study(study, LocalEngine(jobs=1))} missions were run")
        table = study.frame().group_by("teams.desired_size")
        print(table.agg(pl.col("explored_m2").mean(), pl.len()))
