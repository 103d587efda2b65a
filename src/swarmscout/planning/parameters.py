"""Parameters of route planning."""

from __future__ import annotations

from typing import Literal

from pydantic import Field

from swarmscout.core.parameters import Parameters

__all__ = ["RouteParameters"]


class RouteParameters(Parameters):
    """Routes over the map (paper, "Task description": A* with probability as cost)."""

    cost: Literal["length", "probability"] = Field(
        "length", description="cost per metre: 'length' 1 + p, 'probability' p (the literal rule)"
    )
    far: Literal["parts", "whole"] = Field(
        "parts",
        description="routes over more than 8 tiles of 32 cells: 'parts' one after the other as the "
        "robot drives, near-optimal; 'whole' at once, optimal, slow on large maps",
    )
