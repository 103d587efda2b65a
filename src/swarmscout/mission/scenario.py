"""What is run: every choice that a mission depends on, checked before it starts.

A scenario is frozen data. Its defaults are the scenario ``paper``; what the paper leaves open is a
named key with its meaning, unit and range below, and ``docs/paper.md`` says why it is what it is.
"""

from __future__ import annotations

import reprlib
from itertools import pairwise
from math import log
from typing import TYPE_CHECKING, Annotated, Any, Literal

from pydantic import BaseModel, ConfigDict, Field, ValidationError, model_validator

from swarmscout.core.errors import ScenarioError, did_you_mean

__all__ = [
    "BatteryScenario",
    "BodyScenario",
    "LlmScenario",
    "MapScenario",
    "RenewalScenario",
    "RoutesScenario",
    "Scenario",
    "SensorScenario",
    "TeamsScenario",
    "what_is_wrong",
]

Steps = Annotated[int, Field(ge=0, le=1_000_000_000)]
Share = Annotated[float, Field(ge=0.0, le=1.0)]
Probability = Annotated[float, Field(gt=0.0, lt=1.0)]
_MOST_OBSERVATIONS = 100


class _Section(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False, strict=False)

    if not TYPE_CHECKING:  # Type checkers take the fields for the arguments.

        def __init__(self, *wrong: Any, **keys: Any) -> None:
            name = type(self).__name__
            if wrong:
                raise ScenarioError(
                    f"{name}: give keys by name, as {name}({next(iter(type(self).model_fields))}=…)"
                )
            try:
                super().__init__(**keys)
            except ValidationError as error:
                raise ScenarioError(f"{name}: {what_is_wrong(error, type(self))}") from None

        # Sections inside a scenario are checked together with it, not by calling this.
        __init__.__pydantic_base_init__ = True


class BodyScenario(_Section):
    """A robot's body (paper, "Robot model" and "Task description")."""

    radius_m: float = Field(0.15, ge=0.01, le=1.0, description="half of the robot's diameter")
    forward_m: float = Field(0.2, ge=0.001, le=1.0, description="length of one forward move")
    turn_deg: float = Field(40.0, ge=1.0, le=180.0, description="angle of one rotation")
    slope_deg: float = Field(
        45.0, gt=0.0, le=90.0, description="steepest ground that it drives over; 90: any"
    )
    position_noise_m: float = Field(
        0.0, ge=0.0, le=5.0, description="standard deviation of a believed x and y"
    )
    heading_noise_deg: float = Field(
        0.0, ge=0.0, le=90.0, description="standard deviation of a believed heading"
    )


class SensorScenario(_Section):
    """The range sensor (paper, "Robot model"): a fan of rays from the robot's centre."""

    rays: int = Field(9, ge=1, le=360, description="rays, evenly spaced over the fan")
    fan_deg: float = Field(70.0, ge=0.0, le=180.0, description="the fan spans this to each side")
    range_m: float = Field(1.0, ge=0.01, le=30.0, description="longest range")
    noise_m: float = Field(0.02, ge=0.0, le=1.0, description="standard deviation of a range")
    sensing: Literal["raster", "mesh"] = Field(
        "raster", description="rays meet the world's raster, or in 3D the triangles of its mesh"
    )
    height_m: float = Field(
        0.2, ge=0.0, le=5.0, description="of the sensor above the ground, for sensing = 'mesh'"
    )


class BatteryScenario(_Section):
    """Charge, its use and refilling (paper, "Task description": EXP and CHR)."""

    enabled: bool = Field(True, description="false: charge never runs out")
    capacity_steps: int = Field(
        400, ge=1, le=1_000_000_000, description="steps that a full charge lasts"
    )
    start_min: Share = Field(0.5, description="charge at the start is uniform from here")
    start_max: Share = Field(1.0, description="… to here, as shares of the capacity")
    charge_below: Share = Field(0.25, description="CHR mode starts below this share")
    charge_per_step: float = Field(10.0, gt=0.0, le=1e9, description="refilled per step, in steps")
    station_range_m: float = Field(
        1.5, gt=0.0, le=1000.0, description="a station charges up to here"
    )
    return_rule: Literal["threshold", "distance"] = Field(
        "threshold", description="'distance': also keep enough charge for the way back"
    )

    @model_validator(mode="after")
    def _ordered(self) -> BatteryScenario:
        if self.start_min > self.start_max:
            raise ValueError(
                f"start_min = {self.start_min:g} is above start_max = {self.start_max:g}"
            )
        return self


