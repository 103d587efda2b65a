"""Phase 7 of a step: routes, each robot for itself, to the shared destination or a station."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from swarmscout.comms.knowledge import Knowledge
from swarmscout.core.events import EventLog
from swarmscout.core.grid import GridFrame
from swarmscout.mapping.occupancy import OccupancyGrids
from swarmscout.minds.minds import Minds
from swarmscout.planning.costs import RouteCosts
from swarmscout.planning.following import DRIVING, find_needs, mark_standing, steer
from swarmscout.planning.route_table import RouteTable, blank_routes
from swarmscout.planning.search import plan_routes, route_cost_field
from swarmscout.planning.search_memory import Search

__all__ = ["Planner", "Vehicle"]

LONG_STILL_STEPS = 10
"""A robot that has not moved for this many steps makes routes through its place dearer."""

SIDE_ROOM_M = 0.05
"""A straight way has to be wider than the robot by this on each side."""


@dataclass(frozen=True)
class Vehicle:
    """What routes need to know of a robot's body.

    Attributes:
        radius_m, forward_m: half of its diameter, and the length of one move.
        turn_ticks: the angle of one rotation, in ticks.
        dock_m: near enough to a station to charge.
        headings: float64[3600, 2], (cos, sin).
    """

    radius_m: float
    forward_m: float
    turn_ticks: int
    dock_m: float
    headings: NDArray[np.float64]


class Planner:
    """Plans and follows the routes of N robots.

    Attributes:
        table: the routes.
        costs: what moving costs.
        stations_m: float64[k, 2], where the charging stations are.

    Args:
        frame: the occupancy grids'.
        robots: N.
        costs: what moving costs.
        stations_m: float64[k, 2].
        vehicle: the robots' body.
    """

    def __init__(
        self,
        frame: GridFrame,
        robots: int,
        costs: RouteCosts,
        stations_m: NDArray[np.float64],
        vehicle: Vehicle,
    ) -> None:
        self.frame = frame
        self.costs = costs
        self.stations_m = stations_m
        self.table: RouteTable = blank_routes(robots)
        self._search = Search(frame, costs)
        self._standing = np.full((1, robots), -1, dtype=np.int64)
        self._docks = dock_cells(frame, stations_m)
        self._headings = vehicle.headings
        turn_ticks = vehicle.turn_ticks
        # At most 30°, if turns are not too coarse for that.
        most_off = max(turn_ticks // 2, min(3 * turn_ticks // 4, len(vehicle.headings) // 12))
        # Driving while off by up to that, a robot gets nearer to a waypoint only while that is
        # farther than forward / (2 cos(off)); nearer, it would circle it.
        cosine = max(0.5, float(vehicle.headings[most_off, 0]))
        self._grid = np.zeros(1, dtype=DRIVING)
        grid = self._grid[0]
        for name in ("origin_x_m", "origin_y_m", "cell_m", "rows", "columns"):
            grid[name] = getattr(frame, name)
        grid["long_still"] = LONG_STILL_STEPS
        grid["most_off"] = most_off
        grid["waypoint_m"] = max(0.5 * frame.cell_m, 1.05 * vehicle.forward_m / (2.0 * cosine))
        grid["half_width_m"] = vehicle.radius_m + SIDE_ROOM_M
        grid["dock_m"] = vehicle.dock_m

    @property
    def stop_m(self) -> float:
        """A route is driven to its end once a robot is this near to the goal."""
        return float(self._grid[0]["waypoint_m"])

    def plan(self, minds: Minds, knowledge: Knowledge, step: int, events: EventLog) -> None:
        """Give every robot that needs one a route over its own map."""
        grids, table, search = knowledge.grids, self.table, self._search
        needs = find_needs(
            minds.own, knowledge.ear, grids.price, grids.counts, table.state, table.cells,
            self._grid, step,
        )  # fmt: skip
        if not needs:
            return
        if len(self._standing) < len(knowledge.heard):
            self._standing = np.full(knowledge.still.shape, -1, dtype=np.int64)
        mark_standing(knowledge.heard, knowledge.still, knowledge.rows, self._grid, self._standing)
        plan_routes(
            grids.price, grids.bounds, search.toll, search.nodes, search.buckets, search.state,
            self._standing, self._docks, table.state, table.cells, step, events.rows,
        )  # fmt: skip

    def steer(
        self,
        minds: Minds,
        knowledge: Knowledge,
        contact: NDArray[np.int64],
        action: NDArray[np.int64],
    ) -> None:
        """Write each robot's next action."""
        steer(
            minds.own, knowledge.ear, knowledge.grids.price, contact, self.stations_m,
            self.table.state, self.table.cells, self._headings, self._grid, action,
        )  # fmt: skip

    def costs_from(
        self,
        grids: OccupancyGrids,
        m: int,
        start: int,
        targets: NDArray[np.int64],
        at_most: int | None = None,
    ) -> NDArray[np.float64]:
        """Costs of the best routes over map m from one cell to many.

        Args:
            grids: the maps.
            m: which one.
            start: flat cell; it may be occupied, for a robot can always leave its place.
            targets: int64[n], flat cells.
            at_most: stop after so many of the nearest targets.

        Returns:
            float64[n]: costs in metres of free way, inf for a target without a route (or not
            among the nearest `at_most` and those at equal cost).
        """
        found = np.empty(len(targets), dtype=np.int64)
        search = self._search
        route_cost_field(
            grids.price[m], grids.bounds[m], search.toll, search.nodes, search.buckets,
            search.state, start, targets, len(targets) if at_most is None else at_most, found,
        )  # fmt: skip
        if at_most is not None and at_most < len(targets):
            # The last bucket holds dearer ones too.
            reached = np.where(found < 0, np.iinfo(np.int64).max, found)
            found[reached > np.partition(reached, at_most - 1)[at_most - 1]] = -1
        return np.where(found < 0, np.inf, self.costs.in_metres(found))


def dock_cells(frame: GridFrame, stations_m: NDArray[np.float64]) -> NDArray[np.int64]:
    """The cells that a robot heads for to charge: a station's own, and those round it.

    Several, since a station's own cell may be partly wall, or taken.

    Args:
        frame: the grid.
        stations_m: float64[k, 2] in metres.

    Returns:
        int64[n], flat cells whose centres lie within 1.5 cells of a station, ascending.
    """
    found = set()
    for x_m, y_m in stations_m:
        row, col = frame.cell_of(float(x_m), float(y_m))
        for near_row in range(row - 2, row + 3):
            for near_col in range(col - 2, col + 3):
                if not frame.contains(near_row, near_col):
                    continue
                x, y = frame.centre_of(near_row, near_col)
                if (x - x_m) ** 2 + (y - y_m) ** 2 <= (1.5 * frame.cell_m) ** 2:
                    found.add(frame.flat(near_row, near_col))
    return np.array(sorted(found), dtype=np.int64)
