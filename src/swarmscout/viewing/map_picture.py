"""A picture of the swarm's map in the paper's colours.

Gray is unknown, white free, black occupied, green a frontier. Robots are dots: red in EXP mode,
green in CHR mode. A destination's cell is surrounded by purple dots (paper, Figs. 1 and 9).
"""

from __future__ import annotations

import io
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from swarmscout.core.enums import FREE, OCCUPIED, UNKNOWN
from swarmscout.core.errors import RunError
from swarmscout.mapping.log_odds import log_odds_of
from swarmscout.recording.run import Run
from swarmscout.recording.table_files import write_whole

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from matplotlib.patches import Patch


__all__ = ["frontier_cells", "labels_at", "map_figure", "map_picture"]

UNKNOWN_GRAY, FREE_WHITE, OCCUPIED_BLACK = (0.62, 0.62, 0.62), (1.0, 1.0, 1.0), (0.0, 0.0, 0.0)
FRONTIER_GREEN = (0.36, 0.83, 0.36)
EXPLORE_RED, CHARGE_GREEN, DESTINATION_PURPLE = "#e3211c", "#00702c", "#8a2be2"
STRANDED_BLUE = "#35608f"

_MARGIN_M = 3.0
_LONG_SIDE_INCHES = 9.0
_LEAST_INCHES = 5.5
_TITLE_INCHES, _LABEL_INCHES = 0.5, 0.6
_LEGEND_INCHES, _LEGEND_ENTRIES = 1.6, 9
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
        RunError: there is no such step, the map was not recorded, or the file cannot be written.

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
    """The picture as a Matplotlib figure of its own; neither pyplot nor a display is touched.

    Args:
        run: a run.
        step: as for :func:`map_picture`.

    Raises:
        RunError: there is no such step, or the map was not recorded.
    """
    from matplotlib.figure import Figure
    from matplotlib.lines import Line2D

    if not isinstance(run, Run):
        raise RunError(f"a map's picture is made of a Run, not of a {type(run).__name__}")
    at = run.last_step if step is None else step
    labels = labels_at(run, at)
    picture = np.array([UNKNOWN_GRAY, FREE_WHITE, OCCUPIED_BLACK])[labels]
    picture[frontier_cells(labels, run.scenario.map.frontier_neighbours)] = FRONTIER_GREEN

    robots = _robots_at(run, at)
    left, right, bottom, top = _window(run, labels, robots)
    longest = max(right - left, top - bottom)
    width = max(_LEAST_INCHES, _LONG_SIDE_INCHES * (right - left) / longest)
    height = max(0.5 * _LEAST_INCHES, _LONG_SIDE_INCHES * (top - bottom) / longest)
    # The legend's rows lie below the map, on paper of their own.
    columns = max(3, int(width / _LEGEND_INCHES))
    below = _LABEL_INCHES + 0.25 * -(-_LEGEND_ENTRIES // columns)
    figure = Figure(figsize=(width + _LABEL_INCHES, height + below + _TITLE_INCHES))
    figure.set_layout_engine("constrained")
    axes = figure.add_subplot(facecolor=UNKNOWN_GRAY)
    axes.imshow(picture, origin="lower", extent=run.frame.extent, interpolation="nearest")
    points_per_m = 72.0 * min(width / (right - left), height / (top - bottom))
    _draw_swarm(axes, run, robots, points_per_m)
    axes.set(xlim=(left, right), ylim=(bottom, top), aspect="equal", xlabel="x (m)", ylabel="y (m)")
    axes.set_anchor("S")
    axes.set_title(_title(run, at), fontsize="medium")
    signs = [*_map_signs(), *axes.get_legend_handles_labels()[0]]
    legend = figure.legend(
        handles=signs, loc="outside lower center", ncols=columns, frameon=False, fontsize="small",
        columnspacing=1.4, handletextpad=0.6,
    )  # fmt: skip
    for sign in legend.legend_handles:
        if isinstance(sign, Line2D):
            sign.set_markersize(min(sign.get_markersize(), 9.0))  # Rows of text are no higher.
    return figure


def _map_signs() -> list[Patch]:
    """What the map's colours mean, for the legend."""
    from matplotlib.patches import Patch

    colours = (
        ("unknown", UNKNOWN_GRAY),
        ("free", FREE_WHITE),
        ("wall", OCCUPIED_BLACK),
        ("frontier", FRONTIER_GREEN),
    )
    return [
        Patch(facecolor=colour, edgecolor="black", linewidth=0.5, label=label)
        for label, colour in colours
    ]


def labels_at(run: Run, step: int | None = None, robot: int | None = None) -> NDArray[np.uint8]:
    """uint8[rows, cols] labels (codes ``LABELS``) of a map after a step.

    Args:
        run: a run.
        step: None for the last.
        robot: whose map; None for the swarm's.

    Raises:
        RunError: there is no such step or robot, or the map was not recorded.
    """
    log_odds = run.map_at(step, robot=robot)
    labels = np.full(log_odds.shape, UNKNOWN, dtype=np.uint8)
    labels[log_odds < log_odds_of(run.scenario.map.free_below)] = FREE
    labels[log_odds > log_odds_of(run.scenario.map.occupied_above)] = OCCUPIED
    return labels


def frontier_cells(labels: NDArray[np.uint8], neighbours: int = 8) -> NDArray[np.bool_]:
    """bool[rows, cols]: free cells beside the unknown, see ``mapping.occupancy``.

    Source: paper, "Task description"; Yamauchi (1998).
    """
    rows, columns = labels.shape
    around = np.full((rows + 2, columns + 2), OCCUPIED, dtype=np.uint8)
    around[1:-1, 1:-1] = labels

    def shifted(down: int, across: int) -> NDArray[np.uint8]:
        return around[1 + down : 1 + down + rows, 1 + across : 1 + across + columns]

    open_to = np.zeros((rows, columns), dtype=np.bool_)
    for down, across in ((0, 1), (1, 0), (0, -1), (-1, 0)):
        open_to |= shifted(down, across) == UNKNOWN
    if neighbours == 8:
        for down, across in ((1, 1), (1, -1), (-1, 1), (-1, -1)):
            hidden = (shifted(down, 0) == OCCUPIED) & (shifted(0, across) == OCCUPIED)
            open_to |= (shifted(down, across) == UNKNOWN) & ~hidden
    open_to &= labels == FREE
    return open_to


def _robots_at(run: Run, step: int) -> dict[str, NDArray[Any]] | None:
    """Columns of the ``steps`` table at a step, or None when they were not recorded."""
    import polars as pl

    from swarmscout.recording.tables import LEVELS

    if "steps" not in LEVELS[run.level]:
        return None
    rows = run.steps.filter(pl.col("step") == step)
    return {name: rows[name].to_numpy() for name in ("x_m", "y_m", "mode", "alive", "destination")}


def _window(
    run: Run, labels: NDArray[np.uint8], robots: dict[str, NDArray[Any]] | None
) -> tuple[float, float, float, float]:
    """What to show in metres: all that is known, all robots, and a margin."""
    points = [run.frame.centres_of(np.argwhere(labels != UNKNOWN)), run.stations_m]
    if robots is not None:
        points.append(np.column_stack((robots["x_m"], robots["y_m"])))
    known = np.concatenate(points)
    if not len(known):
        return run.frame.extent
    (left, bottom), (right, top) = known.min(axis=0) - _MARGIN_M, known.max(axis=0) + _MARGIN_M
    return float(left), float(right), float(bottom), float(top)


def _draw_swarm(
    axes: Axes, run: Run, robots: dict[str, NDArray[Any]] | None, points_per_m: float
) -> None:
    """Stations, destinations and robots; sizes follow the scale but stay legible."""
    axes.plot(
        *run.stations_m.T, linestyle="none", marker="P", markersize=11, zorder=3,
        markerfacecolor=CHARGE_GREEN, markeredgecolor="black", label="charging station",
    )  # fmt: skip
    if robots is None:
        return
    charging = robots["mode"] == "CHR"
    # A robot on its way to charge has left its team: what it headed for before is nobody's target.
    cells = np.unique(robots["destination"][robots["alive"] & ~charging])
    targets = run.frame.centres_of(run.frame.unflat_many(cells[cells >= 0]))
    ring = float(np.clip(2.0 * run.frame.cell_m * points_per_m, 9.0, 22.0))
    axes.plot(
        *targets.T, linestyle="none", marker=_ring_of_dots(), markersize=ring, zorder=4,
        color=DESTINATION_PURPLE, markeredgewidth=0.0, label="destination",
    )  # fmt: skip
    dot = float(np.clip(2.0 * run.scenario.body.radius_m * points_per_m, 6.0, 12.0))
    for chosen, colour, label in (
        (robots["alive"] & ~charging, EXPLORE_RED, "robot (EXP)"),
        (robots["alive"] & charging, CHARGE_GREEN, "robot (CHR)"),
        (~robots["alive"], STRANDED_BLUE, "robot (stranded)"),
    ):
        if chosen.any():
            axes.plot(
                robots["x_m"][chosen], robots["y_m"][chosen], linestyle="none", marker="o",
                markersize=dot, zorder=5, markerfacecolor=colour, markeredgecolor="white",
                markeredgewidth=0.4, label=label,
            )  # fmt: skip


def _ring_of_dots() -> Any:
    """A marker: eight dots on a circle."""
    from matplotlib.path import Path as Outline

    angles = np.arange(8) * (np.pi / 4)
    centres = np.column_stack((np.cos(angles), np.sin(angles)))
    dot = Outline.circle(radius=0.2)
    return Outline.make_compound_path(
        *(Outline(dot.vertices + centre, dot.codes) for centre in centres)
    )


def _title(run: Run, step: int) -> str:
    """World, number of robots and rule; below them step, and explored area if it is on record."""
    from swarmscout.recording.tables import LEVELS

    count = run.scenario.robots
    facts = run.facts.get("world")
    world = facts.get("name") if isinstance(facts, Mapping) else None
    # A file's path is too long for a title.
    rule = Path(run.scenario.destinations).name
    heads = [_brief(str(world or run.scenario.world)), f"{count} robot{'' if count == 1 else 's'}"]
    words = [f"step {step}"]
    if "coverage" in LEVELS[run.level]:
        rows = run.coverage
        explored = rows["explored_m2"][int(rows["step"].search_sorted(step))]
        words.append(f"{explored:.0f} m² explored")
    elif run.summary is not None:
        words.append(f"{run.summary['explored_m2']:.0f} m² explored")
    return " · ".join([*heads, _brief(rule)]) + "\n" + " · ".join(words)


def _brief(name: str) -> str:
    """A name that fits into a title; ``$`` would start a formula."""
    return (name if len(name) <= 30 else f"{name[:29]}…").replace("$", r"\$")
