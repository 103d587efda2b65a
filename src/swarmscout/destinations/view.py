"""What a leader's rule gets to see: a small frozen view. What is not in it cannot be used."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, fields
from functools import cached_property
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from swarmscout.core.grid import GridFrame
from swarmscout.core.streams import stream
from swarmscout.destinations.features import Features
from swarmscout.mapping.occupancy import BeliefView

__all__ = ["LeaderView", "OtherTeams"]

T = TypeVar("T", bound=np.generic)


@dataclass(frozen=True)
class OtherTeams:
    """The other teams, as last heard from their leaders, in the order of their leaders' ids.

    Attributes:
        leaders: int64[T].
        sizes: int64[T], members, as their leaders know.
        positions_m: float64[T, 2].
        destinations_m: float64[T, 2], NaN for a team without one.
    """

    leaders: NDArray[np.int64]
    sizes: NDArray[np.int64]
    positions_m: NDArray[np.float64]
    destinations_m: NDArray[np.float64]


@dataclass(frozen=True)
class LeaderView:
    """What the leader of a team knows when it chooses a destination.

    All arrays are read-only. Points are ``(x_m, y_m)``; cells are ``(row, col)``.

    Attributes:
        step: the current step.
        robot: the leader.
        pose: ``(x_m, y_m, heading_rad)``, as the leader believes.
        position_m: the team's position: the leader's, or the mean of its members'.
        charge: the leader's charge as a share of the capacity.
        frame: where the map lies.
        frontiers: int64[F, 2], the cells to choose from: the task's candidates in the leader's
            map (in exploration its frontiers), but for those that its team gave up lately; by row
            and then by column. F ≥ 1.
        frontiers_m: float64[F, 2], their centres in metres.
        members: int64[n], robots of the team, the leader among them.
        members_m: float64[n, 2], where they were last heard.
        members_heading_rad: float64[n], where they were last heard to look, the leader's own too.
        previous: the cell of the team's last destination, or None.
        cause: why a new destination is needed, one of ``core.enums.CAUSES``.
    """

    step: int
    robot: int
    pose: tuple[float, float, float]
    position_m: tuple[float, float]
    charge: float
    frame: GridFrame
    frontiers: NDArray[np.int64]
    frontiers_m: NDArray[np.float64]
    members: NDArray[np.int64]
    members_m: NDArray[np.float64]
    previous: tuple[int, int] | None
    cause: str
    _seed: int = field(repr=False)
    _map: BeliefView = field(repr=False)
    _others: Callable[[], OtherTeams] = field(repr=False)
    _route_costs: Callable[[NDArray[np.int64], int | None], NDArray[np.float64]] = field(repr=False)
    _features: Features = field(repr=False)
    members_heading_rad: NDArray[np.float64] = field(default_factory=lambda: np.zeros(0))

    @cached_property
    def others(self) -> OtherTeams:
        """The other teams as last heard."""
        return self._others()

    @cached_property
    def labels(self) -> NDArray[np.uint8]:
        """uint8[rows, cols], the leader's map: UNKNOWN, FREE or OCCUPIED."""
        return _frozen(self._map.labels)

    @cached_property
    def log_odds(self) -> NDArray[np.int32]:
        """int32[rows, cols], the leader's map: log-odds as read, in 1/1000 nat."""
        return _frozen(self._map.log_odds)

    @cached_property
    def distances_m(self) -> NDArray[np.float64]:
        """float64[F], straight distances from the team's position to the frontiers."""
        x_m = self.frontiers_m[:, 0] - self.position_m[0]
        y_m = self.frontiers_m[:, 1] - self.position_m[1]
        x_m *= x_m
        y_m *= y_m
        x_m += y_m
        return _frozen(np.sqrt(x_m, out=x_m))

    def is_frontier(self, cell: tuple[int, int]) -> bool:
        """Whether a cell is one of `frontiers`.

        Args:
            cell: ``(row, col)``.
        """
        row, col = cell
        return self.frame.contains(row, col) and bool(self._features.has(self.frame.flat(row, col)))

    def route_costs(self, nearest: int | None = None) -> NDArray[np.float64]:
        """Costs of the best routes from the leader to the frontiers.

        Args:
            nearest: enough if this many of the nearest are known (faster).

        Returns:
            float64[F] in metres of free way; inf where there is no route (or beyond `nearest`).
        """
        return self._route_costs(self.frontiers, nearest)

    @cached_property
    def path_length_m(self) -> NDArray[np.float64]:
        """float64[F], shortest ways from the leader over free cells; inf where there is none.

        Much faster than :meth:`route_costs`, whose routes may lead through unknown cells too.
        """
        return _frozen(self._walk[0])

    @cached_property
    def turns_rad(self) -> NDArray[np.float64]:
        """float64[F] in [0, π], how far the leader has to turn for the first metre of each way.

        Where there is no way over free cells, of the straight line.
        """
        offsets = self._features.centres_m(self._walk[1]) - np.array(self.pose[:2])
        off = np.arctan2(offsets[:, 1], offsets[:, 0]) - self.pose[2]
        return _frozen(np.abs(off - 2.0 * np.pi * np.round(off / (2.0 * np.pi))))

    @cached_property
    def others_path_length_m(self) -> NDArray[np.float64]:
        """float64[F], shortest ways from any other team over free cells; inf: none, or no team."""
        if len(self.others.leaders) == 0:
            return _frozen(np.full(len(self.frontiers), np.inf))
        return _frozen(self._features.walk_from(self.others.positions_m))

    @cached_property
    def in_own_voronoi_cell(self) -> NDArray[np.bool_]:
        """bool[F], the team's Voronoi cell: no other team's way over free cells is shorter.

        Where another team's is as short, one of them has it.
        """
        return _frozen(self._features.in_own_voronoi_cell(self.others.positions_m))

    @cached_property
    def frontier_neighbours(self) -> NDArray[np.int64]:
        """int64[F], frontier cells among the 8 neighbours of each frontier cell."""
        return _frozen(self._around[0])

    @cached_property
    def obstacle_neighbours(self) -> NDArray[np.int64]:
        """int64[F], occupied cells among the 8 neighbours of each frontier cell."""
        return _frozen(self._around[1])

    @cached_property
    def clusters(self) -> NDArray[np.int64]:
        """int64[F], numbers 0, 1, …: frontier cells that touch, corners too, have the same."""
        return _frozen(self._features.clusters())

    def area_m2(self, kind: str, reach_m: float) -> NDArray[np.float64]:
        """Area of a kind round each frontier cell, whether walls hide it or not.

        Args:
            kind: "unknown", "free", "occupied" or "frontier" (those free cells that are frontiers).
            reach_m: within so many metres of the cell's centre.

        Returns:
            float64[F] in m².
        """
        return _frozen(self._features.area_m2(kind, reach_m))

    def unknown_m2(self, reach_m: float) -> NDArray[np.float64]:
        """float64[F], unknown area within reach of each frontier cell, see :meth:`area_m2`."""
        return self.area_m2("unknown", reach_m)

    @cached_property
    def _walk(self) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
        return self._features.walk()

    @cached_property
    def _around(self) -> NDArray[np.int64]:
        return self._features.around()

    def among(self, keep: NDArray[np.bool_]) -> LeaderView:
        """The same view with fewer frontiers to choose from, and with fresh generators.

        Args:
            keep: bool[F], at least one of them true.
        """
        kept = {field.name: getattr(self, field.name) for field in fields(self)}
        kept["frontiers"] = _frozen(self.frontiers[keep])
        kept["frontiers_m"] = _frozen(self.frontiers_m[keep])
        kept["_features"] = self._features.among(keep)
        return LeaderView(**kept)

    @cached_property
    def rng(self) -> np.random.Generator:
        """The leader's own generator for this decision, addressed by robot and step."""
        return stream(self._seed, "decide", self.robot, self.step)

    @cached_property
    def character(self) -> np.random.Generator:
        """The leader's own generator for what stays the same over a mission, as a personal bias.

        It starts anew with each view, so the same draws give the same numbers in every step.
        """
        return stream(self._seed, "character", self.robot)

    def neighbour_counts(self, cell: tuple[int, int]) -> tuple[int, int]:
        """Frontier and occupied cells among a cell's 8 neighbours (paper, "LLM-based …").

        Args:
            cell: ``(row, col)``.
        """
        return self._map.neighbour_counts(cell)


def _frozen(array: NDArray[T]) -> NDArray[T]:
    array.flags.writeable = False
    return array
