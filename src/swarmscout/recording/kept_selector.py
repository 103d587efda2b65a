"""The rule of a run: a selector's file is copied into the run's folder, so that it runs again."""

from __future__ import annotations

from pathlib import Path

from swarmscout.core.errors import RunError
from swarmscout.destinations.registry import selector_file
from swarmscout.mission.scenario import Scenario
from swarmscout.recording.parts import write_whole

__all__ = ["keep_selector"]


def keep_selector(scenario: Scenario, base: Path | None, folder: Path) -> Scenario:
    """Copy the file of a selector that a user wrote.

    Args:
        scenario: the mission's scenario.
        base: the folder that the mission looked for relative files in.
        folder: the run's folder.

    Returns:
        The scenario to write into the run: it names the copy, relative to the run's folder. Under
        any other selector it is the one that was given.

    Raises:
        RunError: the copy cannot be written.
    """
    file = selector_file(scenario.destinations, base)
    if file is None:
        return scenario
    try:
        source = file.read_bytes()
    except OSError as error:
        raise RunError(f"cannot read '{file}': {error.strerror or error}") from None
    write_whole(folder / file.name, source)
    name = scenario.destinations.rpartition(":")[2]
    return scenario.model_copy(update={"destinations": f"{file.name}:{name}"})
