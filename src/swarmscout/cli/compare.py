"""``swarmscout compare``: a quick look at a few runs."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import Parameter

if TYPE_CHECKING:
    from swarmscout.cli.run_comparison import ComparedRun, Gain, RunComparison

__all__ = ["compare"]

_MEASURES = {
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
    """Compare a few runs: what differs in them, and what they achieved.

    Runs in the same world with the same seed are paired with the first kind of run. For results to
    publish, run a study.

    Args:
        runs: two run folders or more.
        picture: also draw the explored-area curves into this .svg, .pdf or .png file.
    """
    from swarmscout.cli.run_comparison import compare_runs, curves_of_runs
    from swarmscout.core.errors import RunError
    from swarmscout.recording.table_files import write_whole

    kind = "" if picture is None else picture.suffix.lower().removeprefix(".")
    if picture is not None and kind not in ("svg", "pdf", "png"):
        raise RunError(f"--picture '{picture}': the file must end in .svg, .pdf or .png")
    comparison = compare_runs(runs)
    _print_table(comparison)
    if len(comparison.rules_versions) > 1:
        versions = ", ".join(map(str, comparison.rules_versions))
        print(
            f"warning: these runs were made by different rules (versions {versions}), so their "
            "numbers are not comparable"
        )
    for gain in comparison.gains:
        _print_gain(gain, comparison.runs[0].kind)
    if picture is not None:
        from swarmscout.studies.report_render import figure_bytes

        write_whole(picture, figure_bytes(curves_of_runs(comparison), kind))
        print(f"picture: {picture}")
    return 0


def _print_table(comparison: RunComparison) -> None:
    """A row per run; on a terminal that is too narrow for it, a block of lines per run."""
    from shutil import get_terminal_size

    heads = ["run", *comparison.differing, "steps", *(name for name, _ in _MEASURES.values())]
    rows = [
        [each.path.name, *(str(value) for value in each.keys.values()), *_measures(each)]
        for each in comparison.runs
    ]
    widths = [max(len(row[at]) for row in [heads, *rows]) for at in range(len(heads))]
    if sum(widths) + 2 * len(widths) > get_terminal_size((10_000, 24)).columns:
        for row in rows:
            print(row[0])
            for head, cell in zip(heads[1:], row[1:], strict=True):
                print(f"  {head}: {cell}")
        return
    words = 1 + len(comparison.differing)
    for row in [heads, *rows]:
        cells = [
            f"{cell:<{width}}" if at < words else f"{cell:>{width}}"
            for at, (cell, width) in enumerate(zip(row, widths, strict=True))
        ]
        print("  ".join(cells).rstrip())


def _measures(each: ComparedRun) -> list[str]:
    found: dict[str, Any] = dict(each.run.summary or {"explored_m2": each.explored_m2})
    steps = f"{each.run.last_step}" + ("" if each.run.finished else " (not finished)")
    shown = [
        text.format(found[key]) if found.get(key) is not None else "–"
        for key, (_, text) in _MEASURES.items()
    ]
    return [steps, *shown]


def _print_gain(gain: Gain, baseline: str) -> None:
    from swarmscout.studies.formatting import with_interval
    from swarmscout.studies.intervals import FEW_UNITS

    pairs = f"{gain.pairs} pair{'s' if gain.pairs > 1 else ''}"
    print(
        f"{gain.label} over {baseline}: {with_interval(gain.ratio)} times, "
        f"{with_interval(gain.difference, sign=True)} m² ({pairs})"
    )
    if gain.difference.units < FEW_UNITS:
        print(f"  {pairs}: too few to conclude anything; swarmscout study runs more")
