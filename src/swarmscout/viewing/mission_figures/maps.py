"""Figures of the map and of the explored area."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from swarmscout.viewing.drawing import PAGE_INCHES, add_legend, draw_map
from swarmscout.viewing.palette import LIGHT
from swarmscout.viewing.replay import Curve, Moment, Replay

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

__all__ = ["explored_area", "growing_map", "team_map", "title_of"]

SHARES = (0.1, 0.4, 0.7, 1.0)
"""The moments of a growing map, as shares of the mission."""


def team_map(replay: Replay, step: int) -> Figure:
    """The map after a step: teams circled, leaders and destinations marked.

    Source: paper, Fig. 9.
    """
    from matplotlib.figure import Figure

    left, right, bottom, top = replay.window()
    aspect = (top - bottom) / (right - left)
    width = max(min(PAGE_INCHES, 7.5 / aspect), 3.4)
    figure = Figure(figsize=(width, width * aspect + 0.9), layout="constrained")
    axes = figure.add_subplot()
    moment = replay.moment(step)
    draw_map(axes, replay, moment, size=4.6)
    _name_one_that_charges(axes, replay, moment)
    axes.set(xlabel="x (m)", ylabel="y (m)", title=title_of(replay, moment))
    add_legend(figure, axes, 4 if width > 5 else 3)
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
        figure.suptitle(f"the map of robot {replay.robot}", fontsize=8.5)
    add_legend(figure, axes, 5)
    return figure


def explored_area(replay: Replay | Curve, step: int) -> Figure:
    """Explored area over the steps, in m² and as a share of the reachable; a mark at the step."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(3.4, 2.3), layout="constrained")
    axes = figure.add_subplot()
    area = replay.explored_m2
    axes.plot(np.arange(len(area)), area, color=LIGHT.accent, linewidth=1.4)
    if step < replay.last:
        axes.axvline(step, color=LIGHT.muted, linewidth=0.7)
    axes.set(
        xlim=(0, max(1, replay.last)), ylim=(0, None), xlabel="step", ylabel="explored area (m²)"
    )
    axes.grid(color="#e2e2e2", linewidth=0.5)
    axes.spines[["top", "right"]].set_visible(False)
    fraction = replay.run.coverage["explored_fraction"].to_numpy()
    if len(fraction) and fraction[-1] > 0:
        reachable_m2 = float(replay.run.coverage["explored_m2"][-1]) / float(fraction[-1])
        share = axes.twinx()
        share.set_ylim(0, 100.0 * axes.get_ylim()[1] / reachable_m2)
        share.spines[["top"]].set_visible(False)
        share.set_ylabel("of the reachable area (%)")
    return figure


def _name_one_that_charges(axes: Axes, replay: Replay, moment: Moment) -> None:
    """Label the robot in CHR mode that is nearest to a station."""
    charging = np.flatnonzero(moment.alive & moment.charging)
    stations = replay.run.stations_m
    if not len(charging) or not len(stations):
        return
    gaps = np.linalg.norm(moment.place_m[charging][:, None] - stations[None], axis=2).min(axis=1)
    x, y = moment.place_m[charging[gaps.argmin()]]
    axes.annotate(
        "charging", (x, y), xytext=(14, -16), textcoords="offset points", color=LIGHT.charge,
        fontsize=7.5, zorder=9, bbox={"fc": "white", "ec": "none", "alpha": 0.8, "pad": 1.0},
        arrowprops={"arrowstyle": "-", "color": LIGHT.charge, "linewidth": 0.8},
    )  # fmt: skip


def title_of(replay: Replay, moment: Moment) -> str:
    """The step, and how much is explored or which robot's map is shown."""
    if replay.robot is not None:
        return f"step {moment.step} · the map of robot {replay.robot}"
    return f"step {moment.step} · {moment.explored_m2:.0f} m² explored"
