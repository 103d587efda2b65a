"""A scenario made into objects: world, bodies, maps, routes, and the rules that move them."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from swarmscout.core.errors import ScenarioError, WorldError
from swarmscout.core.grid import GridFrame
from swarmscout.core.language_model import Model
from swarmscout.core.registry import IN_MEMORY, rule_name
from swarmscout.core.scan import Scan
from swarmscout.core.streams import stream
from swarmscout.destinations.asking import AskingSelector
from swarmscout.destinations.selection import Destinations, Setting
from swarmscout.destinations.selector import Selector
from swarmscout.destinations.walking import CELL_BITS
from swarmscout.llm.settings import EMBEDDED_PROMPT_TOKENS
from swarmscout.mapping.evidence import EvidenceLog
from swarmscout.mapping.footprint import Footprint
from swarmscout.mapping.log_odds import InverseSensorModel, log_odds_of
from swarmscout.mapping.occupancy import OccupancyGrids
from swarmscout.mapping.scan_evidence import inverse_model, rays_per_beam
from swarmscout.mission.charging import make_charging
from swarmscout.mission.metrics import Judge, map_truth
from swarmscout.mission.plug_ins import POLICY, RADIO, SELECTOR, SENSOR, TASK
from swarmscout.mission.route_costs import make_costs
from swarmscout.mission.scenario import Scenario
from swarmscout.planning.routes import Planner, Vehicle
from swarmscout.robots.battery import CHARGER
from swarmscout.robots.bodies import TICKS, Bodies, heading_table, place_bodies, to_ticks
from swarmscout.robots.motion import Motion
from swarmscout.robots.radio.radio import Radio, ScriptedRadio
from swarmscout.robots.sensors.sensor import Sensing, Sensor
from swarmscout.tasks.checked_task import CheckedTask
from swarmscout.tasks.task import Task
from swarmscout.teams.desired_size import DesiredSizes
from swarmscout.teams.formation import TeamFormation
from swarmscout.teams.policy import DesiredSizePolicy
from swarmscout.worlds.checks import check_world
from swarmscout.worlds.ground_plane import without_steep
from swarmscout.worlds.meshes.mesh import Mesh
from swarmscout.worlds.placement import place_robots
from swarmscout.worlds.world import World

if TYPE_CHECKING:
    from swarmscout.llm.dispatcher import Dispatcher

__all__ = [
    "make_asker",
    "make_bodies",
    "make_charger",
    "make_desired_sizes",
    "make_destinations",
    "make_formation",
    "make_frame",
    "make_grids",
    "make_ground",
    "make_judge",
    "make_log",
    "make_mesh",
    "make_model",
    "make_motion",
    "make_planner",
    "make_radio",
    "make_rule",
    "make_sensing",
    "make_task",
]


def make_frame(world: World, scenario: Scenario) -> GridFrame:
    """The occupancy grid's frame: the world's bounding box, with a cell to spare on each side.

    Raises:
        ScenarioError: the grid would have too many cells.
    """
    frame = GridFrame.covering(world.extent, scenario.map.cell_m)
    if frame.size >= 1 << CELL_BITS:
        raise ScenarioError(
            f"key 'map.cell_m' = {scenario.map.cell_m:g}: world '{world.name}' would have "
            f"{frame.size:,} map cells, at most {(1 << CELL_BITS) - 1:,} are possible; "
            "take larger cells"
        )
    return frame


def make_model(scenario: Scenario) -> InverseSensorModel:
    """The inverse sensor model, in log-odds."""
    m = scenario.map
    return InverseSensorModel(
        free=log_odds_of(m.p_free),
        occupied=log_odds_of(m.p_occupied),
        lowest=log_odds_of(m.p_min),
        highest=log_odds_of(m.p_max),
        free_below=log_odds_of(m.free_below),
        occupied_above=log_odds_of(m.occupied_above),
        hit_depth_m=m.hit_depth_m,
    )


def make_bodies(world: World, scenario: Scenario) -> Bodies:
    """Robots at their starts, with random headings and charges.

    Raises:
        WorldError: the world has no room for so many robots.
    """
    robots, seed = scenario.robots, scenario.seed
    position = place_robots(
        world, robots, scenario.start, stream(seed, "start"), scenario.body.radius_m
    )
    heading = stream(seed, "heading").integers(0, TICKS, robots)
    battery = scenario.battery
    share = stream(seed, "charge").uniform(battery.start_min, battery.start_max, robots)
    # A mission's first step spends one step's charge: nobody starts with less.
    charge = np.maximum(share * battery.capacity_steps, min(2.0, battery.capacity_steps))
    return place_bodies(position, heading, charge, seed=seed, radius_m=scenario.body.radius_m)


def make_ground(world: World, scenario: Scenario) -> World:
    """The world without what is too steep for the scenario's bodies, checked.

    Raises:
        WorldError: a mission cannot start in it.
    """
    steepest = scenario.body.slope_deg
    try:
        ground = without_steep(world, steepest, scenario.body.radius_m)
        check_world(ground, scenario.robots)
    except WorldError as error:
        check_world(world, scenario.robots)
        why = f"without ground steeper than key 'body.slope_deg' = {steepest:g}"
        raise WorldError(f"{error} ({why})") from None
    return ground


def make_mesh(world: World, scenario: Scenario) -> Mesh | None:
    """The cave's surface that rays meet; None for sensing against the raster.

    A generated tube that came without its mesh gets it made.

    Raises:
        ScenarioError: the world has no mesh.
        WorldError: the mesh cannot be made, as the extra ``mesh`` is not installed.
    """
    if scenario.sensor.sensing != "mesh":
        return None
    # Few missions need it, and it imports much.
    from swarmscout.worlds.meshes.tube_mesh import generated_mesh

    mesh = world.mesh or generated_mesh(world)
    if mesh is None:
        raise ScenarioError(
            f"key 'sensor.sensing' = 'mesh': world '{world.name}' has no mesh: import one with "
            "`swarmscout worlds import CAVE.ply`, or take a generated tube"
        )
    return mesh


def make_sensing(
    scenario: Scenario,
    base: Path | None,
    sensor: Sensor | None,
    bodies: Bodies,
    world: World,
    ground: World,
) -> Sensing:
    """The range sensor, asked once.

    Args:
        scenario: which sensor. base: folder for its file. sensor: the sensor itself, if at hand.
        bodies: the mission's robots.
        world: the mission's world. ground: the same for these bodies, see :func:`make_ground`.

    Raises:
        SensorError: there is no such sensor, it does not take the scenario's parameters, or it
            failed.
        ScenarioError: it needs a mesh, and the world has none.
        WorldError: the mesh cannot be made.
    """
    mesh = make_mesh(world, scenario)
    seen = ground if mesh is None or ground.mesh is mesh else replace(ground, mesh=mesh)
    if sensor is None:
        sensor = SENSOR.make(scenario, base)
    name = rule_name(SENSOR.name(scenario)).removeprefix(IN_MEMORY)
    return Sensing(sensor, name, bodies, seen)


def make_planner(
    scenario: Scenario,
    frame: GridFrame,
    stations_m: NDArray[np.float64],
) -> Planner:
    """Plans and follows routes."""
    charging = make_charging(scenario)
    least = int(make_model(scenario).permille()[0])
    costs = make_costs(scenario, frame.cell_m, least, goes_home=charging.share_per_m > 0.0)
    dock_m = max(0.5 * scenario.battery.station_range_m, scenario.battery.station_range_m - 0.1)
    body = scenario.body
    vehicle = Vehicle(
        body.radius_m, body.forward_m, to_ticks(body.turn_deg), dock_m, heading_table()
    )
    return Planner(frame, scenario.robots, costs, stations_m, vehicle, charging)


def make_destinations(
    scenario: Scenario,
    frame: GridFrame,
    base: Path | None,
    selector: Selector | None = None,
    task: CheckedTask | None = None,
    range_m: float = math.inf,
    stop_m: float = 0.0,
) -> Destinations:
    """The rule that chooses destinations, and when it is asked.

    Args:
        scenario: which rule. frame: the occupancy grids'. base: folder for its file.
        selector: the rule itself, if at hand.
        task: says what is worth heading for; by default the scenario's.
        range_m: of the robots' sensors. stop_m: a robot's route ends this near to its goal.

    Raises:
        SelectorError: there is no such selector, or it does not take the scenario's parameters.
    """
    rule = _fitting(selector, scenario) if selector else make_rule(scenario, base)
    setting = Setting(
        scenario.seed,
        scenario.robots,
        frame,
        heading_table(),
        scenario.body.forward_m,
        scenario.llm.latency_steps,
        scenario.teams.position == "center",
        scenario.teams.silence_steps,
        range_m,
        stop_m,
    )
    task = task or make_task(scenario, base)
    name = rule_name(SELECTOR.name(scenario))
    return Destinations(rule, name, scenario.renewal, scenario.teams, setting, task)


def make_task(scenario: Scenario, base: Path | None, task: Task | None = None) -> CheckedTask:
    """The task.

    Args:
        scenario: which task. base: folder for its file. task: the task itself, if at hand.

    Raises:
        TaskError: there is no such task, or it does not take the scenario's parameters.
    """
    rule = task or TASK.make(scenario, base)
    return CheckedTask(rule, rule_name(TASK.name(scenario)).removeprefix(IN_MEMORY))


def make_rule(scenario: Scenario, base: Path | None) -> Selector:
    """The selector that a scenario names, its prompts short enough for the model that is asked.

    Raises:
        SelectorError: there is no such selector, or it does not take the scenario's parameters.
    """
    return _fitting(SELECTOR.make(scenario, base), scenario)


def make_radio(
    scenario: Scenario,
    base: Path | None,
    radio: Radio | None = None,
    links: Callable[[int], Any] | None = None,
) -> Radio:
    """The radio that says who hears whom.

    Args:
        scenario: which radio. base: folder for its file. radio: the radio itself, if at hand.
        links: a function of the step that says who hears whom, instead.

    Raises:
        ScenarioError: there is no such radio, or it does not take the scenario's parameters.
    """
    if links is not None:
        return ScriptedRadio(links)
    made: Radio = RADIO.make(scenario, base) if radio is None else radio
    return made


def make_formation(scenario: Scenario) -> TeamFormation:
    """Forms teams."""
    return TeamFormation(scenario.robots, scenario.teams)


def make_motion(ground: World, scenario: Scenario) -> Motion:
    """Moves bodies."""
    body = scenario.body
    return Motion(
        ground, scenario.robots, body.radius_m, body.forward_m, to_ticks(body.turn_deg),
        heading_table(),
    )  # fmt: skip


def make_log(
    scenario: Scenario, resolution_m: float, frame: GridFrame, scan: Scan
) -> tuple[EvidenceLog, NDArray[Any]]:
    """Blank logs of evidence, and the inverse sensor model that fills them.

    Args:
        scenario: which bodies. resolution_m: of the world's raster. frame: the occupancy grids'.
        scan: any scan of the sensor.
    """
    body = scenario.body
    reach_m = max(scan.max_range_m, body.radius_m + body.forward_m + resolution_m) + 0.5
    rays = len(scan.directions) * rays_per_beam(scan, frame.cell_m)[0]
    log = EvidenceLog(scenario.robots, rays, reach_m, frame.cell_m)
    return log, inverse_model(scan, make_model(scenario), frame, heading_table(), log.reach)


def make_grids(scenario: Scenario, frame: GridFrame) -> OccupancyGrids:
    """One blank occupancy grid."""
    body, model = scenario.body, make_model(scenario)
    # The paper's literal rule knows occupancy and nothing else.
    clear = scenario.routes.cost == "length"
    footprint = Footprint.of_disc(body.radius_m, frame.cell_m, model.hit_depth_m, keeps_clear=clear)
    return OccupancyGrids(frame, 1, model, scenario.map.frontier_neighbours, footprint)


def make_judge(ground: World, scenario: Scenario, frame: GridFrame, bodies: Bodies) -> Judge:
    """Judges what the mission achieves."""
    body, model = scenario.body, make_model(scenario)
    truth = map_truth(ground, frame, body.radius_m)
    return Judge(truth, bodies, body.forward_m, (model.lowest, model.highest))


def make_charger(scenario: Scenario) -> NDArray[np.void]:
    """CHARGER[1], see ``robots.battery``."""
    battery = scenario.battery
    values = battery.capacity_steps, battery.charge_per_step, battery.station_range_m
    return np.array([values], dtype=CHARGER)


def make_desired_sizes(
    scenario: Scenario, base: Path | None, policy: DesiredSizePolicy | None = None
) -> DesiredSizes:
    """The policy that sets desired team sizes.

    Args:
        scenario: which policy. base: folder for its file. policy: the policy itself, if at hand.

    Raises:
        PolicyError: there is no such policy, or it does not take the scenario's parameters.
    """
    rule = policy or POLICY.make(scenario, base)
    teams = scenario.teams
    name = rule_name(POLICY.name(scenario))
    return DesiredSizes(rule, name, teams.desired_size, teams.silence_steps)


def make_asker(scenario: Scenario, selector: Selector, model: Model | None) -> Dispatcher | None:
    """The connection to the selector's language model; None for a selector without one.

    Raises:
        ModelError: no model is configured; the message says what to set.
    """
    if not isinstance(selector, AskingSelector):
        return None
    # Most missions ask no model, and the network code is slow to import.
    from swarmscout.llm.connect import connect

    return connect(scenario.llm, model=model)


def _fitting(selector: Selector, scenario: Scenario) -> Selector:
    """The selector, its prompts short enough for the embedded model if that is asked."""
    if scenario.llm.provider != "embedded" or not isinstance(selector, AskingSelector):
        return selector
    if selector.prompt_tokens <= EMBEDDED_PROMPT_TOKENS:
        return selector
    shorter: Selector = replace(selector, prompt_tokens=EMBEDDED_PROMPT_TOKENS)  # type: ignore[type-var]
    return shorter
