"""A recorded run as the player's data: a packet with its facts, and one with all its steps."""

from __future__ import annotations

import contextlib
import gzip
import json
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from swarmscout.core.enums import ACTIONS, CAUSES, EVENTS, MODES
from swarmscout.core.errors import RunError
from swarmscout.core.grid import GridFrame
from swarmscout.mapping.log_odds import log_odds_of
from swarmscout.mission.scenario import Scenario
from swarmscout.recording.tables import CONTACTS
from swarmscout.robots.sensors.parameters import (
    ConeParameters,
    OwnParameters,
    sensor_parameters,
)
from swarmscout.robots.sensors.ray_sensor import RaySensor
from swarmscout.robots.sensors.registry import SENSORS
from swarmscout.viewing.player.packets import differences, pack
from swarmscout.viewing.player.page_text import page_data, page_text
from swarmscout.viewing.player.questions import questions_of
from swarmscout.viewing.player.step_range import StepRange, pack_steps, robot_columns, whole_numbers
from swarmscout.viewing.relief import Relief, relief_of
from swarmscout.worlds.world import World

if TYPE_CHECKING:
    import polars as pl

    from swarmscout.recording.run import Run

__all__ = ["mission_packet", "player_data", "steps_of"]


def player_data(run: Run) -> bytes:
    """All that the page shows of a run, gzipped.

    Args:
        run: finished or not; recorded with ``full``, or with ``curves``, which has no robots.

    Raises:
        RunError: steps were not recorded, or the world cannot be loaded.
    """
    facts = {
        "finished": run.finished,
        "summary": run.summary,
        "version": run.facts["version"],
        "own_maps": run.own_maps,
    }
    if "steps" not in run.tables:  # Curves, decisions and the final map, but no robots.
        facts |= {"robots": 0, "own_maps": False}
    name = "run" if run.path is None else run.path.resolve().name
    packet = mission_packet(name, run.scenario, run.world(), run.frame, run.stations_m, facts)
    return gzip.compress(packet + pack_steps(steps_of(run)), compresslevel=6, mtime=0)


def mission_packet(
    name: str,
    scenario: Scenario,
    world: World,
    frame: GridFrame,
    stations_m: NDArray[np.float64],
    facts: Mapping[str, Any],
) -> bytes:
    """The packet with the facts that do not change during a mission.

    Args:
        name: of the run.
        scenario: of the mission.
        world: of the mission.
        frame: the map's frame.
        stations_m: float64[k, 2], charging stations.
        facts: further facts for the page, plain data.
    """
    relief = relief_of(world)
    arrays: dict[str, NDArray[Any]] = dict(_relief_arrays(relief))
    arrays["free"] = np.packbits((world.free != 0).ravel())
    return pack(
        {
            "name": page_text(name),
            "world": page_text(world.name),
            "selector": page_text(scenario.destinations),
            "seed": scenario.seed,
            "robots": scenario.robots,
            "planned_steps": scenario.steps,
            "frame": _plain_frame(frame),
            "stations_m": stations_m.tolist(),
            "station_range_m": scenario.battery.station_range_m,
            "radius_m": scenario.body.radius_m,
            "sensor": _rays(scenario),
            "free_below": log_odds_of(scenario.map.free_below),
            "occupied_above": log_odds_of(scenario.map.occupied_above),
            "frontier_neighbours": scenario.map.frontier_neighbours,
            "route_cost": scenario.routes.cost,
            "charge_below": scenario.battery.charge_below,
            "relief": {**_plain_frame(relief.frame), "wall_m": relief.wall_m},
            "raster": _plain_frame(world.frame),
            "words": {
                "mode": MODES,
                "action": ACTIONS,
                "contact": CONTACTS,
                "event": EVENTS,
                "cause": CAUSES,
            },
            **page_data(facts),
        },
        arrays,
    )


