"""The paper's baseline: a frontier at a sampled quantile of the distance."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from functools import partial
from typing import Any

import numpy as np
from pydantic import NonNegativeFloat, model_validator

from swarmscout.core.parameters import Share, checked_dataclass
from swarmscout.destinations.batch import Batch, Outcome
from swarmscout.destinations.quantile_batch import BY_RANK, choose_by_rank
from swarmscout.destinations.selector import Choice
from swarmscout.destinations.view import LeaderView

__all__ = ["Quantile"]

WRITTEN = ("at", "offered", "doubts", "among", "rank")


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

    def chooses_in_batches(self) -> bool:
        """See :class:`swarmscout.destinations.batch.BatchSelector`."""
        return type(self) is Quantile

    def choose_batch(self, batch: Batch, memories: Sequence[Any]) -> list[Outcome]:
        """See :class:`swarmscout.destinations.batch.BatchSelector`."""
        return self._choose_batch(batch, memories, math.inf, "frontiers")

    def _choose_batch(
        self, batch: Batch, memories: Sequence[Any], radius_m: float, what: str
    ) -> list[Outcome]:
        asked = batch.asked(BY_RANK)
        asked["radius_m"] = radius_m
        drawn = [
            self._draw(batch.decide(robot), partial(batch.character, robot), memory)
            for robot, memory in zip(batch.leaders.tolist(), memories, strict=True)
        ]
        asked["quantile"] = [quantile for _, quantile in drawn]
        choose_by_rank(batch.minds.own, batch.land, batch.memory, batch.offers, batch.step, asked)
        written = zip(drawn, *(asked[name].tolist() for name in WRITTEN), strict=True)
        return [
            Outcome(
                _choice(batch.cell(at), draw, rank, among, what) if at >= 0 else None,
                offered,
                doubts,
            )
            for draw, at, offered, doubts, among, rank in written
        ]

    def _draw(
        self,
        rng: np.random.Generator,
        character: Callable[[], np.random.Generator],
        memory: Any,
    ) -> tuple[float, float]:
        """The leader's personal bias, and the quantile of this decision, clipped to [0, 1].

        Args:
            rng: for this decision. character: for what stays the same.
            memory: the bias, or None at first.
        """
        bias = character().uniform(self.bias_min, self.bias_max) if memory is None else memory
        return bias, min(1.0, max(0.0, rng.normal(bias, self.sigma)))

    def choose(self, view: LeaderView, memory: Any) -> Choice:
        """See :class:`swarmscout.destinations.selector.Selector`; the memory is the bias."""
        return self._choose(view, memory, len(view.frontiers), "frontiers")

    def _choose(self, view: LeaderView, memory: Any, among: int, what: str) -> Choice:
        """The frontier at a random quantile of the distance, among the nearest ones.

        Args:
            view, memory: see :meth:`choose`.
            among: how many of the nearest frontiers count. what: what they are called.
        """
        bias, quantile = self._draw(view.rng, lambda: view.character, memory)
        distances = view.distances_m
        rank = round(quantile * (among - 1))
        # Frontiers come in the order of their cells, so a stable choice settles ties by cell:
        # all that are nearer than the distance at this rank stand before those at just it.
        at = np.partition(distances, rank)[rank]
        equals = (distances == at).nonzero()[0]
        chosen = int(equals[rank - np.count_nonzero(distances < at)])
        row, col = view.frontiers[chosen].tolist()
        return _choice((row, col), (bias, quantile), rank, among, what)


def _choice(
    cell: tuple[int, int], drawn: tuple[float, float], rank: int, among: int, what: str
) -> Choice:
    bias, quantile = drawn
    return Choice(
        cell,
        reason=f"quantile {quantile:.3f} of {among} {what} by distance",
        memory=bias,
        details={"quantile": quantile, "bias": bias, "rank": rank},
    )
