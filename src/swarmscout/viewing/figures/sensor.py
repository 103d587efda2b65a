"""A figure of the range sensor: one robot's rays on the grid."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from swarmscout.core.errors import RunError
from swarmscout.core.scan import Scan
from swarmscout.mission.build import make_ground, make_sensing
from swarmscout.robots.bodies import TICKS, place_bodies
from swarmscout.viewing.figures.style import EXPLORE, MAP_COLOURS
from swarmscout.viewing.replay import Replay

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["sensor_fan"]


def sensor_fan(replay: Replay, step: int) -> Figure:
    """The rays of a robot beside a wall, as it measured them, and the map after that.

    Source: paper, Fig. 1a. Rays are those of the mission: the same world, pose and noise.

    Raises:
        RunError: the step is 0, in which nobody measures.
    """
    from matplotlib.colors import ListedColormap
    from matplotlib.figure import Figure
    from matplotlib.patches import Circle

    if step < 1:
        raise RunError("nobody measures in step 0: ask for a later step")
    scan, place, heading = _scan(replay, step)
    ranges = scan.ranges
    scenario = replay.run.scenario
    robot = _telling(ranges) if replay.robot is None else replay.robot
    radius_m = scenario.body.radius_m
    facing = heading[robot] * (2 * np.pi / TICKS)
    angles = facing + scan.directions * (2 * np.pi / TICKS)
    far = np.where(np.isfinite(ranges[robot]), ranges[robot], scan.max_range_m)
    ends = place[robot] + far[:, None] * np.column_stack([np.cos(angles), np.sin(angles)])

    frame = replay.run.frame
    labels = replay.moment(step).labels
    whose = "" if replay.robot is None else ", its own map"
    figure = Figure(figsize=(3.4, 3.6), layout="constrained")
    axes = figure.add_subplot(facecolor=MAP_COLOURS[0])
    axes.imshow(
        labels, origin="lower", extent=frame.extent, interpolation="nearest", vmin=0, vmax=3,
        cmap=ListedColormap(MAP_COLOURS),
    )  # fmt: skip
    reach = scan.max_range_m + 1.2 * frame.cell_m
    x, y = place[robot]
    for edges, draw in (
        (_edges(frame.origin_x_m, frame.cell_m, x, reach), axes.axvline),
        (_edges(frame.origin_y_m, frame.cell_m, y, reach), axes.axhline),
    ):
        for edge in edges:
            draw(edge, color="#7d7d7d", linewidth=0.4, zorder=1)
    for end, hit in zip(ends, np.isfinite(ranges[robot]), strict=True):
        axes.plot(
            (x, end[0]), (y, end[1]), color="#0072b2", linewidth=1.0, zorder=3,
            linestyle="-" if hit else (0, (4, 2)),
        )  # fmt: skip
    hits = ends[np.isfinite(ranges[robot])]
    axes.plot([], [], color="#0072b2", linestyle=(0, (4, 2)), linewidth=1.0, label="met nothing")
    axes.plot(*hits.T, "o", color="#0072b2", markersize=3.2, zorder=4, label="measured wall")
    axes.add_patch(Circle((x, y), radius_m, color=EXPLORE, zorder=5))
    axes.plot([], [], "o", color=EXPLORE, markersize=7, label="robot")
    ahead = np.array([np.cos(facing), np.sin(facing)])
    axes.plot(*zip((x, y), (x, y) + radius_m * ahead, strict=True), color="white", zorder=6)
    axes.set(
        xlim=(x - reach, x + reach), ylim=(y - reach, y + reach), aspect="equal",
        xlabel="x (m)", ylabel="y (m)", title=f"robot {robot}, step {step}{whose}",
    )  # fmt: skip
    figure.legend(loc="outside lower center", ncols=3, handletextpad=0.5)
    return figure


def _telling(ranges: NDArray[np.float64]) -> int:
    """The robot of which about two thirds of the rays meet something, far away rather than near."""
    met = np.isfinite(ranges)
    share = met.mean(axis=1)
    mean_m = np.where(met, ranges, 0.0).sum(axis=1) / np.maximum(met.sum(axis=1), 1)
    return int((mean_m - 3.0 * np.abs(share - 0.67)).argmax())


def _scan(replay: Replay, step: int) -> tuple[Scan, NDArray[np.float64], NDArray[np.int64]]:
    """The scan of a step, and where and how robots stood then."""
    run = replay.run
    before = replay.moment(step - 1)  # A step senses first and moves last.
    heading = np.rint(before.heading_rad * TICKS / (2 * np.pi)).astype(np.int64) % TICKS
    scenario = run.scenario
    bodies = place_bodies(
        before.place_m, heading, np.ones(len(heading)),
        seed=scenario.seed, radius_m=scenario.body.radius_m,
    )  # fmt: skip
    bodies.alive[:] = before.alive
    world = run.world()
    ground = make_ground(world, scenario)
    sensing = make_sensing(scenario, run.path, None, bodies, world, ground)
    return sensing.scan(bodies, step), before.place_m, heading


def _edges(origin: float, cell_m: float, middle: float, reach: float) -> NDArray[np.float64]:
    first = np.ceil((middle - reach - origin) / cell_m)
    last = np.floor((middle + reach - origin) / cell_m)
    return np.asarray(origin + cell_m * np.arange(first, last + 1), dtype=np.float64)
