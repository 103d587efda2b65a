"""Where a scenario names its plug-ins, and with which parameters they are made."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from swarmscout.core.errors import ScenarioError
from swarmscout.core.registry import IN_MEMORY, Registry
from swarmscout.destinations.registry import SELECTORS
from swarmscout.mission.scenario import Scenario
from swarmscout.robots.radio.parameters import radio_parameters
from swarmscout.robots.radio.registry import RADIOS
from swarmscout.robots.sensors.parameters import sensor_parameters
from swarmscout.robots.sensors.registry import SENSORS
from swarmscout.tasks.parameters import task_parameters
from swarmscout.tasks.registry import TASKS
from swarmscout.teams.registry import POLICIES

__all__ = ["PLUG_INS", "POLICY", "RADIO", "SELECTOR", "SENSOR", "TASK", "PlugIn", "complete"]


@dataclass(frozen=True)
class PlugIn:
    """One kind of plug-in in a scenario.

    Attributes:
        section: the section that names it; empty for the scenario itself.
        key: the key in it.
        registry: the kind's.
        parameters: what its class is made with.
        parameters_section: the section of these; empty for `section`.
    """

    section: str
    key: str
    registry: Registry[Any]
    parameters: Callable[[Scenario], dict[str, Any]]
    parameters_section: str = ""

    def name(self, scenario: Scenario) -> str:
        """The name or ``FILE.py:NAME`` in a scenario."""
        section = getattr(scenario, self.section) if self.section else scenario
        return str(getattr(section, self.key))

    def make(self, scenario: Scenario, base: Path | None) -> Any:
        """The plug-in that a scenario names.

        Args:
            scenario: names it. base: folder for its file.

        Raises:
            SwarmscoutError: the kind's own error: there is no such plug-in, or it does not take
                the scenario's parameters.
        """
        return self.registry.make(self.name(scenario), self.parameters(scenario), base)

    def renamed(self, scenario: Scenario, name: str) -> Scenario:
        """A scenario with another name in this place."""
        if not self.section:
            return scenario.model_copy(update={self.key: name})
        section = getattr(scenario, self.section).model_copy(update={self.key: name})
        return scenario.model_copy(update={self.section: section})

    def handed_over(self, scenario: Scenario, plug_in: object) -> dict[str, Any]:
        """Keys of a scenario for a plug-in that was passed as an object.

        Raises:
            SwarmscoutError: the kind's own error: the object is something else.
        """
        self.registry.check_object(plug_in)
        named: dict[str, Any] = {self.key: IN_MEMORY + type(plug_in).__name__}
        if not self.parameters_section:
            return {self.section: named}
        if self.section:
            named = {self.section: {**getattr(scenario, self.section).model_dump(), **named}}
        return {**named, self.parameters_section: {}}


PLUG_INS = (
    PlugIn("", "destinations", SELECTORS, lambda scenario: scenario.selector, "selector"),
    PlugIn("teams", "policy", POLICIES, lambda scenario: scenario.policy, "policy"),
    PlugIn("sensor", "model", SENSORS, lambda scenario: sensor_parameters(scenario.sensor)),
    PlugIn("radio", "model", RADIOS, lambda scenario: radio_parameters(scenario.radio)),
    PlugIn("task", "model", TASKS, lambda scenario: task_parameters(scenario.task)),
)
SELECTOR, POLICY, SENSOR, RADIO, TASK = PLUG_INS


def complete(scenario: object, seed: int | None, *given: object) -> Scenario:
    """A scenario with what a mission was given besides.

    Args:
        scenario: what is run.
        seed: instead of its own; None: its own.
        *given: for each kind of `PLUG_INS` an object, instead of the one that the scenario names,
            or None.

    Raises:
        ScenarioError: this is not a scenario, or the seed is impossible.
        SwarmscoutError: the kind's own error: an object is of another kind.
    """
    if not isinstance(scenario, Scenario):
        example = f"world={scenario!r}" if isinstance(scenario, str) else "robots=15"
        raise ScenarioError(
            f"a Mission is made of a Scenario, not of a {type(scenario).__name__}: "
            f"Mission(Scenario({example}))"
        )
    changes: dict[str, Any] = {} if seed is None else {"seed": seed}
    for kind, plug_in in zip(PLUG_INS, given, strict=True):
        if plug_in is not None:
            changes |= kind.handed_over(scenario, plug_in)
    return Scenario(**{**scenario.model_dump(), **changes}) if changes else scenario
