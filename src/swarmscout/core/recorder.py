"""The seam between a mission and what records it.

A recorder is called once before the first step, after each step, and once at the end. The arrays in
a :class:`StepRecord` belong to the mission, which reuses them in the next step: do not write to
them, and copy what you keep. Its dictionaries and its decisions are new in each step.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from swarmscout.core.language_model import Attempt

__all__ = ["Decision", "Recorder", "StepRecord"]


@dataclass(frozen=True, slots=True)
class Decision:
    """One decision of a team's leader for a destination.

    Attributes:
        step: when.
        team: the team's id.
        leader: the robot that decided.
        cause: why a new destination was needed, one of :data:`swarmscout.core.enums.CAUSES`.
        selector: the selector's name.
        cell: the chosen ``(row, col)``, or None when there was no frontier to choose.
        x_m: x of the chosen cell's centre (NaN without a cell).
        y_m: y of it.
        distance_m: straight distance from the team's position to it.
        frontiers: number of frontier cells in view.
        frontier_neighbours: frontier cells among the chosen cell's 8 neighbours.
        obstacle_neighbours: occupied cells among them.
        reason: the selector's own words.
        details: what else the selector wants on record (plain data for JSON).
        attempts: the questions that a language model was asked for it, with their answers.
    """

    step: int
    team: int
    leader: int
    cause: str
    selector: str
    cell: tuple[int, int] | None
    x_m: float
    y_m: float
    distance_m: float
    frontiers: int
    frontier_neighbours: int
    obstacle_neighbours: int
    reason: str
    details: Mapping[str, Any]
    attempts: tuple[Attempt, ...] = ()


class BodiesNow(Protocol):
    """What a record shows of :class:`swarmscout.robots.bodies.Bodies`."""

    charge: NDArray[np.float64]
    alive: NDArray[np.bool_]

    @property
    def contact(self) -> NDArray[np.int64]: ...
    @property
    def pose(self) -> NDArray[np.float64]: ...


class MindsNow(Protocol):
    """What a record shows of :class:`swarmscout.minds.minds.Minds`."""

    @property
    def mode(self) -> NDArray[np.int64]: ...
    @property
    def team(self) -> NDArray[np.int64]: ...
    @property
    def leader(self) -> NDArray[np.int64]: ...
    @property
    def desired(self) -> NDArray[np.int64]: ...
    @property
    def destination(self) -> NDArray[np.int64]: ...
    @property
    def target(self) -> NDArray[np.int64]: ...


@dataclass(slots=True)
class StepRecord:
    """What happened in one step.

    Properties are worked out when they are read, so a recorder of curves does not pay for poses.
    Which of them a run keeps says :data:`swarmscout.recording.tables.TABLES`.

    Attributes:
        step: 1 for the first step; 0 is the state before it.
        bodies, minds: the mission's own, as they are after the step. Read the properties instead.
        capacity_steps: a full battery, in steps.
        action: int64[N], codes ``ACTIONS``: what each robot did in the step.
        events: int64[k, 4] rows of (kind, robot, other, value), see ``core.enums``.
        map_cells: int64[m] flat map cells whose log-odds, as read, changed in the step (of the
            map that the swarm as a whole has).
        map_log_odds: int64[m] their log-odds, saturated, in 1/1000 nat.
        decisions: the step's destination decisions, in robot order.
        coverage: one row of the ``coverage`` table without its step.
        seconds: what the clock measured: phase name to seconds.
        evidence: int64[m, 3] rows of (robot, flat cell, increment in 1/1000 nat): what each robot's
            own log gained in the step, by robot; None where one map serves all.
        links: bool[N, N], who heard whom in the step; None where one map serves all.
    """

    step: int
    bodies: BodiesNow
    minds: MindsNow
    capacity_steps: int
    action: NDArray[np.int64]
    events: NDArray[np.int64]
    map_cells: NDArray[np.int64]
    map_log_odds: NDArray[np.int64]
    decisions: list[Decision]
    coverage: dict[str, float | int]
    seconds: dict[str, float]
    evidence: NDArray[np.int64] | None = None
    links: NDArray[np.bool_] | None = None

    @property
    def pose(self) -> NDArray[np.float64]:
        """float64[N, 3]: true x_m, y_m, heading_rad after the step."""
        return self.bodies.pose

    @property
    def x_m(self) -> NDArray[np.float64]:
        """float64[N]: x of each body's centre."""
        return self.pose[:, 0]

    @property
    def y_m(self) -> NDArray[np.float64]:
        """float64[N]: y of it."""
        return self.pose[:, 1]

    @property
    def heading_rad(self) -> NDArray[np.float64]:
        """float64[N]: headings, counter-clockwise from the x axis."""
        return self.pose[:, 2]

    @property
    def charge(self) -> NDArray[np.float64]:
        """float64[N]: charge left, as a fraction of the capacity."""
        return self.bodies.charge / self.capacity_steps

    @property
    def contact(self) -> NDArray[np.int64]:
        """int64[N]: 0 none, 1 wall, 2 robot (a forward move that was not made)."""
        return self.bodies.contact

    @property
    def alive(self) -> NDArray[np.bool_]:
        """bool[N]: False for a stranded robot."""
        return self.bodies.alive

    @property
    def mode(self) -> NDArray[np.int64]:
        """int64[N], codes ``MODES``."""
        return self.minds.mode

    @property
    def team(self) -> NDArray[np.int64]:
        """int64[N] team ids."""
        return self.minds.team

    @property
    def leader(self) -> NDArray[np.int64]:
        """int64[N] robot indices."""
        return self.minds.leader

    @property
    def desired(self) -> NDArray[np.int64]:
        """int64[N] desired team sizes."""
        return self.minds.desired

    @property
    def destination(self) -> NDArray[np.int64]:
        """int64[N] flat map cells, or -1."""
        return self.minds.destination

    @property
    def target(self) -> NDArray[np.int64]:
        """int64[N], the cells that robots drive to themselves: see ``teams.members``."""
        return self.minds.target


class Recorder(Protocol):
    """Keeps what a mission does."""

    def begin(self, mission: Any) -> None:
        """Called once, before the first step, with the mission about to run."""

    def record(self, record: StepRecord) -> None:
        """Called after each step, and once before the first with ``step == 0``."""

    def end(self, summary: Mapping[str, Any]) -> None:
        """Called once, after the last step, with the mission's summary."""
