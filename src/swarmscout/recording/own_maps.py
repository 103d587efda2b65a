"""Maps of single robots, replayed from each robot's evidence and from who heard whom.

Where links are limited, robots know different things. A run records the evidence that each robot's
log gained in each step, and every change of the links. From these, each robot's map at any step
follows exactly, by the rule of the mission (``comms.exchange``). Versions are counted in steps
here: all that a robot had logged when a step ended travels together.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from swarmscout.core.grid import GridFrame
from swarmscout.mapping.log_odds import InverseSensorModel

if TYPE_CHECKING:
    import polars as pl

__all__ = ["GatheredEvidence", "MapChanges", "OwnMaps"]


class GatheredEvidence:
    """Evidence of all robots and who heard whom, step by step; it grows at its end only.

    One thread may add steps while others read earlier ones.

    Attributes:
        robots: N.
        steps: the last step added; 0 at first.
        ends: int64[>= steps + 1, N]; cells, increments: int32[>= entries]: see
            :func:`swarmscout.recording.evidence_replay.take_in`.
    """

    def __init__(self, robots: int) -> None:
        self.robots = robots
        self.steps = 0
        self.ends: NDArray[np.int64] = np.zeros((64, robots), dtype=np.int64)
        self.cells: NDArray[np.int32] = np.zeros(1024, dtype=np.int32)
        self.increments: NDArray[np.int32] = np.zeros(1024, dtype=np.int32)
        self._links: list[NDArray[np.uint8]] = [np.packbits(np.zeros((robots, robots), np.bool_))]

    @staticmethod
    def of(
        evidence: pl.DataFrame, links: pl.DataFrame, robots: int, last_step: int
    ) -> GatheredEvidence:
        """Evidence and links out of a run's tables of these names, up to a step."""
        gathered = GatheredEvidence(robots)
        heard = np.zeros((robots, robots), dtype=np.bool_)
        steps = np.arange(last_step + 2)
        cuts = evidence["step"].search_sorted(steps).to_numpy()
        entries = evidence.select("robot", "cell", "increment").to_numpy()
        link_cuts = links["step"].search_sorted(steps).to_numpy()
        pairs = links.select("listener", "speaker").to_numpy()
        hears = links["hears"].to_numpy()
        for step in range(1, last_step + 1):
            now = slice(link_cuts[step], link_cuts[step + 1])
            heard[pairs[now, 0], pairs[now, 1]] = hears[now]
            gathered.add(entries[cuts[step] : cuts[step + 1]], heard)
        return gathered

    def add(self, evidence: NDArray[np.integer], links: NDArray[np.bool_]) -> None:
        """Take in one step.

        Args:
            evidence: int[m, 3], rows (robot, cell, increment), by robot.
            links: bool[N, N]: links[i, j] says that i heard j.
        """
        step = self.steps + 1
        begin = int(self.ends[step - 1, -1])
        end = begin + len(evidence)
        if end > len(self.cells):
            more = max(end, 2 * len(self.cells)) - len(self.cells)
            self.cells = np.pad(self.cells, (0, more))
            self.increments = np.pad(self.increments, (0, more))
        if step >= len(self.ends):
            self.ends = np.pad(self.ends, ((0, len(self.ends)), (0, 0)))
        self.cells[begin:end] = evidence[:, 1]
        self.increments[begin:end] = evidence[:, 2]
        counts = np.bincount(evidence[:, 0], minlength=self.robots)
        self.ends[step] = begin + np.cumsum(counts)
        packed = np.packbits(links)
        # Links often stay as they are: one copy serves many steps.
        same = np.array_equal(packed, self._links[-1])
        self._links.append(self._links[-1] if same else packed)
        self.steps = step  # Last: readers find all of it.

    def links_in(self, step: int) -> NDArray[np.bool_]:
        """bool[N, N], who heard whom in a step."""
        bits = np.unpackbits(self._links[step], count=self.robots**2)
        return bits.reshape(self.robots, self.robots).view(np.bool_)


@dataclass(frozen=True)
class MapChanges:
    """How one robot's map changed, like the table ``map_changes``.

    Attributes:
        step: int64[m], ascending; cell: int32[m], ascending within a step.
        log_odds: int32[m], as read, in 1/1000 nat.
    """

    step: NDArray[np.int64]
    cell: NDArray[np.int32]
    log_odds: NDArray[np.int32]


class OwnMaps:
    """The maps of some robots, brought forward from step to step.

    Args:
        gathered: evidence of all robots.
        robots: whose maps.
        frame: the maps' frame.
        model: how evidence is read.

    Attributes:
        step: the step after which the maps stand.
        versions: int64[N, N]: versions[i, k] says up to which step i knows k's log.
    """

    def __init__(
        self,
        gathered: GatheredEvidence,
        robots: Sequence[int],
        frame: GridFrame,
        model: InverseSensorModel,
    ) -> None:
        self.step = 0
        self.versions: NDArray[np.int64] = np.zeros((gathered.robots,) * 2, dtype=np.int64)
        self._gathered = gathered
        self._robots = list(robots)
        self._frame = frame
        self._model = model
        self._evidence = np.zeros((len(self._robots), frame.size), dtype=np.int64)
        self._stamps = np.zeros((frame.size + 1, 2), dtype=np.int64)
        self._changed = np.zeros(frame.size, dtype=np.int32)
        self._log_odds = np.zeros(frame.size, dtype=np.int32)
        self._changes: list[list[MapChanges]] = [[] for _ in self._robots]

    def advance(self, step: int) -> None:
        """Bring the maps forward to a step, at most the last that was gathered."""
        # Late: a mission does not need this kernel, and should not wait for it or speak of it.
        from swarmscout.recording.evidence_replay import merge_versions, take_in

        merged = np.empty_like(self.versions)
        gathered = self._gathered
        for now in range(self.step + 1, step + 1):
            length = np.full(gathered.robots, now, dtype=np.int64)
            merge_versions(self.versions, length, gathered.links_in(now), merged)
            for m, robot in enumerate(self._robots):
                n = take_in(
                    self.versions[robot], merged[robot], gathered.ends, gathered.cells,
                    gathered.increments, self._evidence[m], self._stamps, self._model.lowest,
                    self._model.highest, self._changed, self._log_odds,
                )  # fmt: skip
                order = np.argsort(self._changed[:n])
                self._changes[m].append(
                    MapChanges(np.full(n, now), self._changed[:n][order], self._log_odds[:n][order])
                )
            self.versions, merged = merged, self.versions
            self.step = now

    def log_odds(self, robot: int) -> NDArray[np.int32]:
        """int32[rows, cols]: a robot's map now, log-odds as read in 1/1000 nat."""
        evidence = self._evidence[self._robots.index(robot)]
        read = np.clip(evidence, self._model.lowest, self._model.highest)
        narrow: NDArray[np.int32] = read.astype(np.int32)
        return narrow.reshape(self._frame.shape)

    def changes(self, robot: int, first: int = 1) -> MapChanges:
        """How a robot's map changed from step `first` on, up to now."""
        pieces = self._changes[self._robots.index(robot)][max(0, first - 1) :]
        if not pieces:
            return MapChanges(np.zeros(0, np.int64), np.zeros(0, np.int32), np.zeros(0, np.int32))
        return MapChanges(
            np.concatenate([piece.step for piece in pieces]),
            np.concatenate([piece.cell for piece in pieces]),
            np.concatenate([piece.log_odds for piece in pieces]),
        )
