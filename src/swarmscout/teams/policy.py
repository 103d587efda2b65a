"""The protocol of policies for the desired team size (paper, "Decentralized team formation").

A policy is a frozen record with one pure method: a view in, a size for each robot out. Its only
memory is its last answer, which the view contains.
"""

from __future__ import annotations

from typing import Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from swarmscout.teams.robots_view import RobotsView

__all__ = ["LARGEST", "DesiredSizePolicy"]

LARGEST = 100_000
"""The largest desired team size."""


@runtime_checkable
class DesiredSizePolicy(Protocol):
    """Sets the team size that each robot desires.

    Example:
        >>> from dataclasses import dataclass
        >>> @dataclass(frozen=True)
        ... class Pairs:
        ...     '''Two by two.'''
        ...     def desired(self, view):
        ...         return np.full(len(view), 2)
    """

    def desired(self, view: RobotsView) -> NDArray[np.int64]:
        """Desired team sizes, for all robots at once.

        Args:
            view: what N robots know, row i of each array what robot i knows.

        Returns:
            int64[N], each from 1 to LARGEST; element i depends on row i of the view alone. The
            element of a robot in CHR mode is ignored: its desired size is 1 (paper).
        """
        ...
