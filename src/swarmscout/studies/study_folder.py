"""A study's folder: where its missions, its failures and what is made of them lie.

``missions/NAME`` appears whole, by a rename, when a mission has finished; while it runs its folder
is ``missions/.NAME-…``. So whatever is killed, what stands under a mission's name counts.
"""

from __future__ import annotations

import json
import os
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from swarmscout.core.errors import RunError, StudyError
from swarmscout.recording.table_files import write_whole

__all__ = ["Failure", "StudyFolder"]


class Failure:
    """A mission that failed.

    Attributes:
        mission: its name.
        error: what went wrong, in one line.
        traceback: where, for a defect; empty for a known error.
    """

    def __init__(self, mission: str, error: str, traceback: str = "") -> None:
        self.mission = mission
        self.error = error
        self.traceback = traceback


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
        return {entry.name for entry in os.scandir(self.missions) if not entry.name.startswith(".")}

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
        try:
            self.failures.mkdir(exist_ok=True)
            write_whole(self.failures / f"{failure.mission}.json", _json(data))
        except (OSError, RunError) as error:
            raise StudyError(f"cannot keep a failure: {error}") from None

    def forget_failure(self, name: str) -> None:
        """A mission that failed before has succeeded, or is to be tried again."""
        (self.failures / f"{name}.json").unlink(missing_ok=True)

    def claim(self, name: str, text: str) -> None:
        """Make the folder, or take the one that there is, and keep the study's file in it.

        Args:
            name: the study's name.
            text: its file.

        Raises:
            StudyError: the folder holds something else, or cannot be written.
        """
        try:
            self.missions.mkdir(parents=True, exist_ok=self._is_ours(name))
            write_whole(self.file, text.encode())
        except (FileExistsError, NotADirectoryError):
            raise StudyError(f"'{self.path}' is a file: a study needs a folder") from None
        except OSError as error:
            raise StudyError(f"cannot make '{self.missions}': {error.strerror or error}") from None
        except RunError as error:
            raise StudyError(str(error)) from None

    def _is_ours(self, name: str) -> bool:
        import tomllib

        if not self.path.is_dir() or not any(self.path.iterdir()):
            return True
        if not self.file.exists():
            raise StudyError(f"'{self.path}' is not empty and no study's folder: give a new one")
        try:
            other = tomllib.loads(self.file.read_text(encoding="utf-8")).get("name")
        except (OSError, ValueError):
            raise StudyError(f"'{self.file}' is damaged: remove it to go on here") from None
        if other != name:
            raise StudyError(f"'{self.path}' holds the study '{other}': give another folder")
        return True

    @contextmanager
    def locked(self) -> Iterator[None]:
        """One process at a time runs a study in a folder; the lock goes with the process.

        Raises:
            StudyError: another process runs it.
        """
        try:
            import fcntl
        except ImportError:  # Not on Windows: two processes would do the same work twice there.
            yield
            return
        with open(self.path / ".lock", "w") as file:
            try:
                fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except OSError:
                raise StudyError(f"another process is running the study in '{self.path}'") from None
            yield

    def sweep(self) -> None:
        """Remove what killed missions left behind; call it only while :meth:`locked`."""
        for entry in os.scandir(self.missions):
            if entry.name.startswith("."):
                shutil.rmtree(entry.path, ignore_errors=True)


def _json(data: Any) -> bytes:
    return (json.dumps(data, indent=2, ensure_ascii=False) + "\n").encode()
