"""Leaders that share a map and choose in the same step, as arrays that kernels read.

The rules that this package recommends can choose for all of them in one call
(:class:`BatchSelector`). What they choose, and why, is the same as one by one from views; tests
compare them.
"""

from __future__ import annotations

from collections.abc import Callable, Hashable, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple, Protocol, TypeVar, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from swarmscout.core.streams import stream
from swarmscout.destinations.features import Frontiers
from swarmscout.destinations.offers import OFFERS
from swarmscout.destinations.selector import Choice, Selector
from swarmscout.minds.minds import Minds

__all__ = ["ASKED", "Batch", "BatchSelector", "Land", "Memory", "Outcome"]

T = TypeVar("T")

ASKED = np.dtype(
    [
        ("leader", "i8"),  # who chooses
        ("routed", "i8"),  # the row of `Land.routed` that counts for it; -1: it doubts nothing
        ("at", "i8"),  # written: which of the F candidates it chose; -1: it may choose none now
        ("offered", "i8"),  # written: how many it could choose from
        ("doubts", "?"),  # written: whether it still doubts
    ],
    align=True,
)
"""One leader that chooses; a rule's kernel appends fields of its own."""


class Land(NamedTuple):
    """The candidates of one map, for kernels.

    Attributes:
        status: uint8[C'], see ``OccupancyGrids``.
        flat: int64[F], the candidates, ascending.
        routed: bool[K, F], whether a route leads to each, see ``Candidates``.
    """

    status: NDArray[np.uint8]
    flat: NDArray[np.int64]
    routed: NDArray[np.bool_]


class Memory(NamedTuple):
    """What robots avoid, see ``Minds``: int64[N, 32, 2] and GIVEN_UP[N, 256]."""

    avoided: NDArray[np.int64]
    given_up: NDArray[np.void]


@dataclass(frozen=True)
class Outcome:
    """What a rule chose for one leader of a batch.

    Attributes:
        choice: the choice; None if the leader may choose nothing now.
        offered: how many candidates it had.
        doubts: whether one of its candidates has no route.
    """

    choice: Choice | None
    offered: int
    doubts: bool


@dataclass(frozen=True)
class Batch:
    """The leaders of one map that choose in a step. A kernel reads their own records only.

    Attributes:
        step: the current step. seed: the mission's.
        leaders: int64[L], ascending.
        minds: what robots believe.
        heard: BEACON[N], what all of them have heard.
        teams: int64[2, M], team and id of the robots whose notices they have heard, sorted.
        frontiers: the candidates.
        routed: bool[K, F], mask: int64[L]: see ``ASKED`` and ``Land``.
        ticks: heading ticks of a full circle.
        silence_steps: a robot that was not heard for more steps than this counts no more.
        place_cells: edge of a place in cells, see ``minds.given_up``.
        kept: what rules keep over a mission, see :meth:`once`.
    """

    step: int
    seed: int
    leaders: NDArray[np.int64]
    minds: Minds
    heard: NDArray[np.void]
    teams: NDArray[np.int64]
    frontiers: Frontiers
    routed: NDArray[np.bool_]
    mask: NDArray[np.int64]
    ticks: int
    silence_steps: int
    place_cells: int
    kept: dict[Hashable, Any]

    def once(self, key: Hashable, make: Callable[[], T]) -> T:
        """What was made for a key earlier in the mission, else what `make` returns now."""
        if key not in self.kept:
            self.kept[key] = make()
        found: T = self.kept[key]
        return found

    @property
    def offers(self) -> NDArray[np.void]:
        """OFFERS[1]."""

        def make() -> NDArray[np.void]:
            offers = np.zeros(1, dtype=OFFERS)
            self.frontiers.frame.write_into(offers[0])
            offers["place_cells"] = self.place_cells
            return offers

        return self.once("offers", make)

    def asked(self, dtype: np.dtype[np.void]) -> NDArray[np.void]:
        """dtype[L], ASKED and further fields: who chooses."""
        asked = np.zeros(len(self.leaders), dtype=dtype)
        asked["leader"], asked["routed"] = self.leaders, self.mask
        return asked

    @property
    def land(self) -> Land:
        """The candidates."""
        return Land(self.frontiers.status, self.frontiers.flat, self.routed)

    @property
    def memory(self) -> Memory:
        """What robots avoid."""
        return Memory(self.minds.avoided, self.minds.given_up)

    def decide(self, robot: int) -> np.random.Generator:
        """A leader's generator for this decision, as ``LeaderView.rng``."""
        return stream(self.seed, "decide", robot, self.step)

    def character(self, robot: int) -> np.random.Generator:
        """A robot's generator for what stays the same, as ``LeaderView.character``."""
        return stream(self.seed, "character", robot)

    def cell(self, at: int) -> tuple[int, int]:
        """The cell of a candidate."""
        return self.frontiers.frame.unflat(int(self.frontiers.flat[at]))


@runtime_checkable
class BatchSelector(Selector, Protocol):
    """A selector that can choose for many leaders in one call.

    It reads of `batch` what a :class:`~swarmscout.destinations.view.LeaderView` would show each
    leader, and chooses the same.
    """

    def chooses_in_batches(self) -> bool:
        """Whether it can with its present parameters."""
        ...

    def choose_batch(self, batch: Batch, memories: Sequence[Any]) -> list[Outcome]:
        """Choose for each leader of a batch.

        Args:
            batch: the leaders. memories: what their last choices carried, see ``Selector``.
        """
        ...
