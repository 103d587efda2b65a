"""Sensors by name: see :mod:`swarmscout.core.registry`.

Other packages register theirs under the entry point group ``swarmscout.sensors``.
"""

from __future__ import annotations

from swarmscout.core.errors import SensorError
from swarmscout.core.registry import Registry
from swarmscout.robots.sensors.sensor import Sensor

__all__ = ["SENSORS"]

SENSORS: Registry[Sensor] = Registry(
    noun="sensor",
    method="scan(bodies, world, step)",
    face=Sensor,  # type: ignore[type-abstract]
    error=SensorError,
    group="swarmscout.sensors",
    built_in={
        "fan": "swarmscout.robots.sensors.fan:Fan",
        "lidar": "swarmscout.robots.sensors.lidar:Lidar",
        "cone": "swarmscout.robots.sensors.cone:Cone",
    },
)
