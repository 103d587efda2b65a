"""A picture of the swarm's map in the paper's colours, with robots and a legend.

Gray is unknown, white free, black occupied, green a frontier (paper, Figs. 1 and 9).
"""

from __future__ import annotations

import io
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from swarmscout.core.enums import UNKNOWN
from swarmscout.core.errors import RunError
from swarmscout.recording.run import Run
from swarmscout.recording.table_files import write_whole
from swarmscout.recording.tables import LEVELS
from swarmscout.viewing.drawing import add_legend, draw_stations, draw_swarm, show_image
from swarmscout.viewing.map_image import Window, labels_at, map_image, window_round
from swarmscout.viewing.replay import Moment, Replay

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["map_figure", "map_picture", "short_name", "world_name"]

_MARGIN_M = 3.0
_LONG_SIDE_INCHES = 9.0
_LEAST_INCHES = 5.5
_TITLE_INCHES, _LABEL_INCHES = 0.5, 0.6
_LEGEND_INCHES, _LEGEND_ENTRIES = 1.6, 10
_DPI = 120


def map_picture(run: Run, path: str | Path, step: int | None = None) -> Path:
    """Draw the swarm's map after a step into a PNG file.

    Args:
        run: a run, finished or not, in memory or on disk.
        path: the picture's file.
        step: 0 … ``run.last_step``; None for the last.

    Returns:
        The file.

    Raises:
        RunError: the step does not exist, the map was not recorded, or the file cannot be written.

    Example:
        >>> map_picture(run, "map.png", step=100)  # doctest: +SKIP
    """
    packed = io.BytesIO()
    map_figure(run, step).savefig(
        packed, format="png", dpi=_DPI, bbox_inches="tight", pad_inches=0.1
    )
    file = Path(path)
    write_whole(file, packed.getvalue())
    return file


def map_figure(run: Run, step: int | None = None) -> Figure:
    """The picture as a Matplotlib figure of its own; neither pyplot nor a display is used.

    Args:
        run: a run.
        step: as for :func:`map_picture`.

    Raises:
        RunError: the step does not exist, or the map was not recorded.
    """
    from matplotlib.figure import Figure
    from matplotlib.lines import Line2D

    if not isinstance(run, Run):
        raise RunError(f"a map's picture is made of a Run, not of a {type(run).__name__}")
    at = run.last_step if step is None else step
    labels = labels_at(run, at)
    moment = Replay(run).moment(at) if "steps" in LEVELS[run.level] else None

    window = left, right, bottom, top = _window(run, labels, moment)
    longest = max(right - left, top - bottom)
    width = max(_LEAST_INCHES, _LONG_SIDE_INCHES * (right - left) / longest)
    height = max(0.5 * _LEAST_INCHES, _LONG_SIDE_INCHES * (top - bottom) / longest)
    # The legend's rows lie below the map.
    columns = max(3, int(width / _LEGEND_INCHES))
    below = _LABEL_INCHES + 0.25 * -(-_LEGEND_ENTRIES // columns)
    figure = Figure(figsize=(width + _LABEL_INCHES, height + below + _TITLE_INCHES))
    figure.set_layout_engine("constrained")
    axes = figure.add_subplot()
    show_image(axes, run.frame, map_image(labels, run.scenario.map.frontier_neighbours), window)
    points_per_m = 72.0 * min(width / (right - left), height / (top - bottom))
    size = float(np.clip(2.0 * run.scenario.body.radius_m * points_per_m, 6.0, 12.0))
    if moment is None:
        draw_stations(axes, run.stations_m, size)
    else:
        draw_swarm(axes, moment, run.stations_m, size=size)
    axes.set(xlabel="x (m)", ylabel="y (m)")
    axes.set_anchor("S")
    axes.set_title(_title(run, at), fontsize="medium", parse_math=False)
    for sign in add_legend(figure, axes, columns).legend_handles:
        if isinstance(sign, Line2D):
            sign.set_markersize(min(sign.get_markersize(), 9.0))  # Rows of text are no higher.
    return figure


def _window(run: Run, labels: NDArray[np.uint8], moment: Moment | None) -> Window:
    """All that is known after the step, all robots and stations, and a margin."""
    points = [run.frame.centres_of(np.argwhere(labels != UNKNOWN)), run.stations_m]
    if moment is not None:
        points.append(moment.place_m)
    known = np.concatenate(points)
    return window_round(known, _MARGIN_M) if len(known) else run.frame.extent


def _title(run: Run, step: int) -> str:
    """World, number of robots and selector; below them step and explored area where recorded."""
    count = run.scenario.robots
    heads = [world_name(run), f"{count} robot{'' if count == 1 else 's'}"]
    words = [f"step {step}"]
    if "coverage" in LEVELS[run.level]:
        rows = run.coverage
        explored = rows["explored_m2"][int(rows["step"].search_sorted(step))]
        words.append(f"{explored:.0f} m² explored")
    elif run.summary is not None:
        words.append(f"{run.summary['explored_m2']:.0f} m² explored")
    return " · ".join([*heads, short_name(run.scenario.destinations)]) + "\n" + " · ".join(words)


def world_name(run: Run) -> str:
    """The name of a run's world, without a folder."""
    facts = run.facts.get("world")
    name = facts.get("name") if isinstance(facts, Mapping) else None
    return short_name(str(name or run.scenario.world))


def short_name(name: str) -> str:
    """A name that fits into a title: of a file without its folder, and at most 30 characters."""
    last = name.replace("\\", "/").rpartition("/")[2]
    return last if len(last) <= 30 else f"{last[:29]}…"
