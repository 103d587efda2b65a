"""Policies for the desired team size (paper, "Decentralized team formation").

A policy is a frozen record with one pure method. It gets, for all robots at once, what each knows
of itself; element i of its answer may depend on element i alone.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from swarmscout.core.codes import CHARGE
from swarmscout.core.errors import ScenarioError, did_you_mean

__all__ = ["POLICIES", "ByMode", "DesiredSizePolicy", "policies", "policy"]


class DesiredSizePolicy(Protocol):
    """Sets how many robots each robot would like its team to have."""

    def desired(self, mode: NDArray[np.int64]) -> NDArray[np.int64]:
        """Desired team sizes.

        Args:
            mode: int64[N], each robot's own mode: EXPLORE or CHARGE.

        Returns:
            int64[N], each ≥ 1.
        """
        ...


@dataclass(frozen=True, slots=True)
class ByMode:
    """The same size for all that explore, and 1 for those that charge.

    Source: paper, "Self-organization of teams": 5 in EXP mode, 1 in CHR mode.
    """

    size: int = 5

    def desired(self, mode: NDArray[np.int64]) -> NDArray[np.int64]:
        """See :class:`DesiredSizePolicy`."""
        return np.where(mode == CHARGE, 1, self.size)


POLICIES: dict[str, type[ByMode]] = {"by-mode": ByMode}


def policies() -> dict[str, str]:
    """Names of the policies, each with one line on what it does."""
    return {name: (kind.__doc__ or "").splitlines()[0] for name, kind in POLICIES.items()}


def policy(name: str, size: int) -> DesiredSizePolicy:
    """The policy behind a name.

    Args:
        name: one of :func:`policies`.
        size: desired team size in EXP mode.

    Raises:
        ScenarioError: there is no such policy.
    """
    if name not in POLICIES:
        raise ScenarioError(
            f"key 'teams.policy' = {name!r}: unknown policy, {did_you_mean(name, POLICIES)}"
        )
    return POLICIES[name](size)
