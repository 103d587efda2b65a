"""A picture of a world: ground, walls, the start and the charging stations."""

from __future__ import annotations

import io
import math
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from swarmscout.core.errors import RunError, WorldError
from swarmscout.recording.table_files import write_whole
from swarmscout.viewing.drawing import draw_stations, round_length
from swarmscout.viewing.palette import LIGHT, rgb
from swarmscout.worlds.placement import place_robots, place_stations
from swarmscout.worlds.reachability import reachable
from swarmscout.worlds.starts import start_of
from swarmscout.worlds.world import World

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

__all__ = ["world_figure", "world_picture"]

ROCK, PAPER, CUT_OFF = "#2b2622", "#f7f4ee", "#8d8478"
_LONG_SIDE_INCHES = 8.0
_DPI = 110
_LONGEST_PIXELS = 2400
"""Larger rasters are subsampled."""


def world_picture(world: World, path: str | Path, robots: int = 15, dpi: int = _DPI) -> Path:
    """Draw a world into a file.

    Args:
        world: a world.
        path: the picture's file; its suffix chooses PNG, PDF or SVG.
        robots: number of robots to show stations and starting places for.
        dpi: dots per inch.

    Returns:
        The file.

    Raises:
        WorldError: no mission can start in the world, or the picture cannot be written.

    Example:
        >>> world_picture(load_world("lava-tube"), "tube.png")  # doctest: +SKIP
    """
    file = Path(path)
    packed = io.BytesIO()
    form = file.suffix.lower().lstrip(".") or "png"
    figure = world_figure(world, robots)
    known = figure.canvas.get_supported_filetypes()
    if form not in known:
        raise WorldError(f"picture '{file}': unknown format '{form}': use png, pdf or svg")
    figure.savefig(packed, format=form, dpi=dpi)
    try:
        file.parent.mkdir(parents=True, exist_ok=True)
        write_whole(file, packed.getvalue())
    except OSError as error:
        raise WorldError(f"cannot write '{file}': {error.strerror or error}") from None
    except RunError as error:
        raise WorldError(str(error)) from None
    return file


def world_figure(world: World, robots: int = 15) -> Figure:
    """The picture as a Matplotlib figure of its own; neither pyplot nor a display is used.

    Args:
        world: a world.
        robots: number of robots to show stations and starting places for.

    Raises:
        WorldError: no mission can start in the world.
    """
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    left, right, bottom, top = world.extent
    scale = _LONG_SIDE_INCHES / max(right - left, top - bottom)
    size = max(4.5, (right - left) * scale), max(2.0, (top - bottom) * scale) + 0.7
    figure = Figure(figsize=size, layout="constrained", facecolor=PAPER)
    FigureCanvasAgg(figure)
    axes = figure.add_subplot(facecolor=ROCK)
    axes.imshow(_colours(world), origin="lower", extent=world.extent, interpolation="antialiased")
    _draw_places(axes, world, robots)
    _draw_scale_bar(axes, world)
    axes.set(xlim=(left, right), ylim=(bottom, top), aspect="equal", xticks=[], yticks=[])
    for spine in axes.spines.values():
        spine.set_visible(False)
    area = float(np.count_nonzero(reachable(world))) * world.resolution_m**2
    seed = world.source.get("seed")
    words = [world.name if seed is None else f"{world.name}, seed {seed}"]
    words += [f"{area:,.0f} m² reachable", f"{right - left:.0f} m × {top - bottom:.0f} m"]
    axes.set_title(" · ".join(words), fontsize=11, color=ROCK, parse_math=False)
    return figure


def _colours(world: World) -> NDArray[np.float64]:
    """float64[rows, cols, 3]: rock, and ground by height, lit from the upper left."""
    low_rgb, high_rgb, rock, cut_off = (
        np.array(rgb(colour)) / 255.0
        for colour in (LIGHT.ground_low, LIGHT.ground_high, ROCK, CUT_OFF)
    )
    thin = max(1, math.ceil(max(world.free.shape) / _LONGEST_PIXELS))
    free = world.free[::thin, ::thin] != 0
    reach = reachable(world)[::thin, ::thin] != 0
    picture = np.empty((*free.shape, 3))
    picture[:] = rock
    inside: NDArray[Any] = free
    if world.ground_m is None:
        picture[free] = high_rgb
    else:
        ground = world.ground_m[::thin, ::thin].astype(np.float64)
        if world.ceiling_m is not None:
            inside = free | (world.ceiling_m[::thin, ::thin] > ground + 0.3)
        low, high = np.quantile(ground[free], (0.01, 0.99))
        share = np.clip((ground - low) / max(high - low, 1e-6), 0.0, 1.0)[..., None]
        slope_y, slope_x = np.gradient(ground, world.resolution_m * thin)
        light = np.clip(1.0 + 0.55 * (slope_x - slope_y), 0.72, 1.12)[..., None]
        lit = np.clip((low_rgb * (1.0 - share) + high_rgb * share) * light, 0.0, 1.0)
        picture[free] = lit[free]
        # Breakdown inside the tube: darker than the ground.
        breakdown = inside & ~free
        picture[breakdown] = 0.52 * lit[breakdown]
    picture[free & ~reach] = cut_off
    return picture


def _draw_places(axes: Axes, world: World, robots: int) -> None:
    """Stations, starting places (as an example: seed 0), and the start."""
    stations = place_stations(world, robots)
    try:
        places = place_robots(world, robots, "one-place", np.random.default_rng(0))
    except WorldError:
        places = np.empty((0, 2))  # A world too small for the robots is drawn without them.
    axes.plot(
        *places.T, linestyle="none", marker="o", markersize=2.6, color=LIGHT.explore,
        markeredgewidth=0.0, zorder=3, label=f"{len(places)} robots",
    )  # fmt: skip
    draw_stations(axes, stations)
    axes.plot(
        *start_of(world), linestyle="none", marker="o", markersize=17, markerfacecolor="none",
        markeredgecolor=LIGHT.selected, markeredgewidth=1.6, zorder=5, label="start",
    )  # fmt: skip
    figure = axes.get_figure()
    if figure is not None:
        figure.legend(
            loc="outside lower center", ncols=3, frameon=False, fontsize=9, labelcolor=ROCK,
            markerscale=0.75,
        )  # fmt: skip


def _draw_scale_bar(axes: Axes, world: World) -> None:
    """A bar of a round length in the lower right corner."""
    from matplotlib.patheffects import withStroke

    left, right, bottom, top = world.extent
    length = round_length(0.2 * (right - left))
    end, level = right - 0.03 * (right - left), bottom + 0.03 * (top - bottom)
    # Legible on rock and on floor: light with a dark edge.
    edge = [withStroke(linewidth=3.5, foreground=ROCK)]
    axes.plot((end - length, end), (level, level), color=ROCK, linewidth=5.0, zorder=6)
    axes.plot((end - length, end), (level, level), color=PAPER, linewidth=2.6, zorder=7)
    axes.annotate(
        f"{length:g} m", (end - length / 2, level), xytext=(0, 4), textcoords="offset points",
        ha="center", color=PAPER, fontsize=9, zorder=7, path_effects=edge,
    )  # fmt: skip
