"""What moving costs in a scenario, and where only robots that charge drive at the usual cost."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from swarmscout.mapping.footprint import STATION_ZONE
from swarmscout.mapping.occupancy import OccupancyGrids
from swarmscout.mission.scenario import Scenario
from swarmscout.planning.costs import RouteCosts
from swarmscout.planning.places import station_zone

__all__ = ["keep_stations_clear", "make_costs"]

UNPROVEN = 3000
"""On the way home a metre of ground that is not known to be free costs as much as three more."""

STATION = 3000
"""Robots that do not charge keep clear of those that do, as of robots that stand."""

FAR_TILES = 8
"""Routes over more tiles than this are planned in parts: at cells of 0.25 m from 64 m on."""

BESIDE = 1000
"""In 1/1000: a way along walls costs as much as one that is twice as long in the open."""


def make_costs(scenario: Scenario, cell_m: float, least: int, *, goes_home: bool) -> RouteCosts:
    """What a move of a route costs.

    Args:
        scenario: what is run.
        cell_m: edge of a map cell.
        least: the lowest price of a cell, in 1/1000.
        goes_home: whether robots return in time for the way home.
    """
    cell_mm = 1000.0 * cell_m
    # The paper's literal rule knows occupancy and nothing else.
    by_length = scenario.routes.cost == "length"
    return RouteCosts(
        straight=round(cell_mm),
        diagonal=round(cell_mm * math.sqrt(2.0)),
        base=1000 if by_length else 0,
        least=least,
        beside=BESIDE if by_length else 0,
        station=STATION if by_length else 0,
        unproven=UNPROVEN if goes_home else 0,
        proven=round(1000.0 * scenario.map.free_below),
        far_tiles=FAR_TILES if scenario.routes.far == "parts" else 0,
    )


def keep_stations_clear(
    grids: OccupancyGrids, scenario: Scenario, stations_m: NDArray[np.float64]
) -> None:
    """Mark on blank maps the cells in which robots charge.

    Args:
        grids: written.
        scenario: what is run.
        stations_m: float64[k, 2].
    """
    if scenario.battery.enabled:
        zone = station_zone(grids.frame, stations_m, scenario.battery.station_range_m)
        grids.status[:, zone] |= STATION_ZONE
