"""Policies for the desired team size by name: see :mod:`swarmscout.core.registry`.

Other packages register theirs under the entry point group ``swarmscout.policies``.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

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


def policies() -> dict[str, str]:
    """Registered names of policies, each with one line on what it does."""
    return POLICIES.names()


def make_policy(
    name: str, parameters: Mapping[str, Any] | None = None, base: Path | None = None
) -> DesiredSizePolicy:
    """Make a policy by its name.

    Args:
        name: a registered name, or ``file.py:ClassName``, whose code is run.
        parameters: keyword arguments for its class.
        base: the folder that a relative file is looked for in, besides the working directory.

    Raises:
        PolicyError: there is no such policy, or it does not take these parameters.
    """
    return POLICIES.make(name, parameters, base)
