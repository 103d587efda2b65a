"""All figures of a run, by name."""

from __future__ import annotations

import io
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from swarmscout.core.errors import RunError, ViewError, did_you_mean
from swarmscout.recording.table_files import write_whole
from swarmscout.viewing.drawing import print_style
from swarmscout.viewing.mission_figures.caves import cave_and_map, cave_overview
from swarmscout.viewing.mission_figures.maps import explored_area, growing_map, team_map
from swarmscout.viewing.mission_figures.sensor import sensor_fan
from swarmscout.viewing.replay import Curve, Replay

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from swarmscout.recording.run import Run

__all__ = ["FORMS", "MISSION_FIGURES", "figures_of", "make_figures"]

MISSION_FIGURES: dict[str, Callable[[Any, int], Figure]] = {
    "sensor-fan": sensor_fan,
    "team-map": team_map,
    "growing-map": growing_map,
    "explored-area": explored_area,
    "cave": cave_overview,
    "cave-and-map": cave_and_map,
}
_OF_CURVES = ("explored-area",)

FORMS = ("png", "svg", "pdf")
DPI = 200


def figures_of(run: Run) -> tuple[str, ...]:
    """Names of the figures that can be drawn of what was recorded of a run."""
    return tuple(MISSION_FIGURES) if "steps" in run.tables else _OF_CURVES


def make_figures(
    run: Run,
    folder: str | Path,
    *,
    names: Sequence[str] = tuple(MISSION_FIGURES),
    form: str = "png",
    step: int | None = None,
    robot: int | None = None,
    dpi: int = DPI,
) -> list[Path]:
    """Draw figures of a run; the same run gives the same bytes.

    Args:
        run: recorded with ``record="full"``.
        folder: where the files go; it is created if missing.
        names: some of :data:`MISSION_FIGURES`.
        form: ``png``, ``svg`` or ``pdf``.
        step: the moment to show; None for the last.
        robot: show this robot's map and rays; None for the swarm's map.
        dpi: dots per inch of PNG files and of images inside SVG and PDF.

    Returns:
        The files.

    Raises:
        RunError: the step or robot does not exist, the run cannot be shown, or a file cannot be
            written.
        ViewError: the figure, form or resolution does not exist.

    Example:
        >>> make_figures(Run.open("runs/mine"), "figures", form="pdf")  # doctest: +SKIP
    """
    for name in names:
        if name not in MISSION_FIGURES:
            raise ViewError(f"no figure is called '{name}': {did_you_mean(name, MISSION_FIGURES)}")
    if form not in FORMS:
        raise ViewError(f"figures cannot be written as '{form}': {did_you_mean(form, FORMS)}")
    if not 30 <= dpi <= 1200:
        raise ViewError(f"{dpi} dots per inch: choose 30 to 1200")
    of_curves = "steps" not in run.tables and {*names} <= {*_OF_CURVES}
    replay = Curve(run) if of_curves else Replay(run, robot)
    at = replay.last if step is None else step
    replay.moment(at)  # Fails before anything slow if the step does not exist.
    out = Path(folder)
    try:
        out.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise RunError(f"cannot create folder '{out}': {error.strerror or error}") from None
    files = []
    for name in names:
        with print_style():
            packed = io.BytesIO()
            # No date: the same run gives the same bytes.
            nothing = {"svg": {"Date": None}, "pdf": {"CreationDate": None}}.get(form)
            MISSION_FIGURES[name](replay, at).savefig(
                packed, format=form, dpi=dpi, metadata=nothing
            )
        files.append(out / f"{name}.{form}")
        write_whole(files[-1], packed.getvalue())
    return files
