"""The paper's baseline, kept near the team."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from swarmscout.destinations.selector import Choice
from swarmscout.minds.view import LeaderView

__all__ = ["QuantileLocal"]


@dataclass(frozen=True, slots=True)
class QuantileLocal:
    """A random quantile of the distance, as the baseline, but among frontiers near the team.

    The baseline's quantile counts all frontiers of the swarm, so a team is sent farther the more
    the others have found. Here only those within a radius count; if there are none, all do.

    Attributes:
        radius_m: straight distance from the team up to which a frontier is near.
        bias_min, bias_max: each robot's bias is uniform in this range, drawn once a mission.
        sigma: standard deviation of the quantile.

    Source: paper, "Baseline target selection" ("a frontier cell nearby each team"). Decentralized
        as it stands: it reads the team's own position only.
    """

    radius_m: float = 2.75
    bias_min: float = 0.19
    bias_max: float = 0.32
    sigma: float = 0.02

    def __post_init__(self) -> None:
        if not 0.0 <= self.bias_min <= self.bias_max <= 1.0:
            raise ValueError(
                f"bias_min = {self.bias_min:g} and bias_max = {self.bias_max:g} must be "
                "ordered and within [0, 1]"
            )
        if not self.sigma >= 0.0:
            raise ValueError(f"sigma = {self.sigma:g} must be at least 0")

    def choose(self, view: LeaderView, memory: Any) -> Choice:
        """See :class:`swarmscout.destinations.selector.Selector`; remembers the bias."""
        bias = view.character.uniform(self.bias_min, self.bias_max) if memory is None else memory
        quantile = min(1.0, max(0.0, view.rng.normal(bias, self.sigma)))
        distances = view.distances_m
        near = int(np.count_nonzero(distances <= self.radius_m)) or len(distances)
        rank = round(quantile * (near - 1))
        row, col = view.frontiers[int(np.argsort(distances, kind="stable")[rank])].tolist()
        return Choice(
            (row, col),
            reason=f"quantile {quantile:.3f} of {near} near frontiers by distance",
            memory=bias,
            details={"quantile": quantile, "bias": bias, "rank": rank},
        )
