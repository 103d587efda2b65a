"""The paper's baseline, kept near the team."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from swarmscout.core.parameters import Metres, Share, checked_dataclass
from swarmscout.destinations.batch import Batch, Outcome
from swarmscout.destinations.quantile import Quantile
from swarmscout.destinations.selector import Choice
from swarmscout.destinations.view import LeaderView

__all__ = ["QuantileLocal"]


@checked_dataclass
class QuantileLocal(Quantile):
    """A random quantile of the distance, as the baseline, but among frontiers near the team.

    The baseline's quantile counts all frontiers of the map, so a team is sent farther the more
    frontiers other teams find. Here only those within a radius count; without any, all do.

    Attributes:
        bias_min, bias_max, sigma: as in the baseline.
        radius_m: straight-line distance from the team within which a frontier is near.

    Source: paper, "Baseline target selection" ("a frontier cell nearby each team"). Decentralized:
        it reads the team's own position only.
    """

    bias_min: Share = 0.19
    bias_max: Share = 0.32
    radius_m: Metres = 2.75

    def chooses_in_batches(self) -> bool:
        """See :class:`swarmscout.destinations.batch.BatchSelector`."""
        return type(self) is QuantileLocal

    def choose_batch(self, batch: Batch, memories: Sequence[Any]) -> list[Outcome]:
        """See :class:`swarmscout.destinations.batch.BatchSelector`."""
        return self._choose_batch(batch, memories, self.radius_m, "near frontiers")

    def choose(self, view: LeaderView, memory: Any) -> Choice:
        """See :class:`swarmscout.destinations.selector.Selector`; the memory is the bias."""
        near = int(np.count_nonzero(view.distances_m <= self.radius_m)) or len(view.frontiers)
        return self._choose(view, memory, near, "near frontiers")
