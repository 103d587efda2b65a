"""A running mission as a source of the player: a recorder that remembers what the page needs.

A step costs the mission a dozen small copies; packets are made from them in the server's threads.
Memory: 50 bytes per robot and step, and about 100 more where each robot has a map of its own.
"""

from __future__ import annotations

import gzip
import threading
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from swarmscout.core.recorder import Decision, StepRecord
from swarmscout.recording.decisions import plain
from swarmscout.recording.own_maps import GatheredEvidence, OwnMaps
from swarmscout.viewing.player.beliefs import Beliefs
from swarmscout.viewing.player.page_text import page_data
from swarmscout.viewing.player.questions import questions_live
from swarmscout.viewing.player.recorded import mission_packet
from swarmscout.viewing.player.step_range import StepRange, pack_steps, robot_columns, whole_numbers

__all__ = ["LiveMission"]

MOST_STEPS = 500
"""Most steps in one packet."""


@dataclass(slots=True)
class _Step:
    columns: dict[str, NDArray[Any]]
    map_cells: NDArray[np.int32]
    map_log_odds: NDArray[np.int16]
    events: NDArray[np.int64]
    decisions: list[Decision]
    coverage: Mapping[str, float | int]


class LiveMission:
    """Shows a mission while it runs; give it to the mission as a recorder.

    Args:
        name: of the run on the page.

    Example:
        >>> live = LiveMission("mine")
        >>> mission = Mission(Scenario(robots=15), recorder=live)  # doctest: +SKIP
        >>> with PlayerServer([live]) as server:  # doctest: +SKIP
        ...     print(server.url)
        ...     mission.run()
    """

    live = True

    def __init__(self, name: str = "mission") -> None:
        self.name = name
        self._head = b""
        self._columns = 0
        self._steps: list[_Step] = []
        self._ending: dict[str, Any] | None = None
        self._came = threading.Condition()
        self._gathered: GatheredEvidence | None = None
        self._beliefs: Beliefs | None = None

    def begin(self, mission: Any) -> None:
        """Take the facts that do not change."""
        self._columns = mission.frame.columns
        self._head = mission_packet(
            self.name, mission.scenario, mission.world, mission.frame, mission.stations_m,
            {"own_maps": mission.own_maps},
        )  # fmt: skip
        if mission.own_maps:
            self._gathered = gathered = GatheredEvidence(mission.scenario.robots)
            frame, model = mission.frame, mission.swarm.model
            self._beliefs = Beliefs(lambda robots: OwnMaps(gathered, robots, frame, model))

    def record(self, record: StepRecord) -> None:
        """Take a step."""
        step = _Step(
            columns={c.name: whole_numbers(c, c.source(record)) for c in robot_columns()},
            map_cells=record.map_cells.astype(np.int32),
            map_log_odds=record.map_log_odds.astype(np.int16),
            events=np.insert(record.events, 0, record.step, axis=1),
            decisions=record.decisions,
            coverage=dict(record.coverage),
        )
        if self._gathered is not None and record.evidence is not None and record.links is not None:
            self._gathered.add(record.evidence, record.links)
        with self._came:
            self._steps.append(step)
            self._came.notify_all()

    def end(self, summary: Mapping[str, Any]) -> None:
        """The mission is over."""
        self._finish({"finished": True, "summary": page_data(plain(summary)), **_reason(summary)})

    def broken_off(self) -> None:
        """The mission was stopped."""
        self._finish({"finished": False, "end_reason": "broken off"})

    def _finish(self, ending: dict[str, Any]) -> None:
        with self._came:
            self._ending = ending
            self._came.notify_all()

    def data(self) -> bytes:
        """All steps so far, gzipped packets.

        Before the mission has begun this waits for its first step.
        """
        with self._came:
            self._came.wait_for(lambda: self._steps or self._ending is not None)
            steps = self._steps[:]
        history = pack_steps(self._block(0, steps)) if steps else b""
        # Loopback is fast, and the mission needs the processor: compress lightly.
        return gzip.compress(self._head + history, compresslevel=1, mtime=0)

    def news(self, first: int, wait_s: float) -> tuple[bytes, int]:
        """The steps from `first` on as a packet, and the step after them; b"" if there are none."""
        with self._came:
            self._came.wait_for(
                lambda: len(self._steps) > first or self._ending is not None, timeout=wait_s
            )
            steps = self._steps[first : first + MOST_STEPS]
        if not steps:
            return b"", first
        return pack_steps(self._block(first, steps)), first + len(steps)

    def belief(self, robot: int, first: int) -> bytes | None:
        """One robot's map from step `first` on, a gzipped packet; None where it has none."""
        if self._gathered is None or self._beliefs is None or robot >= self._gathered.robots:
            return None
        last = self._gathered.steps
        packet = self._beliefs.packet(robot, min(first, last + 1), last)
        return gzip.compress(packet, compresslevel=1, mtime=0)

    def ending(self) -> dict[str, Any] | None:
        """The facts of the mission's end, or None while it runs."""
        return self._ending

    def _block(self, first: int, steps: Sequence[_Step]) -> StepRange:
        return StepRange(
            first=first,
            columns={
                c.name: np.stack([step.columns[c.name] for step in steps]) for c in robot_columns()
            },
            map_counts=np.array([len(step.map_cells) for step in steps]),
            map_cells=np.concatenate([step.map_cells for step in steps]),
            map_log_odds=np.concatenate([step.map_log_odds for step in steps]),
            events=np.concatenate([step.events for step in steps]),
            decisions=[self._row(decision) for step in steps for decision in step.decisions],
            coverage={
                name: np.array([step.coverage[name] for step in steps], dtype=np.float64)
                for name in steps[0].coverage
            },
        )

    def _row(self, decision: Decision) -> dict[str, Any]:
        """A decision as the table ``decisions`` has it."""
        row: dict[str, Any] = plain(asdict(replace(decision, attempts=())))
        row["attempts"] = plain(questions_live(decision, self._columns))
        if not row["attempts"]:
            del row["attempts"]
        if decision.cell is not None:
            row["cell"] = decision.cell[0] * self._columns + decision.cell[1]
        return row


def _reason(summary: Mapping[str, Any]) -> dict[str, Any]:
    return {"end_reason": summary["end_reason"]} if "end_reason" in summary else {}
