"""A policy that adapts to how many robots are near."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from pydantic import PositiveInt
from pydantic.dataclasses import dataclass

from swarmscout.core.parameters import STRICT, Metres
from swarmscout.teams.robots_view import RobotsView

__all__ = ["ByCrowd"]


@dataclass(frozen=True, slots=True, config=STRICT)
class ByCrowd:
    """Teams where robots crowd, single robots where they have room.

    In a crowd single robots stand in each other's way and head for the same few frontiers; a team
    there counts as one. Out in the open members of a team drive in file and see the same twice.
    Teams split up again only under the general rule for leaving: ``teams.leave_rule = "general"``.

    Args:
        reach_m: how far a robot looks round for others.
        per: one more member is desired for each so many other robots within reach; never more
            than ``teams.desired_size`` in all.

    Source: ours; sizes that adapt are future work in the paper ("Conclusion").
    """

    reach_m: Metres = 3.0
    per: PositiveInt = 3

    def desired(self, view: RobotsView) -> NDArray[np.int64]:
        """See :class:`swarmscout.teams.policy.DesiredSizePolicy`."""
        return np.minimum(1 + view.robots_within(self.reach_m) // self.per, view.desired_size)
