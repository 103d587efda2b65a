"""Figures of the map: with its teams, and growing."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from swarmscout.viewing.figures.style import CHARGE, MAP_COLOURS, PAGE_INCHES
from swarmscout.viewing.figures.swarm import draw_swarm
from swarmscout.viewing.map_picture import frontier_cells
from swarmscout.viewing.replay import Moment, Replay

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

__all__ = ["draw_map", "growing_map", "team_map", "title_of"]

OF_THIS_ROBOT = "#b35c00"

SHARES = (0.1, 0.4, 0.7, 1.0)
"""The moments of a growing map, as shares of the mission."""


def team_map(replay: Replay, step: int) -> Figure:
    """The map after a step: teams circled, leaders and destinations marked, who charges.

    Source: paper, Fig. 9.
    """
    from matplotlib.figure import Figure

    left, right, bottom, top = replay.window()
    aspect = (top - bottom) / (right - left)
    width = min(PAGE_INCHES, 7.5 / aspect)
    figure = Figure(
        figsize=(max(width, 3.4), max(width, 3.4) * aspect + 0.75), layout="constrained"
    )
    axes = figure.add_subplot()
    moment = replay.moment(step)
    draw_map(axes, replay, moment, size=4.6)
    _name_one_that_charges(axes, replay, moment)
    axes.set(xlabel="x (m)", ylabel="y (m)", title=title_of(replay, moment))
    ncols = 4 if width > 5 else 3
    figure.legend(loc="outside lower center", ncols=ncols, handletextpad=0.3, columnspacing=1.2)
    return figure


def growing_map(replay: Replay, step: int) -> Figure:
    """Four moments of a growing map, up to a step."""
    from matplotlib.figure import Figure

    left, right, bottom, top = replay.window()
    aspect = (top - bottom) / (right - left)
    rows, columns = (1, 4) if aspect > 0.9 else (2, 2) if aspect > 0.3 else (4, 1)
    height = PAGE_INCHES / columns * aspect * rows + 0.35 * rows + 0.4
    figure = Figure(figsize=(PAGE_INCHES, min(height, 9.0)), layout="constrained")
    for k, share in enumerate(SHARES):
        axes = figure.add_subplot(rows, columns, k + 1)
        moment = replay.moment(round(share * step))
        draw_map(axes, replay, moment, size=2.6, teams=False)
        area = "" if replay.robot is not None else f" · {moment.explored_m2:.0f} m²"
        axes.set(xticks=[], yticks=[], title=f"step {moment.step}{area}")
    if replay.robot is not None:
        figure.suptitle(f"what robot {replay.robot} knows", fontsize=8.5)
    handles = axes.get_legend_handles_labels()
    figure.legend(*handles, loc="outside lower center", ncols=5, handletextpad=0.3)
    return figure


def draw_map(
    axes: Axes, replay: Replay, moment: Moment, *, size: float, teams: bool = True
) -> None:
    """Draw the map and the swarm, in metres."""
    from matplotlib.colors import ListedColormap

    labels = moment.labels.copy()
    edge = frontier_cells(moment.labels, replay.run.scenario.map.frontier_neighbours)
    labels[edge] = 3
    left, right, bottom, top = replay.window()
    frame = replay.run.frame
    (row0, col0), (row1, col1) = frame.cells_of([(left, bottom), (right, top)])
    rows = slice(max(0, row0), min(frame.rows, row1 + 1))
    cols = slice(max(0, col0), min(frame.columns, col1 + 1))
    x_m = frame.origin_x_m + frame.cell_m * np.array([cols.start, cols.stop])
    y_m = frame.origin_y_m + frame.cell_m * np.array([rows.start, rows.stop])
    axes.set_facecolor(MAP_COLOURS[0])
    axes.imshow(
        labels[rows, cols], origin="lower", extent=(*x_m, *y_m), interpolation="nearest",
        cmap=ListedColormap(MAP_COLOURS), vmin=0, vmax=3,
    )  # fmt: skip
    draw_swarm(
        axes, moment, replay.run.stations_m, lambda points: points, 1.0, size=size, teams=teams
    )
    if replay.robot is not None:
        axes.plot(
            *moment.place_m[replay.robot], "o", color="none", markeredgecolor=OF_THIS_ROBOT,
            markeredgewidth=1.2, markersize=2.6 * size, zorder=9, label=f"robot {replay.robot}",
        )  # fmt: skip
    axes.set(xlim=(left, right), ylim=(bottom, top), aspect="equal")


def _name_one_that_charges(axes: Axes, replay: Replay, moment: Moment) -> None:
    """Say so beside the robot in CHR mode that is nearest to a station."""
    charging = np.flatnonzero(moment.alive & moment.charging)
    stations = replay.run.stations_m
    if not len(charging) or not len(stations):
        return
    gaps = np.linalg.norm(moment.place_m[charging][:, None] - stations[None], axis=2).min(axis=1)
    x, y = moment.place_m[charging[gaps.argmin()]]
    axes.annotate(
        "charging", (x, y), xytext=(14, -16), textcoords="offset points", color=CHARGE,
        fontsize=7.5, zorder=9, bbox={"fc": "white", "ec": "none", "alpha": 0.8, "pad": 1.0},
        arrowprops={"arrowstyle": "-", "color": CHARGE, "linewidth": 0.8},
    )  # fmt: skip


def title_of(replay: Replay, moment: Moment) -> str:
    """The step, and how much is explored or whose map is shown."""
    if replay.robot is not None:
        return f"step {moment.step} · what robot {replay.robot} knows"
    return f"step {moment.step} · {moment.explored_m2:.0f} m² explored"
