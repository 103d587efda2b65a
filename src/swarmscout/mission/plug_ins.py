"""Where a scenario names its plug-ins, and with which parameters they are made."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from swarmscout.core.registry import Registry
from swarmscout.destinations.registry import SELECTORS
from swarmscout.mission.scenario import Scenario
from swarmscout.robots.radio.parameters import radio_parameters
from swarmscout.robots.radio.registry import RADIOS
from swarmscout.robots.sensors.parameters import sensor_parameters
from swarmscout.robots.sensors.registry import SENSORS
from swarmscout.tasks.parameters import task_parameters
from swarmscout.tasks.registry import TASKS
from swarmscout.teams.registry import POLICIES

__all__ = ["PLUG_INS", "PlugIn"]


@dataclass(frozen=True)
class PlugIn:
    """One kind of plug-in in a scenario.

    Attributes:
        section: the section that names it; empty for the scenario itself.
        key: the key in it.
        registry: the kind's.
        parameters: what its class is made with.
    """

    section: str
    key: str
    registry: Registry[Any]
    parameters: Callable[[Scenario], dict[str, Any]]

    def name(self, scenario: Scenario) -> str:
        """The name or ``FILE.py:NAME`` in a scenario."""
        section = getattr(scenario, self.section) if self.section else scenario
        return str(getattr(section, self.key))

    def renamed(self, scenario: Scenario, name: str) -> Scenario:
        """A scenario with another name in this place."""
        if not self.section:
            return scenario.model_copy(update={self.key: name})
        section = getattr(scenario, self.section).model_copy(update={self.key: name})
        return scenario.model_copy(update={self.section: section})


PLUG_INS = (
    PlugIn("", "destinations", SELECTORS, lambda scenario: scenario.selector),
    PlugIn("teams", "policy", POLICIES, lambda scenario: scenario.policy),
    PlugIn("sensor", "model", SENSORS, lambda scenario: sensor_parameters(scenario.sensor)),
    PlugIn("radio", "model", RADIOS, lambda scenario: radio_parameters(scenario.radio)),
    PlugIn("task", "model", TASKS, lambda scenario: task_parameters(scenario.task)),
)
