"""Drawing maps and swarms in the paper's colours: several moments in one figure."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
import polars as pl
from matplotlib.patches import Circle
from numpy.typing import NDArray

from swarmscout.core.enums import UNKNOWN
from swarmscout.recording.run import Run
from swarmscout.viewing.map_picture import (
    CHARGE_GREEN,
    DESTINATION_PURPLE,
    EXPLORE_RED,
    FREE_WHITE,
    FRONTIER_GREEN,
    OCCUPIED_BLACK,
    UNKNOWN_GRAY,
    frontier_cells,
    labels_at,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes

__all__ = ["draw_map", "draw_probabilities", "draw_robots", "known_window", "robots_at"]

Window = tuple[float, float, float, float]


def robots_at(run: Run, step: int) -> dict[str, NDArray[Any]]:
    """Columns of the table ``steps`` at a step."""
    rows = run.steps.filter(pl.col("step") == step)
    return {name: rows[name].to_numpy() for name in rows.columns}


def known_window(run: Run, step: int, margin_m: float = 2.0) -> Window:
    """What is known after a step, with a margin: left, right, bottom, top in metres."""
    known = np.argwhere(labels_at(run, step) != UNKNOWN)
    if not len(known):
        return run.frame.extent
    points = np.concatenate([run.frame.centres_of(known), run.stations_m])
    (left, bottom), (right, top) = points.min(axis=0) - margin_m, points.max(axis=0) + margin_m
    return float(left), float(right), float(bottom), float(top)


def draw_map(axes: Axes, run: Run, step: int, window: Window) -> None:
    """Gray unknown, white free, black occupied, green frontiers (the paper's colours)."""
    labels = labels_at(run, step)
    picture = np.array([UNKNOWN_GRAY, FREE_WHITE, OCCUPIED_BLACK])[labels]
    picture[frontier_cells(labels, run.scenario.map.frontier_neighbours)] = FRONTIER_GREEN
    _show(axes, run, picture, window)


def draw_probabilities(axes: Axes, run: Run, step: int, window: Window) -> None:
    """Occupancy probabilities in grayscale, frontiers in green, as in the paper's Fig. 1."""
    free = 1.0 / (1.0 + np.exp(run.map_at(step) / 1000.0))
    picture = np.repeat(free[:, :, None], 3, axis=2)
    frontier = frontier_cells(labels_at(run, step), run.scenario.map.frontier_neighbours)
    picture[frontier] = np.array(FRONTIER_GREEN) * (0.5 + 0.5 * free[frontier][:, None])
    _show(axes, run, picture, window)


def draw_robots(
    axes: Axes,
    run: Run,
    step: int,
    *,
    teams: bool = False,
    destinations: bool = True,
    size: float | None = None,
) -> None:
    """Robots as red dots (green in CHR mode), stations, destinations, and circles round teams.

    Args:
        axes: where to.
        run: recorded in full.
        step: after which step.
        teams: draw a red circle round each team of two or more.
        destinations: draw the cells that teams head for.
        size: of a dot in points; None for the robot's true size.
    """
    robots = robots_at(run, step)
    charging = robots["mode"] == "CHR"
    axes.plot(
        *run.stations_m.T, linestyle="none", marker="P", markersize=9, zorder=3,
        markerfacecolor=CHARGE_GREEN, markeredgecolor="black", markeredgewidth=0.6,
    )  # fmt: skip
    if destinations:
        cells = np.unique(robots["destination"][robots["alive"] & ~charging])
        centres = run.frame.centres_of(run.frame.unflat_many(cells[cells >= 0]))
        for x, y in centres:
            axes.add_patch(
                Circle((x, y), 0.7 * run.frame.cell_m, fill=False, linestyle=(0, (0.1, 1.6)),
                       linewidth=2.2, capstyle="round", edgecolor=DESTINATION_PURPLE, zorder=4)
            )  # fmt: skip
    for chosen, colour in ((~charging, EXPLORE_RED), (charging, CHARGE_GREEN)):
        for x, y in zip(robots["x_m"][chosen], robots["y_m"][chosen], strict=True):
            if size is None:
                radius = run.scenario.body.radius_m
                axes.add_patch(
                    Circle((x, y), radius, facecolor=colour, edgecolor="white", linewidth=0.3,
                           zorder=5)
                )  # fmt: skip
            else:
                axes.plot([x], [y], marker="o", markersize=size, color=colour, zorder=5,
                          markeredgewidth=0)  # fmt: skip
    if teams:
        for team in np.unique(robots["team"][~charging]):
            members = (robots["team"] == team) & ~charging
            if members.sum() > 1:
                points = np.column_stack([robots["x_m"][members], robots["y_m"][members]])
                middle = (points.min(axis=0) + points.max(axis=0)) / 2
                reach = float(np.hypot(*(points - middle).T).max()) + 0.4
                axes.add_patch(
                    Circle(tuple(middle), reach, fill=False, linewidth=1.3,
                           edgecolor=EXPLORE_RED, zorder=6)
                )  # fmt: skip


def _show(axes: Axes, run: Run, picture: NDArray[np.float64], window: Window) -> None:
    axes.set_facecolor(UNKNOWN_GRAY)
    axes.imshow(picture, origin="lower", extent=run.frame.extent, interpolation="nearest")
    axes.set(xlim=window[:2], ylim=window[2:], aspect="equal")
    axes.tick_params(labelsize="x-small")
