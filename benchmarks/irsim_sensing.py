"""The comparable part of IR-SIM: robots that drive and sense with nine short rays in a map."""

from __future__ import annotations

import contextlib
import importlib.util
import io
import os
import tempfile
from pathlib import Path
from time import process_time

import numpy as np
from PIL import Image

WORLD = """
world:
  height: 20
  width: 20
  step_time: 1.0
  sample_time: 1.0
  collision_mode: 'stop'
  obstacle_map: {image}
  mdownsample: 1
robot:
  - number: {robots}
    distribution: {{name: 'random', range_low: [4, 4, -3.14], range_high: [16, 16, 3.14]}}
    kinematics: {{name: 'diff'}}
    shape: {{name: 'circle', radius: 0.15}}
    vel_min: [0, -1]
    vel_max: [0.2, 0.7]
    sensors:
      - {{type: 'lidar2d', range_min: 0, range_max: 1, angle_range: 2.4435, number: 9,
         noise: True, std: 0.02}}
"""


def irsim_sensing_seconds(robots: int, steps: int, repeats: int) -> tuple[str, float] | None:
    """Time IR-SIM.

    Args:
        robots: how many drive and sense.
        steps: how many steps are timed, after one that is not.
        repeats: of the whole; the least counts.

    Returns:
        Its name with version, and CPU seconds; None where it is not installed.
    """
    if importlib.util.find_spec("irsim") is None:
        return None
    os.environ.setdefault("MPLBACKEND", "Agg")
    with contextlib.redirect_stdout(io.StringIO()):
        import irsim

        best = min(_once(irsim, robots, steps) for _ in range(max(1, repeats // 2)))
    return f"IR-SIM {irsim.__version__}", best


def _once(irsim: object, robots: int, steps: int) -> float:
    with tempfile.TemporaryDirectory() as folder:
        room = np.zeros((200, 200), dtype=np.uint8)
        room[20:180, 20:180] = 255
        image = Path(folder) / "room.png"
        Image.fromarray(room).save(image)
        world = Path(folder) / "world.yaml"
        world.write_text(WORLD.format(image=image, robots=robots), encoding="utf-8")
        environment = irsim.make(
            str(world), display=False, log_level="CRITICAL", disable_all_plot=True
        )
        forward = [np.array([[0.2], [0.0]])] * robots
        environment.step(forward)
        started = process_time()
        for _ in range(steps):
            environment.step(forward)
        return process_time() - started
