"""Figures of the cave in 3D: alone, and beside the map."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from swarmscout.viewing.figures.maps import draw_map, title_of
from swarmscout.viewing.figures.style import PAGE_INCHES
from swarmscout.viewing.figures.swarm import draw_swarm
from swarmscout.viewing.overview import LIGHT, Overview
from swarmscout.viewing.relief import relief_of
from swarmscout.viewing.replay import Moment, Replay

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

__all__ = ["cave_and_map", "cave_overview"]

PIXELS = 1600
"""Pixels across the picture of the cave."""


def cave_overview(replay: Replay, step: int) -> Figure:
    """The whole cave, cut open: explored parts bright, with the swarm."""
    from matplotlib.figure import Figure

    moment = replay.moment(step)
    view = _view(replay, PIXELS, PIXELS * 2 // 3, whole=True)
    height = PAGE_INCHES * view.size[1] / view.size[0] + 0.45
    figure = Figure(figsize=(PAGE_INCHES, height), layout="constrained")
    axes = figure.add_subplot()
    _draw(axes, replay, moment, view, size=3.4)
    figure.legend(loc="outside lower center", ncols=7, handletextpad=0.2, columnspacing=1.0)
    return figure


def cave_and_map(replay: Replay, step: int) -> Figure:
    """Two panels: the explored part of the cave, and the map."""
    from matplotlib.figure import Figure

    left, right, bottom, top = replay.window()
    aspect = (top - bottom) / (right - left)
    map_share = 1.0 / (1.0 + min(max(1.4 * aspect, 1.0), 2.2))
    moment = replay.moment(step)
    height = min(4.2, max(2.6, map_share * PAGE_INCHES * aspect + 0.9))
    wide = int(PIXELS * (1 - map_share))
    view = _view(replay, wide, int(wide * (height - 0.9) / (PAGE_INCHES * (1 - map_share))))
    figure = Figure(figsize=(PAGE_INCHES, height), layout="constrained")
    cave, chart = figure.subplots(1, 2, width_ratios=[1 - map_share, map_share])
    _draw(cave, replay, moment, view, size=3.4)
    draw_map(chart, replay, moment, size=3.0)
    chart.set(xlabel="x (m)", ylabel="y (m)")
    figure.suptitle(title_of(replay, moment), fontsize=8.5)
    handles = chart.get_legend_handles_labels()
    figure.legend(
        *handles, loc="outside lower center", ncols=7, handletextpad=0.2, columnspacing=1.0
    )
    return figure


def _view(replay: Replay, width: int, height: int, *, whole: bool = False) -> Overview:
    relief = relief_of(replay.run.world())
    window = replay.run.frame.extent if whole else replay.window()
    return Overview(relief, window, width, height, replay.run.frame, LIGHT)


def _draw(axes: Axes, replay: Replay, moment: Moment, view: Overview, size: float) -> None:
    picture = view.picture(moment.labels != 0)
    # Blank margins are cut off.
    drawn = np.argwhere((picture < 250).any(axis=2))
    width, height = view.size
    if not len(drawn):
        drawn = np.array([[0, 0], [height, width]])
    (y0, x0), (y1, x1) = drawn.min(axis=0), drawn.max(axis=0)
    axes.imshow(picture, interpolation="antialiased", extent=(0, width, height, 0))
    draw_swarm(
        axes, moment, replay.run.stations_m, view.pixels_of, view.scale,
        flat=view.flattening, size=size,
    )  # fmt: skip
    axes.set(xlim=(x0 - 6, x1 + 6), ylim=(y1 + 6, y0 - 6), aspect="equal")
    axes.set_axis_off()
