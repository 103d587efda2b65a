"""Policies for the desired team size by name: see :mod:`swarmscout.core.registry`.

Other packages register theirs under the entry point group ``swarmscout.policies``.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from swarmscout.core.errors import PolicyError
from swarmscout.core.registry import Registry
from swarmscout.teams.by_crowd import ByCrowd
from swarmscout.teams.by_mode import ByMode
from swarmscout.teams.policy import DesiredSizePolicy

__all__ = ["POLICIES", "make_policy", "policies"]

POLICIES: Registry[DesiredSizePolicy] = Registry(
    noun="policy",
    method="desired(view)",
    face=DesiredSizePolicy,  # type: ignore[type-abstract]
    error=PolicyError,
    group="swarmscout.policies",
    built_in={"by-mode": ByMode, "by-crowd": ByCrowd},
)


def policies() -> dict[str, str]:
    """Names of all policies that can be used by name, each with one line on what it does."""
    return POLICIES.names()


def make_policy(
    name: str, parameters: Mapping[str, Any] | None = None, base: Path | None = None
) -> DesiredSizePolicy:
    """Make the policy behind a name; a file is run for that.

    Args:
        name: a name of :func:`policies`, or ``file.py:ClassName``.
        parameters: keyword arguments for its class.
        base: the folder that a relative file is looked for in, besides the working directory.

    Raises:
        PolicyError: there is no such policy, or it does not take these parameters.
    """
    return POLICIES.make(name, parameters, base)
