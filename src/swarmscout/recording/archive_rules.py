"""Copies of the files of a user's own rules, so that a run can be run again."""

from __future__ import annotations

from pathlib import Path

from swarmscout.core.errors import RunError
from swarmscout.destinations.registry import SELECTORS
from swarmscout.mission.scenario import Scenario
from swarmscout.recording.table_files import write_whole
from swarmscout.teams.registry import POLICIES

__all__ = ["keep_rules"]


def keep_rules(scenario: Scenario, base: Path | None, folder: Path) -> Scenario:
    """Copy the files of a selector and a policy that a user wrote.

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
    selector, policy = scenario.destinations, scenario.teams.policy
    rule = SELECTORS.file(selector, base)
    if rule is not None:
        _copy(rule, folder / rule.name)
        named = {"destinations": f"{rule.name}:{selector.rpartition(':')[2]}"}
        scenario = scenario.model_copy(update=named)
    sizes = POLICIES.file(policy, base)
    if sizes is not None:
        # Two files of the same name can lie in different folders.
        clash = rule is not None and rule.name == sizes.name and rule.resolve() != sizes.resolve()
        name = f"policy_{sizes.name}" if clash else sizes.name
        _copy(sizes, folder / name)
        teams = scenario.teams.model_copy(update={"policy": f"{name}:{policy.rpartition(':')[2]}"})
        scenario = scenario.model_copy(update={"teams": teams})
    return scenario


def _copy(file: Path, to: Path) -> None:
    try:
        source = file.read_bytes()
    except OSError as error:
        raise RunError(f"cannot read '{file}': {error.strerror or error}") from None
    write_whole(to, source)