class MapScenario(_Section):
    """The occupancy grid (paper, "Robot model"; log-odds after Thrun et al. 2005, ch. 9)."""

    cell_m: float = Field(0.5, ge=0.1, le=10.0, description="edge of a cell")
    p_free: Probability = Field(0.40, description="inverse sensor model: a ray passed the cell")
    p_occupied: Probability = Field(0.70, description="inverse sensor model: a ray ended in it")
    p_min: Probability = Field(0.03, description="probabilities saturate here when read …")
    p_max: Probability = Field(0.97, description="… and here")
    free_below: Probability = Field(0.35, description="a cell is free below this")
    occupied_above: Probability = Field(0.65, description="a cell is occupied above this")
    frontier_neighbours: Literal[4, 8] = Field(
        8,
        description="a frontier is a free cell with an unknown one among so many neighbours; "
        "behind a corner of two occupied cells does not count",
    )
    hit_depth_m: float = Field(
        0.05, ge=0.0, le=0.5, description="an obstacle lies this far behind its measured surface"
    )

    @model_validator(mode="after")
    def _ordered(self) -> MapScenario:
        chain = (
            ("p_min", self.p_min),
            ("free_below", self.free_below),
            ("0.5", 0.5),
            ("occupied_above", self.occupied_above),
            ("p_max", self.p_max),
        )
        for (low_name, low), (high_name, high) in pairwise(chain):
            if not low < high:
                raise ValueError(f"{low_name} = {low:g} must be below {high_name} = {high:g}")
        if not self.p_free < 0.5 < self.p_occupied:
            raise ValueError(
                f"p_free = {self.p_free:g} must be below 0.5 and "
                f"p_occupied = {self.p_occupied:g} above it"
            )
        for name, observed, wanted in (
            ("p_free", self.p_free, self.free_below),
            ("p_occupied", self.p_occupied, self.occupied_above),
        ):
            count = log(wanted / (1 - wanted)) / log(observed / (1 - observed))
            if count > _MOST_OBSERVATIONS:
                raise ValueError(
                    f"{name} = {observed:g} says next to nothing: a cell would need {count:,.0f} "
                    f"observations until its state is known (at most {_MOST_OBSERVATIONS})"
                )
        return self


class RoutesScenario(_Section):
    """Routes over the map (paper, "Task description": A* with probability as cost)."""

    cost: Literal["length", "probability"] = Field(
        "length", description="cost per metre: 'length' 1 + p, 'probability' p (the literal rule)"
    )


class TeamsScenario(_Section):
    """Team formation (paper, "Decentralized team formation" and "Self-organization")."""

    policy: str = Field(
        "by-mode", min_length=1, description="sets the desired team size: a policy, or FILE.py:NAME"
    )
    desired_size: int = Field(5, ge=1, le=100_000, description="desired team size in EXP mode")
    d_join_m: float = Field(2.0, ge=0.0, le=1e6, description="teams this near may join")
    leave_rule: Literal["charge", "general"] = Field(
        "charge", description="'general': also leave when mean desired size < team size"
    )
    silence_steps: int = Field(
        5,
        ge=0,
        le=1_000_000_000,
        description="a member not heard for more steps than this is dropped",
    )
    position: Literal["leader", "center"] = Field(
        "leader", description="a team's position: its leader's, or the mean of its members'"
    )
    members: Literal["shared", "fan"] = Field(
        "shared", description="'fan': members take different frontier cells near the destination"
    )
    fan_m: float = Field(
        4.0, ge=0.0, le=100.0, description="with 'fan', targets lie this near to the destination …"
    )
    fan_apart_m: float = Field(
        1.0, ge=0.0, le=100.0, description="… at least so far from each other …"
    )
    fan_turn_m: float = Field(
        1.5, ge=0.0, le=100.0, description="… and a turn by a radian counts as so long a way"
    )


