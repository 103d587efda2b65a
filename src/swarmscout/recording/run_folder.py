"""Claiming the folder of a run without touching anything that is already there."""

from __future__ import annotations

import contextlib
import os
import re
from pathlib import Path

from swarmscout.core.errors import RunError
from swarmscout.core.paths import expanded
from swarmscout.mission.scenario import Scenario

__all__ = [
    "SCENARIO",
    "as_path",
    "claim_folder",
    "claim_for_writing",
    "claim_next_free",
    "default_name",
    "release_folder",
]

SCENARIO = "scenario.toml"
"""The first file of a run."""


def default_name(scenario: Scenario) -> str:
    """A run's name: ``<world>-<selector>-n<robots>-s<seed>``.

    Example:
        >>> default_name(Scenario(world="maps/My cave.yaml", destinations="my.py:Far", robots=4))
        'My-cave-Far-n4-s0'
    """
    world = Path(scenario.world)
    # A world folder's name may contain a dot; only a file has a suffix to take off.
    where = world.stem if world.suffix and not world.is_dir() else world.name
    selector = scenario.destinations.rpartition(":")[2]
    name = f"{where}-{selector}-n{scenario.robots}-s{scenario.seed}"
    return re.sub(r"[^A-Za-z0-9._-]+", "-", name).strip("-.")


def as_path(folder: object) -> Path:
    """A run's folder as a path.

    Raises:
        RunError: it is neither a text nor a path, or it is empty.
    """
    if not isinstance(folder, str | Path) or not str(folder):
        shown = "''" if folder == "" else f"a {type(folder).__name__}"
        raise RunError(f"a run's folder is given by its path, not by {shown}")
    return expanded(folder)


def claim_folder(path: Path) -> Path:
    """Make the folder of a new run.

    An empty folder may exist already. A folder with anything in it is refused, so that nothing is
    overwritten, mixed or removed.

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
        raise RunError(f"folder '{path}' is not empty: {_another(path)}")
    return path


def claim_for_writing(path: Path) -> None:
    """Claim the folder of a run that is about to be written: of two processes one gets it.

    The claim is the file ``scenario.toml``, empty at first, which only one process can create.

    Raises:
        RunError: something is there already, or another process is recording into the folder.
    """
    claim_folder(path)
    first = path / SCENARIO
    try:
        os.close(os.open(first, os.O_CREAT | os.O_EXCL | os.O_WRONLY, 0o666))
    except FileExistsError:
        raise RunError(
            f"another process is recording into folder '{path}': {_another(path)}"
        ) from None
    except OSError as error:
        raise RunError(f"cannot write '{first}': {error.strerror or error}") from None
    # A run that began and ended between the two checks above.
    if any(file.name != SCENARIO for file in path.iterdir()):
        first.unlink(missing_ok=True)
        raise RunError(f"folder '{path}' is not empty: {_another(path)}")


def claim_next_free(path: Path) -> Path:
    """Make a folder for a run: ``path``, or ``path-2``, ``path-3`` … when that exists.

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
    """Remove a claimed folder in which nothing was written; anything else stays."""
    with contextlib.suppress(OSError):
        path.rmdir()


def _another(path: Path) -> str:
    other = _next_free(path if path.name else Path("runs/mine"))
    return f"give a new one, for example '{other}'"


def _next_free(path: Path) -> Path:
    free, number = path, 2
    while free.exists() or free.is_symlink():
        free = path.with_name(f"{path.name}-{number}")
        number += 1
    return free
