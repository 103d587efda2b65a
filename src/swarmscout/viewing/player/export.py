"""A mission as one HTML file."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from swarmscout.core.errors import ViewError
from swarmscout.recording.table_files import write_whole
from swarmscout.viewing.player.beliefs import chosen_robots, packed_beliefs
from swarmscout.viewing.player.page import one_file
from swarmscout.viewing.player.recorded import player_data

if TYPE_CHECKING:
    from swarmscout.recording.run import Run

__all__ = ["export_page"]


def export_page(runs: Sequence[Run], file: str | Path, own_maps: str | None = None) -> Path:
    """Write a page that shows one run, or two side by side, without other files or a network.

    Args:
        runs: one run, or two.
        file: the page; its name ends in ``.html``.
        own_maps: the robots whose own maps the file holds, where maps differ: ``all``, ``none``,
            or robots' numbers as in ``0,3,7``; None: all, or none of a swarm of more than 100.

    Returns:
        The file.

    Raises:
        RunError: a run cannot be shown, a robot does not exist, or the file cannot be written.
        ViewError: the file's name does not end in ``.html``, or `own_maps` is not a selection.

    Example:
        >>> export_page([Run.open("runs/mine")], "mission.html")  # doctest: +SKIP
    """
    path = Path(file)
    if path.suffix.lower() not in (".html", ".htm"):
        raise ViewError(f"'{path}': a page's name ends in .html, for example '{path.stem}.html'")
    names = [run.path.resolve().name if run.path is not None else "mission" for run in runs]
    robots = [chosen_robots(run, own_maps) for run in runs]
    beliefs = [packed_beliefs(run, chosen) for run, chosen in zip(runs, robots, strict=True)]
    page = one_file(" | ".join(names), [player_data(run) for run in runs], beliefs)
    write_whole(path, page)
    return path
