"""A study's folder: the study's file, a run folder per mission, and a file per failure.

``missions/NAME`` appears by a rename once a mission has finished. While it runs, its folder is
``missions/.NAME-…``. A folder under a mission's name therefore holds a complete run, whichever
process was killed.
"""

from __future__ import annotations

import errno
import json
import os
import shutil
import tomllib
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from swarmscout.core.errors import RunError, StudyError
from swarmscout.recording.json_files import RUN
from swarmscout.recording.table_files import write_whole

__all__ = ["Failure", "StudyFolder", "is_run"]

_LOCK = ".lock"
_HELD_BY_ANOTHER = {errno.EWOULDBLOCK, errno.EAGAIN, errno.EACCES}


@dataclass(frozen=True, slots=True)
class Failure:
    """A mission that failed.

    Attributes:
        mission: its name.
        error: what went wrong, in one line.
        traceback: where, for a defect; empty for a known error.
    """

    mission: str
    error: str
    traceback: str = ""


def is_run(folder: Path) -> bool:
    """Whether a folder holds a run."""
    return (folder / RUN).is_file()


class StudyFolder:
    """Paths of a study, and what they hold.

    Args:
        path: the folder; it need not exist yet.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self.missions = path / "missions"
        self.failures = path / "failures"
        self.file = path / "study.toml"

    def run(self, name: str) -> Path:
        """Where a mission's run lies once it has finished."""
        return self.missions / name

    def finished(self) -> set[str]:
        """Names of the finished missions."""
        if not self.missions.is_dir():
            return set()
        names = (entry.name for entry in os.scandir(self.missions))
        return {name for name in names if not name.startswith(".") and is_run(self.run(name))}

    def failed(self) -> dict[str, Failure]:
        """The failed missions, by name."""
        found = {}
        for file in sorted(self.failures.glob("*.json")):
            try:
                data = json.loads(file.read_text(encoding="utf-8"))
                found[file.stem] = Failure(file.stem, data["error"], data["traceback"])
            except (OSError, ValueError, KeyError, TypeError):
                found[file.stem] = Failure(file.stem, f"'{file}' is damaged")
        return found

    def note_failure(self, failure: Failure) -> None:
        """Keep a failure.

        Raises:
            StudyError: it cannot be written.
        """
        data = {"error": failure.error, "traceback": failure.traceback}
        text = json.dumps(data, indent=2, ensure_ascii=False) + "\n"
        try:
            self.failures.mkdir(exist_ok=True)
            write_whole(self.failures / f"{failure.mission}.json", text.encode(errors="replace"))
        except (OSError, RunError) as error:
            raise StudyError(f"cannot keep a failure: {error}") from None

    def forget_failure(self, name: str) -> None:
        """Remove the failure of a mission that has now succeeded."""
        (self.failures / f"{name}.json").unlink(missing_ok=True)

    @contextmanager
    def claimed(self, name: str, text: str) -> Iterator[None]:
        """Take the folder for one study and one process, and keep the study's file in it.

        Nothing in the folder changes unless the claim succeeds.

        Args:
            name: the study's name.
            text: its file.

        Raises:
            StudyError: the folder holds something else, another process runs the study, or the
                folder cannot be written.
        """
        self._check(name)
        try:
            self.missions.mkdir(parents=True, exist_ok=True)
        except (FileExistsError, NotADirectoryError):
            raise StudyError(f"'{self.path}' is a file: a study needs a folder") from None
        except OSError as error:
            raise StudyError(f"cannot make '{self.missions}': {error.strerror or error}") from None
        with self._locked() as alone:
            self._check(name)  # Another process may have come first.
            try:
                write_whole(self.file, text.encode())
            except RunError as error:
                raise StudyError(str(error)) from None
            if alone:
                self._sweep()
            yield

    def _check(self, name: str) -> None:
        """Refuse a folder that holds something other than this study."""
        if not self.path.is_dir():
            return
        if not self.file.exists():
            # A process that is just taking the folder has made these two.
            others = {entry.name for entry in os.scandir(self.path)} - {_LOCK, "missions"}
            if others or (self.missions.exists() and any(os.scandir(self.missions))):
                raise StudyError(
                    f"'{self.path}' is not empty and not a study's folder: give a new one"
                )
            return
        try:
            other = tomllib.loads(self.file.read_text(encoding="utf-8")).get("name")
        except (OSError, ValueError):
            raise StudyError(f"'{self.file}' is damaged: remove it to go on here") from None
        if other != name:
            raise StudyError(f"'{self.path}' holds the study '{other}': give another folder")

    @contextmanager
    def _locked(self) -> Iterator[bool]:
        """Hold the folder's lock, which ends with the process; whether there is one."""
        try:
            import fcntl
        except ImportError:  # Not on Windows.
            yield False
            return
        try:
            file = open(self.path / _LOCK, "a")  # noqa: SIM115 - closed below
        except OSError as error:
            raise StudyError(f"cannot write in '{self.path}': {error.strerror}") from None
        with file:
            alone = True
            try:
                fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except OSError as error:
                if error.errno in _HELD_BY_ANOTHER:
                    raise StudyError(
                        f"another process is running the study in '{self.path}'"
                    ) from None
                alone = False
                warnings.warn(
                    f"'{self.path}' is on a file system without locks ({error.strerror}): run this "
                    "study from one process at a time",
                    stacklevel=5,
                )
            yield alone

    def _sweep(self) -> None:
        """Remove what killed missions left behind; only for the process that holds the lock."""
        for entry in os.scandir(self.missions):
            if entry.name.startswith("."):
                shutil.rmtree(entry.path, ignore_errors=True)
