"""A run step by step: robots, teams and the map at any step, for pictures of any kind."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from swarmscout.core.enums import CHARGE, MODES, UNKNOWN
from swarmscout.core.errors import RunError
from swarmscout.viewing.map_image import Window, labels_of, window_round

if TYPE_CHECKING:
    from swarmscout.recording.run import Run

__all__ = ["Curve", "Moment", "Replay", "Team"]

MARGIN_M = 2.5


@dataclass(frozen=True)
class Team:
    """Robots of one team that explore.

    Attributes:
        leader: the robot that leads it, or the first member if the leader is not in the team.
        members: int64[n], robots.
        centre_m: float64[2], mean position; radius_m: distance of the farthest member from it.
        destination_m: float64[2], the destination, or None.
    """

    leader: int
    members: NDArray[np.int64]
    centre_m: NDArray[np.float64]
    radius_m: float
    destination_m: NDArray[np.float64] | None


@dataclass(frozen=True)
class Moment:
    """A run after one step.

    Attributes:
        step: the step.
        place_m: float64[N, 2], robots' positions; heading_rad: float64[N].
        charging: bool[N], CHR mode; alive: bool[N], not stranded.
        teams: teams of robots in EXP mode that are not stranded, including teams of one.
        labels: uint8[rows, cols] of the map (codes ``LABELS``).
        explored_m2: explored area.
    """

    step: int
    place_m: NDArray[np.float64]
    heading_rad: NDArray[np.float64]
    charging: NDArray[np.bool_]
    alive: NDArray[np.bool_]
    teams: list[Team]
    labels: NDArray[np.uint8]
    explored_m2: float

    @property
    def robot_kinds(self) -> NDArray[np.int64]:
        """int64[N]: 0 explores, 1 charges, 2 is stranded, as in ``Palette.robots``."""
        return np.where(self.alive, self.charging.astype(np.int64), 2)


class Curve:
    """What a run shows of which no robots were recorded: the explored area.

    Attributes:
        run: recorded with ``record="curves"`` or ``full``.
        last: the last step.
        explored_m2: float64[last + 1], explored area.
    """

    def __init__(self, run: Run) -> None:
        self.run = run
        self.last = run.last_step
        self.explored_m2 = run.coverage["explored_m2"].to_numpy()

    def moment(self, step: int) -> float:
        """Explored area after a step.

        Raises:
            RunError: there is no such step.
        """
        _check_step(step, self.last)
        return float(self.explored_m2[step])


class Replay:
    """The moments of a run; going forward from step to step is fast.

    Args:
        run: recorded with ``record="full"``.
        robot: the robot whose map the moments show; None for the swarm's.

    Attributes:
        last: the last step.
        explored_m2: float64[last + 1], explored area.

    Raises:
        RunError: steps were not recorded, the run has no step, or the robot does not exist.
    """

    def __init__(self, run: Run, robot: int | None = None) -> None:
        self.run = run
        self.robot = robot
        steps, robots = run.steps, run.scenario.robots
        count = steps.height // robots
        if not count:
            raise RunError(f"{run!r} has no step yet: nothing to show")
        self.last = count - 1

        def column(name: str) -> NDArray[Any]:
            return steps[name].to_numpy().reshape(count, robots)

        self._x_m, self._y_m = column("x_m"), column("y_m")
        self._heading = column("heading_rad")
        self._alive, self._team = column("alive"), column("team")
        self._leader, self._destination = column("leader"), column("destination")
        mode = steps["mode"].to_physical().to_numpy().reshape(count, robots)
        assert MODES[CHARGE] == "CHR"
        self._charging = mode == CHARGE
        self.explored_m2 = run.coverage["explored_m2"].to_numpy()[:count]
        changes = run.map_changes
        self._ever_changed = np.unique(changes["cell"].to_numpy())
        at, self._cells = changes["step"].to_numpy(), changes["cell"].to_numpy()
        odds = changes["log_odds"].to_numpy()
        if robot is not None:
            run.check_robot(robot)
            if run.own_maps:
                maps = run.robot_maps([robot])
                maps.advance(self.last)
                own = maps.changes(robot)
                at, self._cells, odds = own.step, own.cell, own.log_odds
        self._new = labels_of(odds, run.scenario)
        self._ends = np.searchsorted(at, np.arange(count), side="right")
        self._labels = np.zeros(run.frame.size, dtype=np.uint8)
        self._at = -1

    def moment(self, step: int) -> Moment:
        """A run after a step.

        Raises:
            RunError: the step does not exist.
        """
        _check_step(step, self.last)
        place = np.column_stack([self._x_m[step], self._y_m[step]])
        return Moment(
            step=step,
            place_m=place,
            heading_rad=self._heading[step],
            charging=self._charging[step],
            alive=self._alive[step],
            teams=self._teams(step, place),
            labels=self._labels_at(step),
            explored_m2=float(self.explored_m2[step]),
        )

    def window(self) -> Window:
        """The window round all that the mission maps and all robots at its end."""
        frame = self.run.frame
        cells = self._ever_changed
        places = np.column_stack([self._x_m[-1], self._y_m[-1]])
        mapped = frame.centres_of(frame.unflat_many(cells))
        return window_round(np.concatenate([mapped, places]), MARGIN_M)

    def _labels_at(self, step: int) -> NDArray[np.uint8]:
        if step < self._at:
            self._labels[:] = UNKNOWN
            self._at = -1
        begin = 0 if self._at < 0 else self._ends[self._at]
        # Rows are in order of steps: where a cell changed more than once the last change stays.
        self._labels[self._cells[begin : self._ends[step]]] = self._new[begin : self._ends[step]]
        self._at = step
        return self._labels.reshape(self.run.frame.shape).copy()

    def _teams(self, step: int, place: NDArray[np.float64]) -> list[Team]:
        frame = self.run.frame
        active = np.flatnonzero(self._alive[step] & ~self._charging[step])
        order = active[np.argsort(self._team[step, active], kind="stable")]
        cuts = np.flatnonzero(np.diff(self._team[step, order])) + 1
        teams = []
        for members in np.split(order, cuts) if len(order) else []:
            named = int(self._leader[step, members[0]])
            leader = named if named in members else int(members[0])
            cell = int(self._destination[step, leader])
            goal = None if cell < 0 else np.array(frame.centre_of(*frame.unflat(cell)))
            centre = place[members].mean(axis=0)
            radius = float(np.linalg.norm(place[members] - centre, axis=1).max())
            teams.append(Team(leader, members.astype(np.int64), centre, radius, goal))
        return teams


def _check_step(step: int, last: int) -> None:
    if not 0 <= step <= last:
        raise RunError(f"there is no step {step}: the run holds steps 0 to {last}")
