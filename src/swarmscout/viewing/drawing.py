"""Map and swarm in Matplotlib: the one drawing behind all figures of missions.

Robots in EXP mode are discs, in CHR mode squares, and stranded ones crosses, so that figures can be
read without telling red from green.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from swarmscout.core.grid import GridFrame
from swarmscout.viewing.map_image import Window, map_image
from swarmscout.viewing.palette import LIGHT
from swarmscout.viewing.replay import Moment, Replay, Team

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from matplotlib.patches import Patch

__all__ = ["PAGE_INCHES", "add_legend", "draw_map", "draw_stations", "draw_swarm", "map_signs",
           "print_style", "ring_of_dots", "round_length", "show_image"]  # fmt: skip

PAGE_INCHES = 7.0
"""The width of a page's text."""

Place = Callable[[NDArray[np.float64]], NDArray[np.float64]]
"""Points ``(x, y)`` [n, 2] in metres to the axes' own units."""


@contextmanager
def print_style() -> Iterator[None]:
    """Small type and thin lines; text in SVG and PDF stays text."""
    from matplotlib import rc_context

    settings: Any = {
        "font.size": 8.0,
        "axes.titlesize": 8.5,
        "axes.linewidth": 0.6,
        "xtick.major.width": 0.6,
        "ytick.major.width": 0.6,
        "legend.fontsize": 7.5,
        "legend.frameon": False,
        "svg.fonttype": "none",
        "svg.hashsalt": "swarmscout",
        "pdf.fonttype": 42,
        "text.parse_math": False,  # Names are text: "$" does not begin a formula.
    }
    with rc_context(settings):
        yield


def show_image(
    axes: Axes, frame: GridFrame, image: NDArray[Any], window: Window | None = None
) -> None:
    """Show the part of a picture of the map that lies in a window, in metres.

    Args:
        axes: where to draw.
        frame: of the map.
        image: [rows, cols, 3], row 0 lowest.
        window: None for all of it.
    """
    left, right, bottom, top = window or frame.extent
    (row0, col0), (row1, col1) = frame.cells_of([(left, bottom), (right, top)])
    rows = slice(max(0, row0), max(0, min(frame.rows, row1 + 1)))
    cols = slice(max(0, col0), max(0, min(frame.columns, col1 + 1)))
    x_m = frame.origin_x_m + frame.cell_m * np.array([cols.start, cols.stop])
    y_m = frame.origin_y_m + frame.cell_m * np.array([rows.start, rows.stop])
    axes.set_facecolor(LIGHT.unknown)
    axes.imshow(
        image[rows, cols], origin="lower", extent=(*x_m, *y_m), interpolation="nearest"
    )  # fmt: skip
    axes.set(xlim=(left, right), ylim=(bottom, top), aspect="equal")


def draw_map(
    axes: Axes,
    replay: Replay,
    moment: Moment,
    *,
    size: float = 4.0,
    teams: bool = True,
    destinations: bool = True,
    window: Window | None = None,
) -> None:
    """Draw the map and the swarm, in metres.

    Args:
        axes: where to draw.
        replay: the run.
        moment: the run after a step.
        size: of a robot, in points.
        teams: circle teams, and mark leaders and links to destinations.
        destinations: draw destinations.
        window: the part to show; None for all that the mission maps.
    """
    run = replay.run
    image = map_image(moment.labels, run.scenario.map.frontier_neighbours)
    show_image(axes, run.frame, image, window or replay.window())
    draw_swarm(axes, moment, run.stations_m, size=size, teams=teams, destinations=destinations)
    if replay.robot is not None:
        axes.plot(
            *moment.place_m[replay.robot], "o", color="none", markeredgecolor=LIGHT.selected,
            markeredgewidth=1.2, markersize=2.6 * size, zorder=9, label=f"robot {replay.robot}",
        )  # fmt: skip


