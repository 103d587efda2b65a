"""Draw a mission: the final map, and figures for print."""

import tempfile
from pathlib import Path

import swarmscout as ss
from swarmscout.viewing.mission_figures.catalogue import MISSION_FIGURES, make_figures

STEPS = 150

run = ss.explore("lava-tube-small", robots=10, steps=STEPS)
print(f"figures: {', '.join(MISSION_FIGURES)}")
with tempfile.TemporaryDirectory() as folder:
    print(ss.map_picture(run, Path(folder) / "map.png").name)
    for file in make_figures(run, folder, names=["team-map", "explored-area"], form="pdf"):
        print(f"{file.name}: {file.stat().st_size} bytes")
