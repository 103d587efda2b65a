"""The face of every policy for the desired team size (paper, "Decentralized team formation").

A policy is a frozen record with one pure method: a view in, a size for each robot out. What it
remembers is its last answer, which the view shows.
"""

from __future__ import annotations

from typing import Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from swarmscout.teams.robots_view import RobotsView

__all__ = ["LARGEST", "DesiredSizePolicy"]

LARGEST = 100_000
"""Nobody desires a larger team."""


@runtime_checkable
class DesiredSizePolicy(Protocol):
    """Sets how many robots each robot would like its team to have.

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
            int64[N], each from 1 to LARGEST; element i depends on row i of the view alone. A robot
            in CHR mode wants to be alone (paper), whatever stands in its place.
        """
        ...
