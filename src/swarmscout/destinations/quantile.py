"""The paper's baseline: a frontier at a sampled quantile of the distance."""

from __future__ import annotations

from typing import Any

import numpy as np
from pydantic import NonNegativeFloat, model_validator

from swarmscout.core.parameters import Share, checked_dataclass
from swarmscout.destinations.selector import Choice
from swarmscout.destinations.view import LeaderView

__all__ = ["Quantile"]


@checked_dataclass
class Quantile:
    """A frontier near the team, at a random quantile of the distance (the paper's baseline).

    The quantile is drawn from a normal distribution around a personal bias and clipped to [0, 1];
    the frontier with rank ``round(q · (n - 1))`` by straight-line distance is chosen, ties by cell.

    Attributes:
        bias_min, bias_max: range of the uniform bias that each robot draws once per mission.
        sigma: standard deviation of the quantile.

    Source: paper, "Baseline target selection".
    """

    bias_min: Share = 0.10
    bias_max: Share = 0.25
    sigma: NonNegativeFloat = 0.02

    @model_validator(mode="after")
    def _ordered(self) -> Quantile:
        if self.bias_min > self.bias_max:
            raise ValueError(f"bias_min = {self.bias_min:g} is above bias_max = {self.bias_max:g}")
        return self

    def draw(self, view: LeaderView, memory: Any) -> tuple[float, float]:
        """The leader's personal bias, and the quantile of this decision, clipped to [0, 1].

        Args:
            view: the generators are taken from it.
            memory: the bias, or None at first.
        """
        bias = view.character.uniform(self.bias_min, self.bias_max) if memory is None else memory
        return bias, min(1.0, max(0.0, view.rng.normal(bias, self.sigma)))

    def choose(self, view: LeaderView, memory: Any) -> Choice:
        """See :class:`swarmscout.destinations.selector.Selector`; the memory is the bias."""
        return self._choose(view, memory, len(view.frontiers), "frontiers")

    def _choose(self, view: LeaderView, memory: Any, among: int, what: str) -> Choice:
        """The frontier at a random quantile of the distance, among the nearest ones.

        Args:
            view, memory: see :meth:`choose`.
            among: how many of the nearest frontiers count. what: what they are called.
        """
        bias, quantile = self.draw(view, memory)
        distances = view.distances_m
        rank = round(quantile * (among - 1))
        # Frontiers come in the order of their cells, so a stable choice settles ties by cell:
        # all that are nearer than the distance at this rank stand before those at just it.
        at = np.partition(distances, rank)[rank]
        equals = (distances == at).nonzero()[0]
        chosen = int(equals[rank - np.count_nonzero(distances < at)])
        row, col = view.frontiers[chosen].tolist()
        return Choice(
            (row, col),
            reason=f"quantile {quantile:.3f} of {among} {what} by distance",
            memory=bias,
            details={"quantile": quantile, "bias": bias, "rank": rank},
        )
