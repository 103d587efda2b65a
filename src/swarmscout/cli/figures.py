"""``swarmscout figures``: figures of a mission, for print."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Literal

from cyclopts import Parameter

__all__ = ["figures"]


def figures(
    run: Path,
    /,
    *,
    only: Annotated[
        tuple[str, ...], Parameter(negative=(), metavar="NAME", show_default=False)
    ] = (),
    out: Annotated[Path | None, Parameter(name=["--out", "-o"], metavar="DIR")] = None,
    format: Literal["png", "svg", "pdf"] = "png",
    step: int | None = None,
    robot: int | None = None,
    dpi: int = 200,
) -> int:
    """Draw figures of a mission for print, in the style of the paper's.

    They are sensor-fan, team-map, growing-map, explored-area, cave and cave-and-map.

    Args:
        run: a run's folder, of a finished mission or of a killed one.
        only: draw this figure only; may be repeated.
        out: folder for the figures; default: figures/ in the run's folder.
        format: png, svg or pdf.
        step: the step to show; default: the last.
        robot: show the map of this robot, where robots have their own, and its rays.
        dpi: dots per inch.
    """
    from swarmscout.recording.run import Run
    from swarmscout.viewing.mission_figures.catalogue import (
        MISSION_FIGURES,
        figures_of,
        make_figures,
    )

    opened = Run.open(run)
    folder = run / "figures" if out is None else out
    names = only or figures_of(opened)
    drawn = make_figures(opened, folder, names=names, form=format, step=step, robot=robot, dpi=dpi)
    for file in drawn:
        print(f"figure: {file}")
    if lacking := [name for name in MISSION_FIGURES if not only and name not in names]:
        print(f"not drawn, for the run's level is '{opened.level}': {', '.join(lacking)}")
    return 0
