"""Fig. 1: the ray sensor, and the grid map that it makes."""

from __future__ import annotations

import math

import numpy as np
from matplotlib.figure import Figure
from matplotlib.patches import Circle

from swarmscout.mission.mission import Mission
from swarmscout.mission.scenario_files import load_scenario
from swarmscout.reproduction.drawing import draw_probabilities, draw_robots, known_window
from swarmscout.reproduction.options import Options, run_mission
from swarmscout.robots.bodies import TICKS
from swarmscout.studies.report_elements import Block, Picture, Text

__all__ = ["gridmap", "sensor"]


def sensor(options: Options) -> list[Block]:
    """Fig. 1a: nine rays over 70° to both sides, 1 m long, where a robot stands in the mission."""
    scenario = load_scenario(
        "paper", {"robots": 15, "world": "lava-maze", "start": "spread", "destinations": "nearest"}
    )
    mission = Mission(scenario)
    best, pose, ranges = -1.0, None, None
    # The moment at which rays meet walls farthest off, so that the figure has something to show.
    for _ in range(20 if options.quick else 120):
        before = mission.bodies.pose.copy()
        mission.step()
        scan = mission.sensing.last
        met = np.isfinite(scan.ranges)
        reached = np.where(met, scan.ranges, 0.0).sum(axis=1)
        reached[met.sum(axis=1) > met.shape[1] - 2] = 0.0  # Free rays are to be seen, too.
        robot = int(reached.argmax())
        if reached[robot] > best:
            best, pose = float(reached[robot]), before[robot]
            ranges = scan.ranges[robot]
    assert pose is not None
    assert ranges is not None
    figure = Figure(figsize=(4.6, 4.6), layout="constrained")
    axes = figure.add_subplot()
    world = mission.world
    axes.imshow(
        world.free, origin="lower", extent=world.extent, cmap="gray", vmin=-0.6, vmax=1.0,
        interpolation="nearest",
    )  # fmt: skip
    x, y, heading = pose
    for tick, measured in zip(scan.directions.tolist(), ranges, strict=True):
        angle = 2.0 * math.pi * tick / TICKS
        length = measured if math.isfinite(measured) else scan.max_range_m
        end = x + length * math.cos(heading + angle), y + length * math.sin(heading + angle)
        colour = "#d55e00" if math.isfinite(measured) else "#0072b2"
        axes.plot([x, end[0]], [y, end[1]], color=colour, linewidth=1.3)
        if math.isfinite(measured):
            axes.plot(*end, marker="o", markersize=5, color=colour)
    radius = scenario.body.radius_m
    axes.add_patch(Circle((x, y), radius, color="#e3211c", zorder=4))
    axes.plot(
        [x, x + radius * math.cos(heading)], [y, y + radius * math.sin(heading)], color="white",
        zorder=5,
    )  # fmt: skip
    axes.set(xlim=(x - 1.5, x + 1.5), ylim=(y - 1.5, y + 1.5), xlabel="x (m)", ylabel="y (m)")
    return [
        Text(
            f"**The paper:** a robot of 0.3 m with nine rays, 70° to the left and right, at most "
            f"1 m long. **Here:** {len(ranges)} rays over "
            f"±{360.0 * scan.directions.max() / TICKS:g}°, {scan.max_range_m:g} m, "
            f"a robot of {2 * radius:g} m; one scan of a mission in "
            f"`{world.name}` (seed {scenario.seed}), in which "
            f"{int(np.isfinite(ranges).sum())} rays met a wall."
        ),
        Picture(
            "sensor", figure,
            "The ray sensor: orange rays met the wall (dark), with measured ranges as dots; blue "
            "ones met nothing within range.",
        ),
    ]  # fmt: skip


def gridmap(options: Options) -> list[Block]:
    """Fig. 1b: occupancy probabilities in grayscale, frontiers in green, as the map grows."""
    steps = (5, 15, 30) if options.quick else (10, 40, 100)
    keys = {"robots": 5, "steps": steps[-1], "world": "lava-maze", "destinations": "nearest"}
    run = run_mission(options, "run", keys)
    window = known_window(run, steps[-1])
    figure = Figure(figsize=(9.6, 3.6), layout="constrained")
    for at, step in enumerate(steps):
        axes = figure.add_subplot(1, 3, at + 1)
        draw_probabilities(axes, run, step, window)
        draw_robots(axes, run, step)
        axes.set_title(f"step {step}", fontsize="small")
    grid = run.scenario.map
    return [
        Text(
            "**The paper:** cells of 0.5 m hold the probability of an obstacle, by additive "
            f"updates of log-odds. **Here:** cells of {grid.cell_m:g} m; a passing ray adds the "
            f"log-odds of {grid.p_free:g}, a hit those of {grid.p_occupied:g}; read within "
            f"[{grid.p_min:g}, {grid.p_max:g}]."
        ),
        Picture(
            "gridmap", figure,
            f"The occupancy grid of {run.scenario.robots} robots after {steps[0]}, {steps[1]} and "
            f"{steps[2]} steps: gray is unexplored, white free, black an obstacle, green a "
            "frontier; red dots are robots, purple rings destinations.",
        ),
    ]  # fmt: skip