def steps_of(run: Run) -> StepRange:
    """All steps of a run.

    Raises:
        RunError: no step was recorded.
    """
    if "steps" not in run.tables:
        return _without_robots(run)
    steps, robots = run.steps, run.scenario.robots
    count = steps.height // robots
    if not count:
        raise RunError(f"{run!r} has no step yet: nothing to show")

    def column(name: str) -> NDArray[Any]:
        series = steps[name]
        values = series.to_physical() if series.dtype == _enum() else series
        return values.to_numpy().reshape(count, robots)

    changes, events, coverage = run.map_changes, run.events, run.coverage
    kinds = events["kind"].to_physical().to_numpy()
    rest = [events[name].to_numpy() for name in ("robot", "other", "value")]
    return StepRange(
        first=int(steps["step"][0]),
        columns={c.name: whole_numbers(c, column(c.name)) for c in robot_columns()},
        map_counts=np.bincount(changes["step"].to_numpy(), minlength=count),
        map_cells=changes["cell"].to_numpy(),
        map_log_odds=changes["log_odds"].to_numpy(),
        events=np.column_stack([events["step"].to_numpy(), kinds, *rest]).astype(np.int64),
        decisions=_decisions(run),
        coverage=_coverage(coverage),
    )


def _without_robots(run: Run) -> StepRange:
    """A run of which curves were recorded: its whole map appears in the last step."""
    coverage, last = run.coverage, run.last_step
    if last < 0:
        raise RunError(f"{run!r} holds no step yet: there is nothing to show")
    odds = run.map_at().ravel() if run.finished else np.zeros(run.frame.size, dtype=np.int32)
    cells = np.flatnonzero(odds)
    nothing = np.zeros((last + 1, 0), dtype=np.int64)
    return StepRange(
        first=0,
        columns={column.name: nothing for column in robot_columns()},
        map_counts=np.array([0] * last + [len(cells)]),
        map_cells=cells,
        map_log_odds=odds[cells],
        events=np.zeros((0, 5), dtype=np.int64),
        decisions=_decisions(run),
        coverage=_coverage(coverage),
    )


def _coverage(coverage: pl.DataFrame) -> dict[str, NDArray[np.float64]]:
    names = [name for name in coverage.columns if name != "step"]
    return {name: coverage[name].to_numpy().astype(np.float64) for name in names}


def _decisions(run: Run) -> list[dict[str, Any]]:
    """Rows of ``decisions``, with the requests to a language model for them."""
    rows = [_with_details(row) for row in run.decisions.to_dicts()]
    asked = questions_of(run)
    for row in rows:
        attempts = asked.get((row["step"], row["team"], row["leader"]))
        if attempts:
            row["attempts"] = attempts
    return rows


def _with_details(row: dict[str, Any]) -> dict[str, Any]:
    """A row of ``decisions`` whose details are data again."""
    with contextlib.suppress(TypeError, ValueError):  # Otherwise it is shown as text.
        row["details"] = json.loads(row["details"])
    return row


def _enum() -> Any:
    import polars as pl

    return pl.Enum


def _plain_frame(frame: GridFrame) -> dict[str, float]:
    return {
        "x_m": frame.origin_x_m,
        "y_m": frame.origin_y_m,
        "cell_m": frame.cell_m,
        "rows": frame.rows,
        "columns": frame.columns,
    }


def _relief_arrays(relief: Relief) -> dict[str, NDArray[Any]]:
    """Heights in millimetres as differences along a row, shares in 255ths, 0 outside."""
    height = np.rint(np.where(relief.shown, relief.ground_m, 0.0) * 1000.0).astype(np.int64)
    share = np.where(relief.shown, 1 + np.rint(relief.open_share * 254.0), 0).astype(np.uint8)
    return {
        "relief.ground": differences(height).astype(np.int32),
        "relief.share": share,
    }


def _rays(scenario: Scenario) -> dict[str, Any]:
    """The sensor's rays, as the page casts them; none of a user's own sensor, which is not run."""
    sensor = scenario.sensor
    if isinstance(sensor, OwnParameters):
        return {"angles_deg": [], "range_m": 0.0, "nearest": False}
    rays = SENSORS.make(sensor.model, sensor_parameters(sensor))
    assert isinstance(rays, RaySensor)
    return {
        "angles_deg": rays.angles_deg(),
        "range_m": sensor.range_m,
        "nearest": isinstance(sensor, ConeParameters),
    }
