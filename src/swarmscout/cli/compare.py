"""``swarmscout compare``: a quick look at a few runs."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import Parameter

if TYPE_CHECKING:
    from swarmscout.recording.run import Run
    from swarmscout.studies.run_comparison import Beside

__all__ = ["compare"]

_FIGURES = {
    "explored_m2": ("explored m²", "{:.1f}"),
    "explored_fraction": ("of reachable", "{:.1%}"),
    "overlap_ratio": ("seen twice", "{:.1%}"),
    "distance_m": ("driven m", "{:.0f}"),
    "turn_share": ("turns", "{:.1%}"),
    "blocked_share": ("blocked", "{:.1%}"),
    "charges": ("charges", "{}"),
    "stranded": ("stranded", "{}"),
}


def compare(
    *runs: Annotated[Path, Parameter(name="RUN")],
    picture: Annotated[Path | None, Parameter(metavar="FILE")] = None,
) -> int:
    """Put a few runs beside each other: what differs in them, and what they achieved.

    Runs in the same world with the same seed are taken as pairs, each with the first kind of run.
    For anything that is to be published run a study.

    Args:
        runs: two run folders or more.
        picture: also draw the explored-area curves into this .svg, .pdf or .png file.
    """
    from swarmscout.core.errors import RunError
    from swarmscout.recording.table_files import write_whole
    from swarmscout.studies.run_comparison import curves_beside, runs_beside

    kind = "" if picture is None else picture.suffix.lower().removeprefix(".")
    if picture is not None and kind not in ("svg", "pdf", "png"):
        raise RunError(f"--picture '{picture}': the file must end in .svg, .pdf or .png")
    beside = runs_beside(runs)
    _print_table(beside)
    for gain in beside.gains:
        _print_gain(gain, beside.baseline)
    if picture is not None:
        from swarmscout.studies.report_render import figure_bytes

        write_whole(picture, figure_bytes(curves_beside(beside), kind))
        print(f"picture: {picture}")
    return 0


def _print_table(beside: Beside) -> None:
    heads = ["run", *beside.differing, "steps", *(name for name, _ in _FIGURES.values())]
    rows = [
        [name, *(str(value) for value in keys.values()), *_figures(run)]
        for name, keys, run in zip(beside.names, beside.keys, beside.runs, strict=True)
    ]
    widths = [max(len(row[at]) for row in [heads, *rows]) for at in range(len(heads))]
    words = 1 + len(beside.differing)
    for row in [heads, *rows]:
        cells = [
            f"{cell:<{width}}" if at < words else f"{cell:>{width}}"
            for at, (cell, width) in enumerate(zip(row, widths, strict=True))
        ]
        print("  ".join(cells).rstrip())


def _figures(run: Run) -> list[str]:
    from swarmscout.studies.run_comparison import explored_m2

    figures: dict[str, Any] = dict(run.summary or {"explored_m2": explored_m2(run)})
    steps = f"{run.last_step}" + ("" if run.finished else " (not finished)")
    told = [
        text.format(figures[key]) if figures.get(key) is not None else "–"
        for key, (_, text) in _FIGURES.items()
    ]
    return [steps, *told]


def _print_gain(gain: Any, baseline: str) -> None:
    from swarmscout.studies.formatting import with_interval
    from swarmscout.studies.intervals import FEW_UNITS

    pairs = f"{gain.pairs} pair{'s' if gain.pairs > 1 else ''}"
    print(
        f"{gain.label} over {baseline}: {with_interval(gain.ratio)} times, "
        f"{with_interval(gain.difference, sign=True)} m² ({pairs})"
    )
    if gain.difference.units < FEW_UNITS:
        print(f"  {pairs}: too few to conclude anything; swarmscout study runs more")