class RenewalScenario(_Section):
    """When a team's leader chooses a new destination (paper, "Task description")."""

    rule: Literal["stale", "reached"] = Field(
        "stale", description="'reached': only when reached or without a route (literal)"
    )
    reach_m: float = Field(
        0.5, gt=0.0, le=1000.0, description="reached this near to the cell's centre"
    )
    overdue_factor: float = Field(
        3.0, ge=1.0, le=1e6, description="overdue after this × straight time …"
    )
    overdue_steps: int = Field(30, ge=0, le=1_000_000_000, description="… plus this many steps")
    avoid_steps: int = Field(
        30,
        ge=0,
        le=1_000_000_000,
        description="a given-up destination is avoided by its team for so long",
    )


class LlmScenario(_Section):
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


class Scenario(_Section):
    """One mission, completely described.

    Example:
        >>> Scenario(world="lava-tube", robots=15, destinations="nearest").teams.desired_size
        5
    """

    world: str = Field("lava-tube", min_length=1, description="a named world, or a map's path")
    world_seed: int | None = Field(None, ge=0, description="a generated world's own seed")
    robots: int = Field(15, ge=1, le=100_000, description="N, the number of robots")
    steps: int = Field(300, ge=1, le=10_000_000, description="the mission's length")
    seed: int = Field(0, ge=0, description="starts, noise, charge, characters, decisions")
    start: Literal["one-place", "spread"] = Field(
        "one-place", description="robots start round the stations, or all over the world"
    )
    destinations: str = Field("quantile", min_length=1, description="a selector, or FILE.py:NAME")
    selector: dict[str, Any] = Field(default_factory=dict, description="the selector's parameters")
    policy: dict[str, Any] = Field(default_factory=dict, description="the policy's parameters")
    body: BodyScenario = BodyScenario()
    sensor: SensorScenario = SensorScenario()
    battery: BatteryScenario = BatteryScenario()
    map: MapScenario = MapScenario()
    routes: RoutesScenario = RoutesScenario()
    teams: TeamsScenario = TeamsScenario()
    renewal: RenewalScenario = RenewalScenario()
    llm: LlmScenario = LlmScenario()


def what_is_wrong(error: ValidationError, model: type[BaseModel] = Scenario) -> str:
    """The first thing that is wrong with a scenario's keys, in one line.

    Args:
        error: what pydantic says.
        model: of which model, a scenario or a section of it.
    """
    problems = error.errors(include_url=False)
    first = problems[0]
    key = ".".join(str(part) for part in first["loc"])
    more = f" (and {len(problems) - 1} more)" if len(problems) > 1 else ""
    if first["type"] == "extra_forbidden":
        section = model
        for part in first["loc"][:-1]:
            annotation = section.model_fields[str(part)].annotation
            assert isinstance(annotation, type)
            section = annotation
        name = str(first["loc"][-1])
        return f"unknown key '{key}': {did_you_mean(name, section.model_fields)}{more}"
    message = first["msg"].removeprefix("Value error, ").removeprefix("Input ")
    given = first["input"]
    if first["type"] in ("model_type", "dict_type"):
        return f"key '{key}' = {reprlib.repr(given)}: it is a section, give its keys{more}"
    if isinstance(given, dict | BaseModel):
        return f"section '{key}': {message}{more}" if key else f"{message}{more}"
    return f"key '{key}' = {_brief(given)}: {message}{more}"


def _brief(value: Any) -> str:
    """A value in a few words: an array's or a frame's repr would fill the screen."""
    if isinstance(value, str):
        return repr(value if len(value) <= 100 else f"{value[:100]}…")
    plain = value is None or isinstance(value, bool | int | float | list | tuple)
    return reprlib.repr(value) if plain else f"a {type(value).__name__}"
