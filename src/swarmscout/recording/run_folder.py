"""Where a run goes: claiming a folder without ever touching what a user has in one."""

from __future__ import annotations

import contextlib
import re
from pathlib import Path

from swarmscout.core.errors import RunError
from swarmscout.core.paths import expanded
from swarmscout.mission.scenario import Scenario

__all__ = ["as_path", "claim_folder", "claim_next_free", "default_name", "release_folder"]


def default_name(scenario: Scenario) -> str:
    """A run's name: ``<world>-<selector>-n<robots>-s<seed>``.

    Example:
        >>> default_name(Scenario(world="maps/My cave.yaml", destinations="my.py:Far", robots=4))
        'My-cave-Far-n4-s0'
    """
    world = Path(scenario.world)
    # A world folder's name may hold a dot; a file's last suffix is no part of its name.
    where = world.stem if world.suffix and not world.is_dir() else world.name
    selector = scenario.destinations.rpartition(":")[2]
    name = f"{where}-{selector}-n{scenario.robots}-s{scenario.seed}"
    return re.sub(r"[^A-Za-z0-9._-]+", "-", name).strip("-.")


def as_path(folder: object) -> Path:
    """A run's folder as a path.

    Raises:
        RunError: it is neither a text nor a path, or an empty text.
    """
    if not isinstance(folder, str | Path) or not str(folder):
        shown = "''" if folder == "" else f"a {type(folder).__name__}"
        raise RunError(f"a run's folder is given by its path, not by {shown}")
    return expanded(folder)


def claim_folder(path: Path) -> Path:
    """Make the folder of a new run.

    An empty folder may exist already; a folder with anything in it is refused, whatever it is:
    nothing of a user's is overwritten, mixed or removed.

    Returns:
        The folder.

    Raises:
        RunError: something is there already, or the folder cannot be made.
    """
    try:
        path.mkdir(parents=True, exist_ok=True)
        taken = any(path.iterdir())
    except FileExistsError:
        raise RunError(f"'{path}' is a file: a run needs a folder of its own") from None
    except OSError as error:
        raise RunError(f"cannot make the run folder '{path}': {error.strerror}") from None
    if taken:
        other = _next_free(path if path.name else Path("runs/mine"))
        raise RunError(f"folder '{path}' is not empty: give a new one, for example '{other}'")
    return path


def claim_next_free(path: Path) -> Path:
    """Make a folder for a run: ``path``, or with -2, -3 … behind it when that exists.

    Raises:
        RunError: the folder cannot be made.
    """
    while True:
        free = _next_free(path)
        try:
            free.parent.mkdir(parents=True, exist_ok=True)
            free.mkdir()
        except FileExistsError:
            if free.parent.is_dir():
                continue  # Another mission was quicker with the same name.
            raise RunError(f"'{free.parent}' is a file: runs need a folder") from None
        except OSError as error:
            raise RunError(f"cannot make the run folder '{free}': {error.strerror}") from None
        return free


def release_folder(path: Path) -> None:
    """Give up a claimed folder in which nothing was written; anything else stays."""
    with contextlib.suppress(OSError):
        path.rmdir()


def _next_free(path: Path) -> Path:
    free, number = path, 2
    while free.exists() or free.is_symlink():
        free = path.with_name(f"{path.name}-{number}")
        number += 1
    return free
