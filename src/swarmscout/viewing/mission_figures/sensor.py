"""A figure of the range sensor: one robot's rays on the grid, or in the world as it is."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from swarmscout.core.errors import RunError
from swarmscout.core.grid import GridFrame
from swarmscout.core.scan import Scan
from swarmscout.mission.build import make_ground, make_sensing
from swarmscout.mission.scenario import Scenario
from swarmscout.robots.bodies import TICKS, place_bodies
from swarmscout.viewing.drawing import add_legend, show_image
from swarmscout.viewing.map_image import map_image
from swarmscout.viewing.palette import LIGHT
from swarmscout.viewing.replay import Replay

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

__all__ = ["Scans", "sensor_fan", "sensor_figure"]


class Scans:
    """The scans of a run, measured again: the same world, poses and noise as in the mission.

    Args:
        replay: the run.
    """

    def __init__(self, replay: Replay) -> None:
        self._replay = replay
        self._world = replay.run.world()
        self._ground = make_ground(self._world, replay.run.scenario)

    def at(self, step: int) -> tuple[Scan, NDArray[np.float64], NDArray[np.int64]]:
        """Scan, positions and headings of all robots in a step.

        Returns:
            The scan, float64[N, 2] in metres, int64[N] in ticks.

        Raises:
            RunError: the step is 0, in which robots do not measure, or does not exist.
        """
        if step < 1:
            raise RunError("robots do not measure in step 0: choose a later step")
        before = self._replay.moment(step - 1)  # A step senses first and moves last.
        heading = np.rint(before.heading_rad * TICKS / (2 * np.pi)).astype(np.int64) % TICKS
        run = self._replay.run
        bodies = place_bodies(
            before.place_m, heading, np.ones(len(heading)),
            seed=run.scenario.seed, radius_m=run.scenario.body.radius_m,
        )  # fmt: skip
        bodies.alive[:] = before.alive
        sensing = make_sensing(run.scenario, run.path, None, bodies, self._world, self._ground)
        return sensing.scan(bodies, step), before.place_m, heading


def sensor_fan(replay: Replay, step: int) -> Figure:
    """The rays of a robot beside a wall, as it measured them, and the map after that.

    Source: paper, Fig. 1a.

    Raises:
        RunError: the step is 0, in which robots do not measure.
    """
    scan, place, heading = Scans(replay).at(step)
    robot = _typical(scan.ranges) if replay.robot is None else replay.robot
    return sensor_figure(replay, step, robot, (scan, place[robot], int(heading[robot])))


def sensor_figure(
    replay: Replay,
    step: int,
    robot: int,
    scan: tuple[Scan, NDArray[np.float64], int],
    *,
    truth: bool = False,
) -> Figure:
    """One robot's scan.

    Args:
        replay: the run.
        step: of the scan.
        robot: the robot.
        scan: the scan, and its position and heading, see :meth:`Scans.at`.
        truth: show the world as it is, instead of the map.
    """
    from matplotlib.figure import Figure

    run, (measured, place, _) = replay.run, scan
    figure = Figure(figsize=(3.4, 3.6), layout="constrained")
    axes = figure.add_subplot()
    whose = "" if replay.robot is None else ", its own map"
    if truth:
        world = run.world()
        show_image(axes, world.frame, LIGHT.cells[np.where(world.free != 0, 1, 2)])
    else:
        labels = replay.moment(step).labels
        show_image(axes, run.frame, map_image(labels, run.scenario.map.frontier_neighbours))
        _draw_grid(axes, run.frame)
    reach = measured.max_range_m + 1.2 * run.frame.cell_m
    _draw_rays(axes, run.scenario, robot, scan)
    axes.set(
        xlim=(place[0] - reach, place[0] + reach), ylim=(place[1] - reach, place[1] + reach),
        xlabel="x (m)", ylabel="y (m)", title=f"robot {robot}, step {step}{whose}",
    )  # fmt: skip
    add_legend(figure, axes, 3, cells=False)
    return figure


def _draw_rays(
    axes: Axes, scenario: Scenario, robot: int, scan: tuple[Scan, NDArray[np.float64], int]
) -> None:
    from matplotlib.patches import Circle

    measured, (x, y), heading = scan
    ranges, radius_m = measured.ranges[robot], scenario.body.radius_m
    facing = heading * (2 * np.pi / TICKS)
    angles = facing + measured.directions * (2 * np.pi / TICKS)
    met = np.isfinite(ranges)
    far = np.where(met, ranges, measured.max_range_m)
    ends = (x, y) + far[:, None] * np.column_stack([np.cos(angles), np.sin(angles)])
    for end, hit in zip(ends, met, strict=True):
        axes.plot(
            (x, end[0]), (y, end[1]), color=LIGHT.selected, linewidth=1.0, zorder=3,
            linestyle="-" if hit else (0, (4, 2)),
        )  # fmt: skip
    axes.plot([], [], color=LIGHT.selected, linestyle=(0, (4, 2)), linewidth=1.0, label="no echo")
    axes.plot(
        *ends[met].T, "o", color=LIGHT.selected, markersize=3.2, zorder=4, label="measured wall"
    )
    axes.add_patch(Circle((x, y), radius_m, color=LIGHT.explore, zorder=5))
    axes.plot([], [], "o", color=LIGHT.explore, markersize=7, label="robot")
    nose = x + radius_m * np.cos(facing), y + radius_m * np.sin(facing)
    axes.plot((x, nose[0]), (y, nose[1]), color="white", zorder=6)


def _draw_grid(axes: Axes, frame: GridFrame) -> None:
    """The edges of the map's cells."""
    left, right, bottom, top = frame.extent
    style: dict[str, Any] = {"colors": "#7d7d7d", "linewidths": 0.4, "zorder": 1}
    axes.vlines(np.linspace(left, right, frame.columns + 1), bottom, top, **style)
    axes.hlines(np.linspace(bottom, top, frame.rows + 1), left, right, **style)


def _typical(ranges: NDArray[np.float64]) -> int:
    """The robot with echoes on about two thirds of its rays, far rather than near."""
    met = np.isfinite(ranges)
    share = met.mean(axis=1)
    mean_m = np.where(met, ranges, 0.0).sum(axis=1) / np.maximum(met.sum(axis=1), 1)
    return int((mean_m - 3.0 * np.abs(share - 0.67)).argmax())
