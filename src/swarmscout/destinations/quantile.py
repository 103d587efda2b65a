"""The paper's baseline: a frontier at a sampled quantile of the distance."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from swarmscout.destinations.selector import Choice
from swarmscout.destinations.view import LeaderView

__all__ = ["Quantile"]


@dataclass(frozen=True, slots=True)
class Quantile:
    """A frontier near the team, at a random quantile of the distance (the paper's baseline).

    The quantile is drawn from a normal distribution round a personal bias and clipped to [0, 1];
    the frontier with rank ``round(q · (n - 1))`` by straight distance is chosen, ties by cell.

    Attributes:
        bias_min, bias_max: each robot's bias is uniform in this range, drawn once a mission.
        sigma: standard deviation of the quantile.

    Source: paper, "Baseline target selection".
    """

    bias_min: float = 0.10
    bias_max: float = 0.25
    sigma: float = 0.02

    def __post_init__(self) -> None:
        if not 0.0 <= self.bias_min <= self.bias_max <= 1.0:
            raise ValueError(
                f"bias_min = {self.bias_min:g} and bias_max = {self.bias_max:g} must be "
                "ordered and within [0, 1]"
            )
        if not self.sigma >= 0.0:
            raise ValueError(f"sigma = {self.sigma:g} must be at least 0")

    def draw(self, view: LeaderView, memory: Any) -> tuple[float, float]:
        """The leader's personal bias, and the quantile of this decision, clipped to [0, 1].

        Args:
            view: whose generators are used; memory: the bias, or None at first.
        """
        bias = view.character.uniform(self.bias_min, self.bias_max) if memory is None else memory
        return bias, min(1.0, max(0.0, view.rng.normal(bias, self.sigma)))

    def choose(self, view: LeaderView, memory: Any) -> Choice:
        """See :class:`swarmscout.destinations.selector.Selector`; remembers the bias."""
        bias, quantile = self.draw(view, memory)
        distances = view.distances_m
        rank = round(quantile * (len(distances) - 1))
        # Frontiers come in the order of their cells, so a stable choice settles ties by cell:
        # all that are nearer than the distance at this rank stand before those at just it.
        at = np.partition(distances, rank)[rank]
        equals = (distances == at).nonzero()[0]
        chosen = int(equals[rank - np.count_nonzero(distances < at)])
        row, col = view.frontiers[chosen].tolist()
        return Choice(
            (row, col),
            reason=f"quantile {quantile:.3f} of {len(distances)} frontiers by distance",
            memory=bias,
            details={"quantile": quantile, "bias": bias, "rank": rank},
        )
