"""Verifying a run: every file is read and compared with what was written."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from swarmscout.core.errors import RunError
from swarmscout.recording.decisions import TEXTS
from swarmscout.recording.run import Run
from swarmscout.recording.table_files import checked_bytes, leftovers

__all__ = ["Verdict", "verify_run"]


@dataclass
class Verdict:
    """What is found in a run's folder.

    Attributes:
        checked: number of checks made.
        faults: what is damaged, a line each.
        notes: what else there is to say, a line each.
    """

    checked: int = 0
    faults: list[str] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)

    def check(self, look: Callable[..., Any], *arguments: Any) -> Any:
        """Make one check; a RunError is a fault, and gives None."""
        self.checked += 1
        try:
            return look(*arguments)
        except RunError as error:
            if str(error) not in self.faults:
                self.faults.append(str(error))
        return None


def verify_run(path: str | Path) -> Verdict:
    """Read all of a run and compare it with its checksums.

    Args:
        path: the run's folder, of a finished mission or of a killed one.
    """
    found = Verdict()
    run: Run | None = found.check(Run.open, path)
    if run is None or run.path is None:
        return found
    for name in run.tables:
        found.check(run.table, name)
    for name, expected in run.facts["files"].items():
        found.check(_kept_file, run.path, name, expected)
    found.check(run.world)
    if run.finished:
        found.check(run.map_at)
    for name in sorted(_texts(run, found)):
        found.check(run.text, name)
    found.notes += [f"'{file}': left by a process that died" for file in leftovers(run.path)]
    if not (run.finished or found.faults):
        found.notes.append(f"the mission did not finish: steps 0 to {run.last_step} are kept")
    return found


def _kept_file(folder: Path, name: str, expected: str) -> None:
    file = folder / name
    if not file.resolve().is_relative_to(folder.resolve()):
        raise RunError(f"run '{folder}' is damaged: '{name}' lies outside its folder")
    checked_bytes(file, expected)


def _texts(run: Run, found: Verdict) -> set[str]:
    """Names of the texts that are there, or should be."""
    assert run.path is not None
    names = {file.stem for file in (run.path / TEXTS).glob("*.txt")}
    attempts = found.check(run.table, "attempts") if "attempts" in run.tables else None
    if attempts is not None:
        names |= {*attempts["prompt"], *attempts["answer"].drop_nulls()}
    return names
