"""The paper's policy for the desired team size."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from swarmscout.teams.robots_view import RobotsView

__all__ = ["ByMode"]


@dataclass(frozen=True, slots=True)
class ByMode:
    """One size for robots that explore (``teams.desired_size``), and 1 for robots that charge.

    Source: paper, "Self-organization of teams": 5 in EXP mode, 1 in CHR mode.
    """

    def desired(self, view: RobotsView) -> NDArray[np.int64]:
        """See :class:`swarmscout.teams.policy.DesiredSizePolicy`."""
        return np.full(len(view), view.desired_size)
