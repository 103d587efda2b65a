"""Copies of the files of a user's own rules, so that a run can be run again."""

from __future__ import annotations

from pathlib import Path

from swarmscout.core.errors import RunError
from swarmscout.mission.plug_ins import PLUG_INS
from swarmscout.mission.scenario import Scenario
from swarmscout.recording.table_files import write_whole

__all__ = ["keep_rules"]


def keep_rules(scenario: Scenario, base: Path | None, folder: Path) -> Scenario:
    """Copy the files of all plug-ins that a user wrote.

    Args:
        scenario: the mission's scenario.
        base: the mission's folder for relative paths.
        folder: the run's folder.

    Returns:
        The scenario to write into the run: it names the copies, relative to the run's folder,
        and other rules as before.

    Raises:
        RunError: a copy cannot be written.
    """
    copied: dict[str, Path] = {}
    for kind in PLUG_INS:
        rule = kind.name(scenario)
        file = kind.registry.file(rule, base)
        if file is None:
            continue
        # Two files of the same name can lie in different folders.
        name = file.name
        if copied.setdefault(name, file.resolve()) != file.resolve():
            name = f"{kind.registry.noun}_{name}"
            copied[name] = file.resolve()
        _copy(file, folder / name)
        scenario = kind.renamed(scenario, f"{name}:{rule.rpartition(':')[2]}")
    return scenario


def _copy(file: Path, to: Path) -> None:
    try:
        source = file.read_bytes()
    except OSError as error:
        raise RunError(f"cannot read '{file}': {error.strerror or error}") from None
    write_whole(to, source)
