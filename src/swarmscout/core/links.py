"""Who hears whom in one step: what a radio says, and all that minds learn of it."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from swarmscout.core.errors import ScenarioError

__all__ = ["Links"]


def _none() -> NDArray[np.int64]:
    return np.zeros(0, dtype=np.int64)


@dataclass(frozen=True)
class Links:
    """The robots that each robot hears, as sparse neighbour lists.

    Attributes:
        robots: N.
        complete: whether each robot hears all others; then the lists are empty.
        start: int64[N + 1], where the list of each listener begins and ends in `senders`.
        senders: int64[M], the robots heard, ascending for each listener and never itself.
        quality: float64[M] in (0, 1], how well each is heard.
    """

    robots: int
    complete: bool = False
    start: NDArray[np.int64] = field(default_factory=_none, repr=False)
    senders: NDArray[np.int64] = field(default_factory=_none, repr=False)
    quality: NDArray[np.float64] = field(default_factory=lambda: np.zeros(0), repr=False)

    @staticmethod
    def full(robots: int) -> Links:
        """Each robot hears all others."""
        return Links(robots, complete=True)

    @staticmethod
    def of_pairs(
        robots: int,
        listeners: NDArray[np.int64],
        senders: NDArray[np.int64],
        quality: NDArray[np.float64] | None = None,
    ) -> Links:
        """Links from pairs.

        Args:
            robots: N.
            listeners, senders: int64[M], each pair of different robots at most once.
            quality: float64[M]; 1 where not given.
        """
        # One number for each pair: a single sort is twice as fast as one by two keys.
        order = np.argsort(listeners * robots + senders)
        start = np.zeros(robots + 1, dtype=np.int64)
        np.cumsum(np.bincount(listeners, minlength=robots), out=start[1:])
        strength = np.ones(len(order)) if quality is None else quality[order]
        return Links(robots, False, start, senders[order].astype(np.int64), strength)

    @staticmethod
    def of_matrix(matrix: Any, robots: int, source: str) -> Links:
        """Links from bool[N, N]: element (i, j) says whether robot i hears robot j.

        Args:
            matrix: what was given.
            robots: N.
            source: what gave it, for error messages.

        Raises:
            ScenarioError: it is not such a matrix.
        """
        try:
            given = np.asarray(matrix)
        except ValueError:  # Rows of different lengths.
            given = np.asarray(None)
        if given.shape != (robots, robots) or given.dtype.kind not in "bui":
            what = "None" if matrix is None else f"{given.dtype}{list(given.shape)}"
            raise ScenarioError(
                f"{source} returned {what}, expected bool[{robots}, {robots}]: "
                "element [i, j] says whether robot i hears robot j"
            )
        heard = given.astype(np.bool_)
        np.fill_diagonal(heard, False)
        listeners, senders = heard.nonzero()
        return Links.of_pairs(robots, listeners, senders)

    def matrix(self) -> NDArray[np.bool_]:
        """bool[N, N]: element (i, j) says whether robot i hears robot j; robots hear themselves."""
        heard = np.eye(self.robots, dtype=np.bool_)
        if self.complete:
            heard[:] = True
        else:
            heard[np.repeat(np.arange(self.robots), np.diff(self.start)), self.senders] = True
        return heard
