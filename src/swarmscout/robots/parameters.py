"""Parameters of a robot's body and battery."""

from __future__ import annotations

from typing import Literal

from pydantic import Field, model_validator

from swarmscout.core.parameters import Parameters, Share

__all__ = ["BatteryParameters", "BodyParameters"]


class BodyParameters(Parameters):
    """A robot's body (paper, "Robot model" and "Task description")."""

    radius_m: float = Field(0.15, ge=0.01, le=1.0, description="half of the robot's diameter")
    forward_m: float = Field(0.2, ge=0.001, le=1.0, description="length of one forward move")
    turn_deg: float = Field(40.0, ge=1.0, le=180.0, description="angle of one rotation")
    slope_deg: float = Field(
        45.0, gt=0.0, le=90.0, description="steepest ground that robots drive over; 90: any"
    )
    position_noise_m: float = Field(
        0.0, ge=0.0, le=5.0, description="standard deviation of a believed x and y"
    )
    heading_noise_deg: float = Field(
        0.0, ge=0.0, le=90.0, description="standard deviation of a believed heading"
    )


class BatteryParameters(Parameters):
    """Charge, consumption and charging (paper, "Task description": EXP and CHR)."""

    enabled: bool = Field(True, description="false: the charge never decreases")
    capacity_steps: int = Field(
        400, ge=1, le=1_000_000_000, description="number of steps that a full charge lasts"
    )
    start_min: Share = Field(
        0.5, description="lower end of the uniform range of the initial charge, as a share"
    )
    start_max: Share = Field(
        1.0, description="upper end of the uniform range of the initial charge, as a share"
    )
    charge_below: Share = Field(
        0.25,
        description="with the rule 'threshold': CHR mode starts below this share of the charge",
    )
    charge_per_step: float = Field(
        10.0, gt=0.0, le=1e9, description="charge gained per step at a station, in steps"
    )
    station_range_m: float = Field(
        1.5, gt=0.0, le=1000.0, description="largest distance at which a station charges"
    )
    return_rule: Literal["threshold", "distance"] = Field(
        "threshold",
        description="'threshold': return at a fixed share; 'distance': when just enough is left "
        "for the way",
    )

    @model_validator(mode="after")
    def _ordered(self) -> BatteryParameters:
        if self.start_min > self.start_max:
            raise ValueError(
                f"start_min = {self.start_min:g} is above start_max = {self.start_max:g}"
            )
        return self
