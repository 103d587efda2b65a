"""All figures of a run, by name."""

from __future__ import annotations

import io
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from swarmscout.core.errors import RunError, ViewError, did_you_mean
from swarmscout.recording.table_files import write_whole
from swarmscout.viewing.figures.caves import cave_and_map, cave_overview
from swarmscout.viewing.figures.curves import explored_area
from swarmscout.viewing.figures.maps import growing_map, team_map
from swarmscout.viewing.figures.sensor import sensor_fan
from swarmscout.viewing.figures.style import print_style
from swarmscout.viewing.replay import Curve, Replay

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from swarmscout.recording.run import Run

__all__ = ["FIGURES", "FORMS", "figures_of", "make_figures"]

FIGURES: dict[str, Callable[[Any, int], Figure]] = {
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
    return tuple(FIGURES) if "steps" in run.tables else _OF_CURVES


def make_figures(
    run: Run,
    folder: str | Path,
    *,
    names: Sequence[str] = tuple(FIGURES),
    form: str = "png",
    step: int | None = None,
    robot: int | None = None,
    dpi: int = DPI,
) -> list[Path]:
    """Draw figures of a run; the same run gives the same bytes.

    Args:
        run: recorded with ``record="full"``.
        folder: where to; it is made if need be.
        names: which of :data:`FIGURES`.
        form: ``png``, ``svg`` or ``pdf``.
        step: the moment to show; None for the last.
        robot: whose map to show, and whose rays; None for the swarm's map.
        dpi: dots per inch, of PNG and of pictures inside the others.

    Returns:
        The files.

    Raises:
        RunError: there is no such step or robot, the run cannot be shown, or a file cannot be
            written.
        ViewError: there is no such figure, form or resolution.

    Example:
        >>> make_figures(Run.open("runs/mine"), "figures", form="pdf")  # doctest: +SKIP
    """
    for name in names:
        if name not in FIGURES:
            raise ViewError(f"there is no figure '{name}': {did_you_mean(name, FIGURES)}")
    if form not in FORMS:
        raise ViewError(f"figures cannot be '{form}': {did_you_mean(form, FORMS)}")
    if not 30 <= dpi <= 1200:
        raise ViewError(f"{dpi} dots per inch: give 30 to 1200")
    of_curves = "steps" not in run.tables and {*names} <= {*_OF_CURVES}
    replay = Curve(run) if of_curves else Replay(run, robot)
    at = replay.last if step is None else step
    replay.moment(at)  # Before anything slow: is there such a step?
    out = Path(folder)
    try:
        out.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise RunError(f"cannot make folder '{out}': {error.strerror or error}") from None
    files = []
    for name in names:
        with print_style():
            packed = io.BytesIO()
            # No date: the same run gives the same bytes.
            nothing = {"svg": {"Date": None}, "pdf": {"CreationDate": None}}.get(form)
            FIGURES[name](replay, at).savefig(packed, format=form, dpi=dpi, metadata=nothing)
        files.append(out / f"{name}.{form}")
        write_whole(files[-1], packed.getvalue())
    return files
