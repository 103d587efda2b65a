"""Parameters of destinations: when they are renewed, and how a team disperses round one."""

from __future__ import annotations

from typing import Literal

from pydantic import Field

from swarmscout.core.parameters import Parameters, Steps

__all__ = ["DispersalParameters", "RenewalParameters"]


class RenewalParameters(Parameters):
    """When a team's leader chooses a new destination (paper, "Task description")."""

    rule: Literal["stale", "reached"] = Field(
        "stale",
        description="'stale': also when the cell is no longer a candidate (a frontier) or "
        "the team is overdue; "
        "'reached': only when reached or without a route (literal)",
    )
    reach_m: float = Field(
        0.5,
        gt=0.0,
        le=1000.0,
        description="a destination is reached within this distance of the cell's centre, or within "
        "the sensor's range less a cell if that is nearer",
    )
    overdue_factor: float = Field(
        3.0,
        ge=1.0,
        le=1e6,
        description="a team is overdue after this many times the straight travel time, "
        "plus `overdue_steps`",
    )
    overdue_steps: Steps = Field(30, description="steps added to the time until overdue")
    avoid_steps: Steps = Field(
        30,
        description="number of steps for which a team avoids a destination that it gave up, and "
        "between the first two tries after which a place is closed; 0: neither",
    )


class DispersalParameters(Parameters):
    """Whether members of a team share one target or fan out (section ``[teams]``)."""

    members: Literal["shared", "fan"] = Field(
        "shared",
        description="'fan': members take different candidates of the task near the destination",
    )
    fan_m: float = Field(
        4.0,
        ge=0.0,
        le=100.0,
        description="with 'fan': largest distance of a member's target from the destination",
    )
    fan_apart_m: float = Field(
        1.0,
        ge=0.0,
        le=100.0,
        description="with 'fan': smallest distance between two members' targets",
    )
    fan_turn_m: float = Field(
        1.5,
        ge=0.0,
        le=100.0,
        description="with 'fan': distance that costs as much as a turn by one radian",
    )
