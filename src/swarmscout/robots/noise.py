"""Measurement noise with an address: the same seed and step give the same numbers."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from swarmscout.core.streams import stream

__all__ = ["Noise"]

BLOCK_STEPS = 50
"""Steps that share one random stream: opening a stream for each step would cost too much."""

_FEW_NUMBERS = 100_000


class Noise:
    """Standard normal numbers for each step, drawn for all robots whether they are alive or not.

    Args:
        purpose: of the random stream, for example ``"sensor"``.
    """

    def __init__(self, purpose: str) -> None:
        self._purpose = purpose
        self._of: tuple[int, tuple[int, ...]] = -1, ()
        self._first = -1
        self._drawn: NDArray[np.float64] = np.zeros((1, 0))

    def at(self, seed: int, shape: tuple[int, ...], step: int) -> NDArray[np.float64]:
        """One step's numbers, which the next call may overwrite.

        Args:
            seed: the mission's seed. shape: of the numbers. step: the step.
        """
        if self._of != (seed, shape):
            # Many numbers are drawn step by step, which needs less memory and gives the same ones.
            at_once = BLOCK_STEPS if math.prod(shape) <= _FEW_NUMBERS else 1
            self._of, self._first = (seed, shape), -1
            self._drawn = np.zeros((at_once, *shape))
        at_once = len(self._drawn)
        first = step - step % at_once
        if first != self._first:
            self._draw(first)
        numbers: NDArray[np.float64] = self._drawn[step - first]
        return numbers

    def _draw(self, first: int) -> None:
        block, within = divmod(first, BLOCK_STEPS)
        at_once = len(self._drawn)
        goes_on = within > 0 and first == self._first + at_once
        if not goes_on:
            self._stream = stream(self._of[0], self._purpose, block)
        for _ in range(1 if goes_on else within // at_once + 1):
            self._stream.standard_normal(out=self._drawn)
        self._first = first
