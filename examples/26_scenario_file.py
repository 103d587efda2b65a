"""A scenario from a TOML file, with some keys changed."""

import tempfile
from pathlib import Path

import swarmscout as ss

STEPS = 100
TOML = """
world = "lava-tube-braided"
robots = 12
destinations = "nearest"

[teams]
desired_size = 3

[sensor]
range_m = 2.0
"""

with tempfile.TemporaryDirectory() as folder:
    file = Path(folder) / "mine.toml"
    file.write_text(TOML, encoding="utf-8")
    for size in (1, 3, 6):
        scenario = ss.load_scenario(file, {"teams.desired_size": size, "steps": STEPS})
        run = ss.record_mission(scenario, record="summary")
        print(f"team size {size}: {run.summary['explored_m2']:.1f} m²")
try:
    ss.load_scenario("paper", {"teams.desired_sise": 3})
except ss.ScenarioError as error:
    print(error)  # Errors name the key, and the nearest one that exists.
