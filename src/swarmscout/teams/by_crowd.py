"""A policy that adapts to the number of robots nearby."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from pydantic import PositiveInt

from swarmscout.core.parameters import Metres, checked_dataclass
from swarmscout.teams.robots_view import RobotsView

__all__ = ["ByCrowd"]


@checked_dataclass
class ByCrowd:
    """Teams where robots crowd, single robots where they have room.

    In a crowd single robots obstruct each other and head for the same few frontiers, which a team
    avoids. In the open, members of a team drive in single file and see the same area twice. Teams
    split again only under the general rule for leaving, ``teams.leave_rule = "general"``.

    Attributes:
        reach_m: distance within which other robots count.
        per: number of other robots within reach for which one more member is desired, up to
            ``teams.desired_size`` in all.

    Source: this package; adaptive sizes are future work in the paper ("Conclusion").
    """

    reach_m: Metres = 3.0
    per: PositiveInt = 3

    def desired(self, view: RobotsView) -> NDArray[np.int64]:
        """See :class:`swarmscout.teams.policy.DesiredSizePolicy`."""
        return np.minimum(1 + view.robots_within(self.reach_m) // self.per, view.desired_size)
