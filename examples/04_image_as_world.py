"""An image as a world: white is free, black is wall; the scale is yours."""

import tempfile
from pathlib import Path

from PIL import Image, ImageDraw

import swarmscout as ss
from swarmscout.worlds import load_world

STEPS = 150

with tempfile.TemporaryDirectory() as folder:
    file = Path(folder) / "plan.png"
    plan = Image.new("L", (240, 160), 0)
    draw = ImageDraw.Draw(plan)
    draw.rectangle((10, 10, 110, 150), fill=255)
    draw.rectangle((130, 10, 230, 150), fill=255)
    draw.rectangle((100, 70, 140, 95), fill=255)  # The passage between them.
    plan.save(file)
    world = load_world(file, cell_m=0.1, start_m=(3.0, 8.0))
    run = ss.explore(world, robots=8, steps=STEPS)

left, right, bottom, top = world.extent
print(f"{right - left:.0f} m x {top - bottom:.0f} m, {run.summary['explored_m2']:.0f} m² explored")