def draw_swarm(
    axes: Axes,
    moment: Moment,
    stations_m: NDArray[np.float64],
    place: Place = lambda points: points,
    per_m: float = 1.0,
    *,
    flat: float = 1.0,
    size: float = 4.0,
    teams: bool = True,
    destinations: bool = True,
) -> None:
    """Draw stations, destinations, teams and robots.

    Args:
        axes: where to draw.
        moment: the run after a step.
        stations_m: float64[k, 2].
        place: metres to the axes' units.
        per_m: the axes' units per metre.
        flat: height of a level circle as seen, divided by its width.
        size: of a robot, in points.
        teams: circle teams, and mark leaders and links to destinations.
        destinations: draw destinations.
    """
    draw_stations(axes, place(stations_m), size)
    goals = [team for team in moment.teams if team.destination_m is not None]
    if destinations and goals:
        ends = place(np.array([team.destination_m for team in goals]))
        _marks(
            axes, ends, ring_of_dots(), LIGHT.destination, max(9.0, size * 2.2), "destination",
            edge="none",
        )  # fmt: skip
        starts = place(moment.place_m[[team.leader for team in goals]])
        for start, end in zip(starts, ends, strict=True) if teams else ():
            axes.plot(
                *zip(start, end, strict=True), ":", color=LIGHT.destination, linewidth=0.7,
                zorder=3,
            )  # fmt: skip
    groups = [team for team in moment.teams if len(team.members) > 1] if teams else []
    _circles(axes, groups, place, per_m, flat, size)
    exploring = moment.alive & ~moment.charging
    for chosen, mark, colour, label in zip(
        (exploring, moment.alive & moment.charging, ~moment.alive),
        "osX",
        LIGHT.robots,
        ("robot (EXP)", "robot (CHR)", "robot (stranded)"),
        strict=True,
    ):
        if chosen.any():
            _marks(axes, place(moment.place_m[chosen]), mark, colour, size, label, edge="white")
    if groups:
        heads = place(moment.place_m[[team.leader for team in groups]])
        _marks(axes, heads, "*", "white", size * 1.15, "leader", edge="black")


def draw_stations(axes: Axes, points: NDArray[np.float64], size: float = 4.0) -> None:
    """Draw charging stations at points [k, 2] in the axes' units."""
    _marks(axes, points, "P", LIGHT.charge, size * 1.9, "charging station", edge="white")


def map_signs() -> list[Patch]:
    """The legend's entries for the map's colours."""
    from matplotlib.patches import Patch

    named = {"unknown": LIGHT.unknown, "free": LIGHT.free, "wall": LIGHT.occupied,
             "frontier": LIGHT.frontier}  # fmt: skip
    return [
        Patch(facecolor=colour, edgecolor="black", linewidth=0.5, label=label)
        for label, colour in named.items()
    ]


def add_legend(figure: Figure, axes: Axes, columns: int, *, cells: bool = True) -> Any:
    """Put a legend of what is drawn below a figure; with ``cells`` the map's colours come first."""
    handles = axes.get_legend_handles_labels()[0]
    return figure.legend(
        handles=[*map_signs(), *handles] if cells else handles, loc="outside lower center",
        ncols=columns, handletextpad=0.5, columnspacing=1.2, frameon=False,
    )  # fmt: skip


def ring_of_dots() -> Any:
    """A marker: eight dots on a circle (paper, Fig. 9)."""
    from matplotlib.path import Path as Outline

    angles = np.arange(8) * (np.pi / 4)
    dot = Outline.circle(radius=0.17)
    outline = np.asarray(dot.vertices)
    return Outline.make_compound_path(
        *(Outline(outline + np.array([np.cos(a), np.sin(a)]), dot.codes) for a in angles)
    )


def round_length(wanted: float) -> float:
    """The largest of 1, 2, 5 × 10ⁿ that is not larger than a length: for a scale bar."""
    power = 10.0 ** math.floor(math.log10(wanted))
    return max(part * power for part in (1.0, 2.0, 5.0) if part * power <= wanted)


def _circles(
    axes: Axes, groups: list[Team], place: Place, per_m: float, flat: float, size: float
) -> None:
    from matplotlib.patches import Ellipse

    for team in groups:
        across = 2 * per_m * (team.radius_m + 0.45)
        x, y = place(team.centre_m[None])[0]
        axes.add_patch(
            Ellipse(
                (x, y), across, across * flat, fill=False, edgecolor=LIGHT.team, linewidth=0.9,
                zorder=6,
            )
        )  # fmt: skip
    if groups:
        # The legend shows a circle; an ellipse in the axes would not give one.
        axes.plot(
            [], [], "o", color="none", markeredgecolor=LIGHT.team, markersize=size * 1.7,
            label="team",
        )  # fmt: skip


def _marks(
    axes: Axes, points: NDArray[np.float64], mark: Any, colour: str, size: float, label: str,
    edge: str,
) -> None:  # fmt: skip
    axes.plot(
        *points.T, linestyle="none", marker=mark, markersize=size, markerfacecolor=colour,
        markeredgecolor=edge, markeredgewidth=0.0 if edge == "none" else 0.45, label=label,
        zorder=8 if mark == "*" else 7 if mark in ("o", "s", "X") else 5,
    )  # fmt: skip
