"""Policies for the desired team size by name: see :mod:`swarmscout.core.registry`.

Other packages register theirs under the entry point group ``swarmscout.policies``.
"""

from __future__ import annotations

from swarmscout.core.errors import PolicyError
from swarmscout.core.registry import Registry
from swarmscout.teams.policy import DesiredSizePolicy

__all__ = ["POLICIES", "make_policy", "policies"]

POLICIES: Registry[DesiredSizePolicy] = Registry(
    noun="policy",
    method="desired(view)",
    face=DesiredSizePolicy,  # type: ignore[type-abstract]
    error=PolicyError,
    group="swarmscout.policies",
    built_in={
        "by-mode": "swarmscout.teams.by_mode:ByMode",
        "by-crowd": "swarmscout.teams.by_crowd:ByCrowd",
    },
)

policies = POLICIES.names
make_policy = POLICIES.make
