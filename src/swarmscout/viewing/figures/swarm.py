"""The swarm in a Matplotlib axes: over a map as well as over the cave."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from swarmscout.viewing.figures.style import (
    CHARGE,
    DESTINATION,
    EXPLORE,
    STRANDED,
    ring_of_dots,
)
from swarmscout.viewing.replay import Moment

if TYPE_CHECKING:
    from matplotlib.axes import Axes

__all__ = ["draw_swarm"]

Place = Callable[[NDArray[np.float64]], NDArray[np.float64]]
"""Points ``(x, y)`` [n, 2] in metres to the axes' own units."""


def draw_swarm(
    axes: Axes,
    moment: Moment,
    stations_m: NDArray[np.float64],
    place: Place,
    per_m: float,
    *,
    flat: float = 1.0,
    size: float = 4.0,
    teams: bool = True,
    dark: bool = False,
) -> None:
    """Draw stations, destinations, teams and robots.

    Args:
        axes: where.
        moment: the run after a step.
        stations_m: float64[k, 2].
        place: metres to the axes' units.
        per_m: the axes' units per metre.
        flat: a level circle is an ellipse, so many times as high as wide.
        size: of a robot, in points.
        teams: circle teams, and mark leaders and links to destinations.
        dark: on a dark background.
    """
    from matplotlib.patches import Ellipse

    _marks(axes, place(stations_m), "P", CHARGE, size * 1.9, "charging station", edge="white")
    goals = [team for team in moment.teams if team.destination_m is not None]
    if goals:
        ends = place(np.array([team.destination_m for team in goals]))
        _marks(axes, ends, ring_of_dots(), DESTINATION, size * 2.2, "destination", edge="none")
        if teams:
            starts = place(moment.place_m[[team.leader for team in goals]])
            for start, end in zip(starts, ends, strict=True):
                axes.plot(
                    *zip(start, end, strict=True), ":", color=DESTINATION, linewidth=0.7, zorder=3
                )
    groups = [team for team in moment.teams if len(team.members) > 1]
    if teams:
        colour = "#e8e4da" if dark else "#30343a"
        # A circle as the legend's sign, which an ellipse in the picture would not give.
        axes.plot(
            [], [], "o", color="none", markeredgecolor=colour, markersize=size * 1.7, label="team"
        )
        for team in groups:
            across = 2 * per_m * (team.radius_m + 0.45)
            x, y = place(team.centre_m[None])[0]
            circle = Ellipse(
                (x, y), across, across * flat, fill=False, edgecolor=colour, linewidth=0.9,
                zorder=6,
            )  # fmt: skip
            axes.add_patch(circle)
    exploring = moment.alive & ~moment.charging
    for chosen, mark, colour, label in (
        (exploring, "o", EXPLORE, "robot (EXP)"),
        (moment.alive & moment.charging, "s", CHARGE, "robot (CHR)"),
        (~moment.alive, "X", STRANDED, "robot (stranded)"),
    ):
        if chosen.any():
            _marks(axes, place(moment.place_m[chosen]), mark, colour, size, label, edge="white")
    if teams and groups:
        heads = place(moment.place_m[[team.leader for team in groups]])
        _marks(axes, heads, "*", "white", size * 1.15, "leader", edge="black")


def _marks(
    axes: Axes, points: NDArray[np.float64], mark: Any, colour: str, size: float, label: str,
    edge: str,
) -> None:  # fmt: skip
    axes.plot(
        *points.T, linestyle="none", marker=mark, markersize=size, markerfacecolor=colour,
        markeredgecolor=edge, markeredgewidth=0.0 if edge == "none" else 0.45, label=label,
        zorder=8 if mark == "*" else 7 if mark in ("o", "s", "X") else 5,
    )  # fmt: skip
