"""Parameters of the occupancy grid."""

from __future__ import annotations

from itertools import pairwise
from math import log
from typing import Literal

from pydantic import Field, model_validator

from swarmscout.core.parameters import Parameters, Probability

__all__ = ["MapParameters"]

_MOST_OBSERVATIONS = 100


class MapParameters(Parameters):
    """The occupancy grid (paper, "Robot model"; log-odds after Thrun et al. 2005, ch. 9)."""

    cell_m: float = Field(
        0.5,
        ge=0.05,
        le=10.0,
        description="edge of a cell; passages are driven through if they are a cell wider than a "
        "robot and cells no larger than it",
    )
    p_free: Probability = Field(
        0.40, description="inverse sensor model: probability of a cell that a ray passed"
    )
    p_occupied: Probability = Field(
        0.70, description="inverse sensor model: probability of a cell that a ray ended in"
    )
    p_min: Probability = Field(0.03, description="lower limit of probabilities when read")
    p_max: Probability = Field(0.97, description="upper limit of probabilities when read")
    free_below: Probability = Field(0.35, description="a cell is free below this")
    occupied_above: Probability = Field(0.65, description="a cell is occupied above this")
    frontier_neighbours: Literal[4, 8] = Field(
        8,
        description="a frontier is a free cell with an unknown one among this many neighbours; "
        "an unknown cell behind a corner of two occupied cells does not count",
    )
    hit_depth_m: float = Field(
        0.05, ge=0.0, le=0.5, description="depth of an obstacle behind its measured surface"
    )

    @model_validator(mode="after")
    def _ordered(self) -> MapParameters:
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
