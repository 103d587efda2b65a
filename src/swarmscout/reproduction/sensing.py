"""Fig. 1: the ray sensor, and the occupancy grid that it makes."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

from swarmscout.reproduction.options import Options, run_mission
from swarmscout.robots.bodies import TICKS
from swarmscout.studies.report_elements import Block, Picture, Text
from swarmscout.viewing.drawing import add_legend, draw_swarm, show_image
from swarmscout.viewing.map_image import frontier_cells
from swarmscout.viewing.mission_figures.sensor import Scans, sensor_figure
from swarmscout.viewing.palette import LIGHT, rgb
from swarmscout.viewing.replay import Replay

__all__ = ["gridmap", "sensor"]


def sensor(options: Options) -> list[Block]:
    """Fig. 1a: nine rays over 70° to both sides, 1 m long, at a robot's place in the mission."""
    steps = 20 if options.quick else 120
    keys = {"world": "lava-maze", "start": "spread", "destinations": "nearest"}
    run = run_mission(options, "run", {"robots": 15, "steps": steps, **keys})
    replay, scenario = Replay(run), run.scenario
    scans = Scans(replay)
    best, shown = -1.0, None
    # The scan whose rays meet walls farthest off, with free rays among them.
    for step in range(1, steps + 1):
        scan, place, heading = scans.at(step)
        ranges = scan.ranges
        met = np.isfinite(ranges)
        reached = np.where(met, ranges, 0.0).sum(axis=1)
        reached[met.sum(axis=1) > met.shape[1] - 2] = 0.0
        robot = int(reached.argmax())
        if reached[robot] > best:
            best = float(reached[robot])
            shown = step, robot, (scan, place[robot], int(heading[robot]))
    assert shown is not None
    figure = sensor_figure(replay, *shown, truth=True)
    scan = shown[2][0]
    ranges = scan.ranges[shown[1]]
    return [
        Text(
            f"**The paper:** a robot of 0.3 m with nine rays, 70° to the left and right, at most "
            f"1 m long. **Here:** {len(ranges)} rays over "
            f"±{360.0 * scan.directions.max() / TICKS:g}°, {scan.max_range_m:g} m, a robot of "
            f"{2 * scenario.body.radius_m:g} m; one scan of a mission in "
            f"`{run.world().name}` (seed {scenario.seed}), in which "
            f"{int(np.isfinite(ranges).sum())} rays met a wall."
        ),
        Picture(
            "sensor", figure,
            "The ray sensor: solid rays met the wall (black), with measured ranges as dots; dashed "
            "ones met nothing within range.",
        ),
    ]  # fmt: skip


def gridmap(options: Options) -> list[Block]:
    """Fig. 1b: occupancy probabilities in grayscale, frontiers in green, as the map grows."""
    steps = (5, 15, 30) if options.quick else (10, 40, 100)
    keys = {"robots": 5, "steps": steps[-1], "world": "lava-maze", "destinations": "nearest"}
    run = run_mission(options, "run", keys)
    replay = Replay(run)
    figure = Figure(figsize=(9.6, 3.6), layout="constrained")
    for at, step in enumerate(steps):
        axes = figure.add_subplot(1, 3, at + 1)
        moment = replay.moment(step)
        free = 1.0 / (1.0 + np.exp(run.map_at(step) / 1000.0))
        image = np.repeat(free[:, :, None], 3, axis=2)
        edge = frontier_cells(moment.labels, run.scenario.map.frontier_neighbours)
        image[edge] = np.array(rgb(LIGHT.frontier)) / 255.0 * (0.5 + 0.5 * free[edge][:, None])
        show_image(axes, run.frame, image, replay.window())
        draw_swarm(axes, moment, run.stations_m, size=4.0, teams=False)
        axes.set_title(f"step {step}", fontsize="small")
    add_legend(figure, axes, 5, cells=False)
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
