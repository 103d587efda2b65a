"""Radios by name: see :mod:`swarmscout.core.registry`.

Other packages register theirs under the entry point group ``swarmscout.radios``.
"""

from __future__ import annotations

from swarmscout.core.errors import ScenarioError
from swarmscout.core.registry import Registry
from swarmscout.robots.radio.radio import Radio

__all__ = ["RADIOS"]

RADIOS: Registry[Radio] = Registry(
    noun="radio",
    method="links(step, bodies, world)",
    face=Radio,  # type: ignore[type-abstract]
    error=ScenarioError,
    group="swarmscout.radios",
    built_in={
        "full": "swarmscout.robots.radio.full:Full",
        "disc": "swarmscout.robots.radio.disc:Disc",
    },
)
