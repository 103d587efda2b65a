"""Figures of the cave in 3D: alone, and beside the map."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from swarmscout.viewing.drawing import (
    PAGE_INCHES,
    add_legend,
    draw_map,
    draw_swarm,
    round_length,
)
from swarmscout.viewing.mission_figures.maps import title_of
from swarmscout.viewing.overview import Overview
from swarmscout.viewing.palette import LIGHT
from swarmscout.viewing.relief import relief_of
from swarmscout.viewing.replay import Moment, Replay

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

__all__ = ["cave_and_map", "cave_overview"]

PIXELS = 1600
"""Width of the picture of the cave, in pixels."""
PAPER = "#ffffff"


def cave_overview(replay: Replay, step: int) -> Figure:
    """The whole cave, cut open: explored parts bright, with the swarm."""
    from matplotlib.figure import Figure

    moment = replay.moment(step)
    view = _view(replay, PIXELS, PIXELS * 2 // 3, whole=True)
    height = PAGE_INCHES * view.size[1] / view.size[0] + 0.45
    figure = Figure(figsize=(PAGE_INCHES, height), layout="constrained")
    axes = figure.add_subplot()
    _draw(axes, replay, moment, view, size=3.4)
    add_legend(figure, axes, 7, cells=False)
    return figure


def cave_and_map(replay: Replay, step: int) -> Figure:
    """Two panels: the explored part of the cave, and the map."""
    from matplotlib.figure import Figure

    left, right, bottom, top = replay.window()
    aspect = (top - bottom) / (right - left)
    moment = replay.moment(step)
    room = min(4.6, max(1.7, 0.5 * PAGE_INCHES * aspect))
    view = _view(replay, PIXELS // 2, int(PIXELS * room / PAGE_INCHES))
    figure = Figure(figsize=(PAGE_INCHES, room + 0.9), layout="constrained")
    cave, chart = figure.subplots(1, 2)
    _draw(cave, replay, moment, view, size=3.4)
    draw_map(chart, replay, moment, size=3.0)
    chart.set(xlabel="x (m)", ylabel="y (m)")
    figure.suptitle(title_of(replay, moment), fontsize=8.5)
    add_legend(figure, chart, 6)
    return figure


def _view(replay: Replay, width: int, height: int, *, whole: bool = False) -> Overview:
    relief = relief_of(replay.run.world())
    window = replay.run.frame.extent if whole else replay.window()
    return Overview(relief, window, width, height, replay.run.frame, LIGHT, PAPER)


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
    _draw_north_and_scale(axes, (x0, y0, x1, y1), view.scale)


def _draw_north_and_scale(axes: Axes, box: tuple[int, int, int, int], scale: float) -> None:
    """North is up in the whole picture; the scale holds for its horizontal."""
    x0, y0, x1, y1 = box
    length = round_length(0.25 * (x1 - x0) / scale)
    axes.plot((x0, x0 + length * scale), (y1, y1), color=LIGHT.text, linewidth=1.6, clip_on=False)
    axes.annotate(
        f"{length:g} m", (x0, y1), xytext=(0, 3), textcoords="offset points", fontsize=7,
        color=LIGHT.text,
    )  # fmt: skip
    axes.annotate(
        "N", (x0 + 12, y0), xytext=(0, -22), textcoords="offset points", ha="center", fontsize=7,
        color=LIGHT.text, arrowprops={"arrowstyle": "->", "color": LIGHT.text},
    )  # fmt: skip
