"""A mission as one HTML file."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from swarmscout.core.errors import ViewError
from swarmscout.recording.parts import write_whole
from swarmscout.viewing.player.page import one_file
from swarmscout.viewing.player.recorded import player_data

if TYPE_CHECKING:
    from swarmscout.recording.run import Run

__all__ = ["export_page"]


def export_page(runs: Sequence[Run], file: str | Path) -> Path:
    """Write one page that shows one run, or two side by side; it needs no other file and no net.

    Args:
        runs: one run, or two.
        file: where to; its name ends in ``.html``.

    Returns:
        The file.

    Raises:
        RunError: a run cannot be shown, or the file cannot be written.
        ViewError: the file has another kind of name.

    Example:
        >>> export_page([Run.open("runs/mine")], "mission.html")  # doctest: +SKIP
    """
    path = Path(file)
    if path.suffix.lower() not in (".html", ".htm"):
        raise ViewError(f"'{path}': a page's name ends in .html, for example '{path.stem}.html'")
    names = [run.path.resolve().name if run.path is not None else "mission" for run in runs]
    write_whole(path, one_file(" | ".join(names), [player_data(run) for run in runs]))
    return path
