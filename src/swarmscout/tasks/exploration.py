"""The paper's task: exploring everything that can be reached."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from swarmscout.mapping.occupancy import BeliefView
from swarmscout.tasks.task import Task

__all__ = ["Exploration"]


@dataclass(frozen=True)
class Exploration(Task):
    """Explore everything that can be reached: head for frontiers until none is left.

    Source: paper, "Task description and team behavior".
    """

    def candidates(self, map: BeliefView, step: int) -> NDArray[np.bool_]:
        """The frontiers of the map."""
        cells = np.zeros(map.frame.shape, dtype=np.bool_)
        found = map.frontiers()
        cells[found[:, 0], found[:, 1]] = True
        return cells

    def done(self, map: BeliefView, explored_m2: float, reachable_m2: float) -> str | None:
        """Done when everything reachable is explored, or no frontier is left."""
        if explored_m2 >= reachable_m2 - 1e-9:
            return "everything reachable explored"
        # Before the first cell is known to be free there is no frontier either.
        if map.frontier_count == 0 and explored_m2 > 0.0:
            return "no frontier left"
        return None
