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
from swarmscout.mapping.parameters import MapParameters
from swarmscout.planning.parameters import RouteParameters
from swarmscout.robots.parameters import BatteryParameters, BodyParameters
from swarmscout.robots.radio.parameters import RadioParameters
from swarmscout.robots.sensors.parameters import FanParameters, SensorParameters
from swarmscout.tasks.parameters import TaskParameters
from swarmscout.teams.parameters import TeamParameters

__all__ = ["LlmScenario", "Scenario", "TeamSection"]


class LlmScenario(Parameters):
    """The language model that selectors ask which ask one (paper, "LLM-based …"; docs/llm.md).

    Keys of providers come from the environment and stand in no scenario.
    """

    provider: Literal["auto", "openai", "azure", "server", "embedded"] = Field(
        "auto", description="who answers; 'auto': whoever the environment names"
    )
    model: str = Field("", description="the model's name, or Azure's deployment")
    base_url: str = Field("", description="address of a compatible server, of Azure's endpoint")
    api_version: str = Field("", description="Azure's API version")
    temperature: float = Field(0.0, ge=0.0, le=2.0, description="where the model takes one")
    structured: Literal["auto", "schema", "off"] = Field(
        "auto", description="answers by JSON schema: until refused, always, or never"
    )
    concurrency: int = Field(8, ge=1, le=256, description="requests under way at once")
    decision_s: float = Field(60.0, gt=0.0, description="a decision's time, retries included")
    call_s: float = Field(30.0, gt=0.0, description="one request's time")
    tries: int = Field(4, ge=1, le=20, description="a failing request is sent so often at most")
    breaker_failures: int = Field(5, ge=1, description="after so many failures in a row …")
    breaker_steps: int = Field(20, ge=0, description="… nobody is asked for so many steps")
    max_calls: int | None = Field(None, ge=0, description="of a mission; then the rule decides")
    max_tokens: int | None = Field(None, ge=0, description="read and written in a mission")
    max_cost_usd: float | None = Field(None, ge=0.0, description="of a mission")
    prices: str = Field("", description="a price table, instead of the package's")
    cassette: str = Field("", description="a file that keeps requests and replies")
    mode: Literal["auto", "record", "replay", "refresh"] = Field(
        "auto", description="what the cassette is for"
    )
    embedded_model: str = Field("", description="a GGUF file, instead of the installed model")
    threads: int = Field(1, ge=1, le=256, description="of the embedded model")
    latency_steps: int = Field(
        0, ge=0, description="an answer arrives so many steps later; until then the rule decides"
    )


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
    llm: LlmScenario = LlmScenario()
