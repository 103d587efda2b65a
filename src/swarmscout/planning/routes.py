"""Phase 7 of a step: routes, each robot for itself, to the shared destination or a station."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from swarmscout.comms.knowledge import Knowledge
from swarmscout.core.events import EVENT, EventLog
from swarmscout.core.grid import GridFrame
from swarmscout.mapping.occupancy import OccupancyGrids
from swarmscout.minds.minds import Minds
from swarmscout.planning.costs import RouteCosts
from swarmscout.planning.docking import (
    ChargingRules,
    choose_places,
    docking_rules,
    take_stations,
    weigh_stations,
)
from swarmscout.planning.following import DRIVING, find_needs, steer
from swarmscout.planning.neighbours import RIGHTS
from swarmscout.planning.places import dock_cells, lay_places
from swarmscout.planning.reachability import find_connected
from swarmscout.planning.right_of_way import keep_clear
from swarmscout.planning.route_table import STATION, RouteTable, blank_routes
from swarmscout.planning.search import plan_routes, route_cost_field
from swarmscout.planning.search_memory import Search
from swarmscout.planning.tolls import mark_robots
from swarmscout.planning.way_home import LOOK_EVERY, ask_ways, take_nearest, take_ways

__all__ = ["Planner", "Vehicle"]

PROGRESS_M = 0.5
"""A robot has made progress once this much less of its route is left."""

ASIDE_TICKS = 400
"""Headings that robots compare to keep clear of others lie about so far apart."""

SIDE_ROOM_M = 0.05
"""A straight way has to be wider than the robot by this on each side."""

STRIDE_M = 0.5
"""Cells of a route that a robot may head for are about so far apart."""


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
        charging: batteries and stations.

    Args:
        frame: the occupancy grids'.
        robots: N.
        costs: what moving costs.
        stations_m: float64[k, 2].
        vehicle: the robots' body.
        charging: batteries and stations.
    """

    def __init__(
        self,
        frame: GridFrame,
        robots: int,
        costs: RouteCosts,
        stations_m: NDArray[np.float64],
        vehicle: Vehicle,
        charging: ChargingRules | None = None,
    ) -> None:
        self.frame = frame
        self.costs = costs
        self.stations_m = stations_m
        self.table: RouteTable = blank_routes(robots)
        self._search = Search(frame, replace(costs, unproven=0))
        self._home_search = Search(frame, replace(costs, station=0), self._search)
        self._home = blank_routes(robots, longest=1)
        self._grids: OccupancyGrids | None = None
        self._marks = np.full((1, robots), -1, dtype=np.int64)
        self._docks = dock_cells(frame, stations_m)
        self._queues = np.zeros((1, max(1, len(stations_m))), dtype=np.int64)
        self.charging = charging = charging or ChargingRules()
        self._rules = docking_rules(frame, charging, vehicle.radius_m, vehicle.forward_m)
        self._headings = vehicle.headings
        turn_ticks = vehicle.turn_ticks
        # At most 30°, if turns are not too coarse for that.
        most_off = max(turn_ticks // 2, min(3 * turn_ticks // 4, len(vehicle.headings) // 12))
        # Driving while off by up to that, a robot gets nearer to a waypoint only while that is
        # farther than forward / (2 cos(off)); nearer, it would circle it.
        cosine = max(0.5, float(vehicle.headings[most_off, 0]))
        self._grid = np.zeros(1, dtype=DRIVING)
        grid = self._grid[0]
        frame.write_into(grid)
        grid["radius_m"], grid["forward_m"] = vehicle.radius_m, vehicle.forward_m
        grid["still_m"] = max(2.0 * vehicle.radius_m, 1.5 * vehicle.forward_m)
        grid["progress_cells"] = max(1, round(PROGRESS_M / frame.cell_m))
        grid["waypoint_m"] = max(0.5 * frame.cell_m, 1.05 * vehicle.forward_m / (2.0 * cosine))
        grid["half_width_m"] = vehicle.radius_m + SIDE_ROOM_M
        grid["stride"] = max(1, round(STRIDE_M / frame.cell_m))
        grid["most_off"] = most_off
        grid["turn_ticks"] = turn_ticks
        grid["ahead_m"] = vehicle.forward_m + vehicle.radius_m
        grid["dock_m"] = vehicle.dock_m
        self._rights = _rights(frame, vehicle)
        buckets = int(self._rights[0]["bucket_rows"] * self._rights[0]["bucket_columns"])
        self._chain = np.full(buckets, -1, dtype=np.int64)
        # A robot stops within a waypoint's reach of its place, and is to charge there.
        within_m = max(frame.cell_m, charging.range_m - grid["waypoint_m"] - 0.05)
        self._places = lay_places(frame, stations_m, within_m, float(self._rules[0]["apart_m"]))

    @property
    def stop_m(self) -> float:
        """A route is driven to its end once a robot is this near to the goal."""
        return float(self._grid[0]["waypoint_m"])

    def plan(self, minds: Minds, knowledge: Knowledge, step: int, events: EventLog) -> None:
        """Give every robot that needs one a route over its own map."""
        grids, table = knowledge.grids, self.table
        choose_places(
            minds.own, knowledge.ear, knowledge.heard, knowledge.still, grids.status, table.state,
            self.stations_m, self._places, self._rules, step,
        )  # fmt: skip
        needs = find_needs(
            minds.own, knowledge.ear, grids.status, grids.counts, table.state, table.cells,
            self._grid, step,
        )  # fmt: skip
        if needs:
            self._mark_robots(knowledge, step)
        if needs and (table.state["wanted"][table.state["need"] == 1] > STATION).any():
            self._plan(self._search, knowledge, table, step, events.rows)
        if needs and (table.state["need"] == 1).any():
            self._plan(self._home_search, knowledge, table, step, events.rows)
        # In each step: whether others plan must not matter to who gives its station up.
        take_stations(minds.own, table.state, self._docks, self._queues)

    def look_home(
        self,
        minds: Minds,
        knowledge: Knowledge,
        action: NDArray[np.int64],
        contact: NDArray[np.int64],
        step: int,
    ) -> bool:
        """Robots whose charge may not suffice for the way to a station look for the best one.

        Args:
            minds: `way_m` and `station` are written.
            knowledge: what robots know.
            action, contact: int64[N], what each robot did last, and what it felt.
            step: the current step.

        Returns:
            Whether ways are up to date for all whose charge may not suffice.
        """
        home, routes = self._home, self.table.state
        asks = ask_ways(
            minds.own, knowledge.ear, action, contact, routes, home.state, self._rules, step
        )
        if asks:
            self._mark_robots(knowledge, step)
            nobody_hears = np.zeros(1, dtype=EVENT)
            self._plan(self._home_search, knowledge, home, step, nobody_hears)
            take_ways(minds.own, home.state, self.stations_m)
            take_nearest(minds.own, home.state, routes, self._docks, self._rules)
        return step % LOOK_EVERY == 0

    def _mark_robots(self, knowledge: Knowledge, step: int) -> None:
        """Bring up to date where robots are, for the searches of this step."""
        if len(self._marks) < len(knowledge.heard):
            self._marks = np.full(knowledge.still.shape, -1, dtype=np.int64)
            self._queues = np.zeros((len(knowledge.heard), self._queues.shape[1]), dtype=np.int64)
        mark_robots(knowledge.heard, knowledge.still, knowledge.rows, self._grid, step, self._marks)

    def _plan(
        self,
        search: Search,
        knowledge: Knowledge,
        table: RouteTable,
        step: int,
        events: NDArray[np.void],
    ) -> None:
        """Plan the routes that are needed, those to cells or those to stations."""
        grids = knowledge.grids
        self._use(grids)
        weigh_stations(
            knowledge.heard, table.state, grids.status, self.stations_m, self._places, self._queues,
            self._rules, step,
        )  # fmt: skip
        reach = np.array([grids.footprint.entry_cells, grids.footprint.exit_cells])
        plan_routes(
            grids.price, grids.status, grids.bounds, grids.changed, search.toll, search.nodes,
            search.buckets, search.regions, search.state, self._marks, self._docks,
            self._queues, reach, table.state, table.cells, step, events,
        )  # fmt: skip

    def _use(self, grids: OccupancyGrids) -> None:
        """Tolls of other maps than before are filled in anew."""
        if grids is not self._grids:
            self._grids = grids
            for search in (self._search, self._home_search):
                search.state["loaded"] = -1

    def steer(
        self,
        minds: Minds,
        knowledge: Knowledge,
        touch: NDArray[np.void],
        step: int,
        action: NDArray[np.int64],
    ) -> None:
        """Write each robot's next action.

        Args:
            minds: what robots believe. knowledge: what they have heard.
            touch: TOUCH[N], what stopped each robot's last move.
            step: the current step.
            action: int64[N], written.
        """
        own, status, state = minds.own, knowledge.grids.status, self.table.state
        steer(
            own, knowledge.ear, status, touch, self.stations_m, state, self.table.cells,
            self._headings, self._grid, step, action,
        )  # fmt: skip
        keep_clear(
            own, status, knowledge.heard, knowledge.listeners, knowledge.groups, state,
            self._headings, self._rights, self._chain, step, action,
        )  # fmt: skip

    def connects(
        self, grids: OccupancyGrids, m: int, start: int, cells: NDArray[np.int64]
    ) -> NDArray[np.bool_]:
        """Whether routes over map m lead from one cell to others.

        Args:
            grids: the maps. m: which one.
            start: flat cell, see :meth:`costs_from`.
            cells: int64[n], where bodies drive, see ``OccupancyGrids.entries``; -1 for none.

        Returns:
            bool[n]: whether :meth:`costs_from` finds a route.
        """
        found = np.empty(len(cells), dtype=np.bool_)
        status, frame = grids.status[m], grids.frame
        find_connected(
            status, status.view(np.uint64), grids.bounds[m], frame.rows, frame.columns,
            int(grids.exits(m, np.array([start]))[0]), cells, found,
        )  # fmt: skip
        return found

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
            targets: int64[n], flat cells; one without room stands for the nearest that has some.
            at_most: stop after so many of the nearest targets.

        Returns:
            float64[n]: costs in metres of free way, inf for a target without a route (or not
            among the nearest `at_most` and those at equal cost).
        """
        found = np.empty(len(targets), dtype=np.int64)
        search = self._search
        self._use(grids)
        out = int(grids.exits(m, np.array([start]))[0])
        route_cost_field(
            m, grids.price, grids.status, grids.bounds, grids.changed, search.toll, search.nodes,
            search.buckets, search.regions.labelled, search.state, out, grids.entries(m, targets),
            len(targets) if at_most is None else at_most, found,
        )  # fmt: skip
        # Wherever a robot is, it is there already.
        found[targets == start] = 0
        if at_most is not None and at_most < len(targets):
            # The last bucket holds dearer ones too.
            reached = np.where(found < 0, np.iinfo(np.int64).max, found)
            found[reached > np.partition(reached, at_most - 1)[at_most - 1]] = -1
        return np.where(found < 0, np.inf, self.costs.in_metres(found))


def _rights(frame: GridFrame, vehicle: Vehicle) -> NDArray[np.void]:
    """RIGHTS[1]: how robots with this body keep clear of each other."""
    rights = np.zeros(1, dtype=RIGHTS)
    rules = rights[0]
    frame.write_into(rules)
    rules["edge_m"] = edge_m = max(1.0, frame.cell_m * max(frame.rows, frame.columns) / 512)
    rules["bucket_rows"] = math.ceil(frame.rows * frame.cell_m / edge_m)
    rules["bucket_columns"] = math.ceil(frame.columns * frame.cell_m / edge_m)
    rules["radius_m"], rules["forward_m"] = vehicle.radius_m, vehicle.forward_m
    rules["turn_ticks"] = vehicle.turn_ticks
    rules["aside"] = max(1, ASIDE_TICKS // vehicle.turn_ticks)
    return rights
