"""The scenario: every choice that a mission depends on, checked before the mission starts.

A scenario is frozen data, composed of the parameter records of the rooms that it configures. Its
defaults are the scenario ``paper``. What the paper leaves open is a key with its meaning, unit and
range; ``docs/paper.md`` gives the reason for each value.
"""

from __future__ import annotations

from typing import Any, Literal

from pydantic import Field

from swarmscout.core.parameters import Parameters
from swarmscout.destinations.parameters import DispersalParameters, RenewalParameters
from swarmscout.llm.settings import LlmSettings
from swarmscout.mapping.parameters import MapParameters
from swarmscout.planning.parameters import RouteParameters
from swarmscout.robots.parameters import BatteryParameters, BodyParameters
from swarmscout.robots.radio.parameters import RadioParameters
from swarmscout.robots.sensors.parameters import FanParameters, SensorParameters
from swarmscout.tasks.parameters import TaskParameters
from swarmscout.teams.parameters import TeamParameters

__all__ = ["Scenario", "TeamSection"]


class TeamSection(DispersalParameters, TeamParameters):
    """The section ``[teams]``: how teams form, and how their members disperse."""


class Scenario(Parameters):
    """One mission, completely described.

    Example:
        >>> Scenario(world="lava-tube", robots=15, destinations="nearest").teams.desired_size
        5
    """

    world: str = Field("lava-tube", min_length=1, description="name of a world, or path of a map")
    world_seed: int | None = Field(None, ge=0, description="seed of a generated world")
    robots: int = Field(15, ge=1, le=100_000, description="number of robots N")
    steps: int = Field(300, ge=1, le=10_000_000, description="length of the mission in steps")
    seed: int = Field(0, ge=0, description="seed of starts, noise, charge, characters, decisions")
    start: Literal["one-place", "spread"] = Field(
        "one-place", description="robots start around the stations, or all over the world"
    )
    destinations: str = Field("quantile", min_length=1, description="a selector, or FILE.py:NAME")
    selector: dict[str, Any] = Field(default_factory=dict, description="parameters of the selector")
    policy: dict[str, Any] = Field(default_factory=dict, description="parameters of the policy")
    task: TaskParameters = TaskParameters()
    body: BodyParameters = BodyParameters()
    sensor: SensorParameters = FanParameters()
    battery: BatteryParameters = BatteryParameters()
    map: MapParameters = MapParameters()
    routes: RouteParameters = RouteParameters()
    teams: TeamSection = TeamSection()
    renewal: RenewalParameters = RenewalParameters()
    radio: RadioParameters = RadioParameters()
    llm: LlmSettings = LlmSettings()
