"""The keys of a scenario's section ``[sensor]``: one record per model.

This module imports no kernel, so that a scenario can be read without compiling anything.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Annotated, Any, Literal

from pydantic import BaseModel, ConfigDict, Discriminator, Field, Tag, ValidationError

__all__ = [
    "RECORDS",
    "ConeParameters",
    "FanParameters",
    "LidarParameters",
    "OwnParameters",
    "RayParameters",
    "SensorParameters",
    "sensor_parameters",
]

Model = Annotated[
    str, Field(min_length=1, description="the sensor: fan, lidar, cone, or FILE.py:NAME")
]
Sensing = Annotated[
    Literal["raster", "mesh"],
    Field(description="rays meet the world's raster, or in 3D the triangles of its mesh"),
]


class _Record(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)

    if not TYPE_CHECKING:  # Type checkers take the fields for the arguments.

        def __init__(self, **keys: Any) -> None:
            try:
                super().__init__(**keys)
            except ValidationError as error:
                problem = error.errors(include_url=False)[0]
                key = ".".join(map(str, problem["loc"]))
                shown = problem["msg"].removeprefix("Input ")
                raise ValueError(f"{key} = {problem['input']!r}: {shown}") from None

        # A record inside a scenario is checked together with it, not by calling this.
        __init__.__pydantic_base_init__ = True


class RayParameters(_Record):
    """What all sensors of the package share."""

    model: Model
    range_m: float = Field(1.0, ge=0.01, le=30.0, description="longest range")
    noise_m: float = Field(0.02, ge=0.0, le=1.0, description="standard deviation of a range")
    sensing: Sensing = "raster"
    height_m: float = Field(
        0.2, ge=0.0, le=5.0, description="of the sensor above the ground, for sensing = 'mesh'"
    )


class FanParameters(RayParameters):
    """A fan of rays ahead (paper, "Robot model")."""

    model: Model = "fan"
    rays: int = Field(9, ge=1, le=360, description="rays, evenly spaced over the fan")
    fan_deg: float = Field(70.0, ge=0.0, le=180.0, description="the fan spans this to each side")


class LidarParameters(RayParameters):
    """Rays all around."""

    model: Model = "lidar"
    range_m: float = Field(8.0, ge=0.01, le=30.0, description="longest range")
    rays: int = Field(360, ge=1, le=3600, description="rays, evenly spaced over the circle")


class ConeParameters(RayParameters):
    """One cone ahead."""

    model: Model = "cone"
    range_m: float = Field(3.0, ge=0.01, le=30.0, description="longest range")
    opening_deg: float = Field(30.0, ge=1.0, le=180.0, description="angle between the cone's sides")


class OwnParameters(_Record):
    """A sensor from a user's file or another package: further keys are its class's parameters."""

    model_config = ConfigDict(extra="allow")

    model: Model
    sensing: Sensing = "raster"


RECORDS: dict[str, type[_Record]] = {
    "fan": FanParameters,
    "lidar": LidarParameters,
    "cone": ConeParameters,
    "own": OwnParameters,
}
"""Which record a model has; ``own`` stands for every model that is not in the package."""


def _tag(given: Any) -> str:
    if isinstance(given, Mapping):
        model = given.get("model", "fan")
    else:
        model = getattr(given, "model", "fan")
    return model if isinstance(model, str) and model in RECORDS else "own"


SensorParameters = Annotated[
    Annotated[FanParameters, Tag("fan")]
    | Annotated[LidarParameters, Tag("lidar")]
    | Annotated[ConeParameters, Tag("cone")]
    | Annotated[OwnParameters, Tag("own")],
    Discriminator(_tag),
]
"""The section ``[sensor]``; its key ``model`` says which record it is."""


def sensor_parameters(given: SensorParameters) -> dict[str, Any]:
    """What a sensor's class is made with.

    Args:
        given: the section ``[sensor]``.
    """
    own = isinstance(given, OwnParameters)
    return given.model_dump(exclude={"model", "sensing"} if own else {"model"})
