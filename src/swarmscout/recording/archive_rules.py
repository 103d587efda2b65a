"""Rules of a user's own: their files are copied into the run's folder, so that it runs again."""

from __future__ import annotations

from pathlib import Path

from swarmscout.core.errors import RunError
from swarmscout.destinations.registry import SELECTORS
from swarmscout.mission.scenario import Scenario
from swarmscout.recording.table_files import write_whole
from swarmscout.robots.sensors.registry import SENSORS
from swarmscout.teams.registry import POLICIES

__all__ = ["keep_rules"]


def keep_rules(scenario: Scenario, base: Path | None, folder: Path) -> Scenario:
    """Copy the files of a selector, a policy and a sensor that a user wrote.

    Args:
        scenario: the mission's scenario.
        base: the folder that the mission looked for relative files in.
        folder: the run's folder.

    Returns:
        The scenario to write into the run: it names the copies, relative to the run's folder.
        Other rules stay as they were given.

    Raises:
        RunError: a copy cannot be written.
    """
    copied: dict[str, Path] = {}

    def keep(kind: str, rule: str, file: Path | None) -> str:
        if file is None:
            return rule
        # Two files of the same name can lie in different folders.
        name = file.name
        if copied.setdefault(name, file.resolve()) != file.resolve():
            name = f"{kind}_{name}"
            copied[name] = file.resolve()
        _copy(file, folder / name)
        return f"{name}:{rule.rpartition(':')[2]}"

    selector, policy, model = scenario.destinations, scenario.teams.policy, scenario.sensor.model
    selector = keep("selector", selector, SELECTORS.file(selector, base))
    policy = keep("policy", policy, POLICIES.file(policy, base))
    model = keep("sensor", model, SENSORS.file(model, base))
    return scenario.model_copy(
        update={
            "destinations": selector,
            "teams": scenario.teams.model_copy(update={"policy": policy}),
            "sensor": scenario.sensor.model_copy(update={"model": model}),
        }
    )


def _copy(file: Path, to: Path) -> None:
    try:
        source = file.read_bytes()
    except OSError as error:
        raise RunError(f"cannot read '{file}': {error.strerror or error}") from None
    write_whole(to, source)
