"""The step: the order of phases, and nothing else."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from time import perf_counter
from typing import Any

import numpy as np
from numpy.typing import NDArray

from swarmscout.comms.beacons import exchange_beacons
from swarmscout.core.enums import CHARGE
from swarmscout.core.errors import ScenarioError
from swarmscout.core.language_model import Model
from swarmscout.core.recorder import Decision, Recorder, StepRecord
from swarmscout.core.version import package_version
from swarmscout.destinations.selector import Selector
from swarmscout.mapping.evidence import EvidenceLog, observe
from swarmscout.mapping.exchange import exchange_evidence, share_evidence
from swarmscout.mapping.occupancy import BeliefView, OccupancyGrids
from swarmscout.minds.minds import DESIRED, blank_minds
from swarmscout.minds.modes import choose_modes
from swarmscout.mission import build
from swarmscout.mission.metrics import Judge, map_truth
from swarmscout.mission.scenario import Scenario
from swarmscout.mission.sensing import Senses
from swarmscout.mission.validation import HandCheck, checked_function, checked_links
from swarmscout.robots.battery import spend_or_charge
from swarmscout.robots.bodies import heading_table, to_ticks
from swarmscout.robots.motion import Neighbourhood, carry_out
from swarmscout.teams.formation import Tally, reorganize
from swarmscout.teams.policy import DesiredSizePolicy
from swarmscout.worlds.catalogue import load_world
from swarmscout.worlds.placement import place_stations
from swarmscout.worlds.world import World

__all__ = ["RULES_VERSION", "Mission"]

RULES_VERSION = 1
"""Goes up when behaviour changes on purpose, so that old results are not compared with new ones."""

Links = Callable[[int], NDArray[np.bool_]]


class Mission:
    """A swarm of robots that explores an unknown world, step by step.

    Args:
        scenario: what is run.
        seed: overrides the scenario's.
        world: overrides the scenario's; a world that was loaded or made before.
        recorder: keeps what happens; without one nothing is written.
        links: who hears whom: a step to bool[N, N]. Then each robot keeps a map of its own. By
            default everybody hears everybody, and one map serves all (paper, "Robot model").
        base: folder for relative paths of the scenario, besides the working directory.
        selector: overrides the scenario's ``destinations``; an object with a method ``choose``.
        policy: overrides the scenario's ``teams.policy``; an object with a method ``desired``.
        model: answers a selector that asks a language model; None: what the scenario's section
            ``llm`` and the environment name.

    Attributes:
        scenario, world: what is run, and where; they do not change.
        bodies: the truth about the robots (:class:`~swarmscout.robots.bodies.Bodies`).
        minds: what robots believe, row i of robot i (:class:`~swarmscout.minds.minds.Minds`).
        map, map_of: what the swarm knows together, and what one robot knows.
        own_maps: whether each robot keeps a map of its own (`links` were given).
        by_hand: which arguments were given that no scenario can name: ``links``, ``model``.
        stations_m: float64[k, 2], charging stations.
        step_number: steps made so far. explored_m2: area explored so far.
        done, end_reason: whether the mission is over, and why (None until then).

    Raises:
        SwarmscoutError: the scenario, its world, its rules or its model cannot be used.

    Example:
        >>> mission = Mission(Scenario(world="lava-tube", robots=15, steps=20))
        >>> mission.step()
        >>> mission.step_number
        1
    """

    def __init__(
        self,
        scenario: Scenario,
        *,
        seed: int | None = None,
        world: World | None = None,
        recorder: Recorder | None = None,
        links: Links | None = None,
        base: Path | None = None,
        selector: Selector | None = None,
        policy: DesiredSizePolicy | None = None,
        model: Model | None = None,
    ) -> None:
        scenario = build.complete(scenario, seed, selector, policy)
        if world is None:
            world = load_world(scenario.world, seed=scenario.world_seed, base=base)
        world = load_world(world)  # Of any other kind of argument it says what is wrong.
        self.scenario = scenario
        self.world = world
        self.base = base
        self.destinations = build.make_destinations(scenario, base, selector)
        self.asker = build.make_asker(scenario, self.destinations.selector, model)
        self.destinations.ask = self.asker
        self.sizes = build.make_desired_sizes(scenario, base, policy)
        # What the world is for these bodies: they do not drive where it is too steep.
        self._ground = ground = build.make_ground(world, scenario)
        self.stations_m = place_stations(ground, scenario.robots)
        self.frame = build.make_frame(world, scenario)
        self.bodies = build.make_bodies(ground, scenario)

        robots = scenario.robots
        shared = links is None
        self.own_maps = not shared
        self.headings = heading_table()
        mesh = build.make_mesh(world, scenario)
        self.senses = Senses(scenario, ground, self.headings, mesh)
        self.minds = blank_minds(robots, shared=shared)
        self.minds.state[:, DESIRED] = scenario.teams.desired_size
        evidence_model = build.make_model(scenario)
        neighbours = scenario.map.frontier_neighbours
        self.grids = OccupancyGrids(self.frame, 1 if shared else robots, evidence_model, neighbours)
        # What the swarm as a whole knows: the shared map, or all logs together, for judging.
        self.swarm = (
            self.grids if shared else OccupancyGrids(self.frame, 1, evidence_model, neighbours)
        )
        sensor, body = scenario.sensor, scenario.body
        reach_m = max(sensor.range_m, body.radius_m + body.forward_m + world.resolution_m) + 0.5
        self.log = EvidenceLog(robots, sensor.rays, reach_m, self.frame.cell_m, keep=not shared)
        self.known = np.zeros((robots, robots) if not shared else (1, 1), dtype=np.int64)
        self.planner = build.make_planner(
            scenario,
            self.frame,
            1 if shared else robots,
            evidence_model,
            self.stations_m,
            self.headings,
        )
        self.judge = Judge(
            map_truth(ground, self.frame, scenario.body.radius_m), robots, scenario.body.forward_m
        )
        self.step_number = 0
        self.end_reason: str | None = None
        self.action = np.zeros(robots, dtype=np.int64)
        self.events = np.zeros((8 * robots + 16, 4), dtype=np.int64)
        self._count = np.zeros(1, dtype=np.int64)
        self._hand_check = HandCheck(ground, self.frame.size)
        self._links = checked_function(links)
        given = {"links": links, "model": model}
        self.by_hand = tuple(name for name, value in given.items() if value is not None)
        self._no_links = np.zeros((1, 1), dtype=np.bool_)
        self._tally = Tally(robots)
        self._near = Neighbourhood(world.extent, robots, body.radius_m, body.forward_m)
        self._turn_ticks = to_ticks(body.turn_deg)
        teams = scenario.teams
        self._team_rules = teams.d_join_m, teams.silence_steps, teams.leave_rule
        self._return_reserve = build.return_reserve(scenario)
        self.decisions: list[Decision] = []
        self._recorder = recorder
        if recorder is not None:
            recorder.begin(self)
            nothing = np.zeros(0, dtype=np.int64)
            recorder.record(self._record([], nothing, nothing, {"step": 0.0, "decide": 0.0}))

    def __repr__(self) -> str:
        scenario, state = self.scenario, f"over: {self.end_reason}" if self.done else "running"
        return (
            f"<Mission: {scenario.robots} robots in {self.world.name}, {self.destinations.name}, "
            f"seed {scenario.seed}, step {self.step_number} of {scenario.steps}, "
            f"{self.explored_m2:.1f} m² explored, {state}>"
        )

    def step(self) -> None:
        """One step: sense, map, exchange, charge, form teams, choose, plan, act, judge.

        Raises:
            SelectorError: the selector failed.
            PolicyError: the policy failed.
            ScenarioError: the mission is over, or something impossible was written into it.
        """
        if self.done:
            raise ScenarioError(f"the mission is over: {self.end_reason}")
        started = perf_counter()
        self._hand_check.before(self.bodies, self.minds)
        self.step_number += 1
        self._count[0] = 0
        step, minds, bodies, body = self.step_number, self.minds, self.bodies, self.scenario.body
        links, news = self._links_now(), (self.events, self._count)

        # "Robot model and environment representation": nine noisy rays, log-odds, one fused map.
        ranges = self.senses.read(bodies, minds, step)
        since, touched = self._map(ranges, links)
        exchange_beacons(minds, links, step)
        # "Task description and team behavior": limited charge, EXP and CHR.
        self._charge_and_modes()
        # "Decentralized team formation": by desired sizes, leave, join and lead.
        self.sizes.decide(minds, self.grids, step)
        reorganize(minds, self._tally, links, step, *self._team_rules, *news)
        # "Team destination determination": leaders that need one choose from their own view.
        self.decisions = self.destinations.decide(
            minds, self.grids, self.planner, links, step, *news
        )
        # "Each member then independently plans its route to the shared target and moves."
        self.planner.plan(minds, self.grids, step, *news)
        self.planner.steer(minds, self.grids, bodies.contact, self.action)
        carry_out(
            self.action, bodies, self._ground, self._near,
            body.radius_m, body.forward_m, self._turn_ticks, self.headings, step,
        )  # fmt: skip
        self._hand_check.after(bodies, minds)
        changes = self.judge.judge(
            bodies, minds, self.action, minds.sending, self.log, since, self.swarm, touched, *news
        )
        self.end_reason = self._why_over()
        if self._recorder is not None:
            seconds = {"step": perf_counter() - started, "decide": self.destinations.seconds}
            record = self._record(self.decisions, *changes, seconds)
            if self.own_maps:
                record.evidence, record.links = self.log.entries_from(since), links
            self._recorder.record(record)

    def run(self, on_step: Callable[[Mission], None] | None = None) -> dict[str, Any]:
        """Run what is left of the mission.

        Args:
            on_step: called after each step, for example to show progress.

        Returns:
            The summary, see docs/recordings.md.
        """
        while not self.done:
            self.step()
            if on_step is not None:
                on_step(self)
        summary = self.summary()
        if self._recorder is not None:
            self._recorder.end(summary)
        return summary

    @property
    def done(self) -> bool:
        """Whether the mission is over; ``end_reason`` says why."""
        return self.end_reason is not None

    @property
    def explored_m2(self) -> float:
        """Explored area so far, see :mod:`swarmscout.mission.metrics`."""
        return self.judge.explored_m2

    @property
    def map(self) -> BeliefView:
        """The swarm's map: what all logs of evidence together say."""
        return self.swarm.view(0)

    def map_of(self, robot: int) -> BeliefView:
        """One robot's own map (the shared one under full communication)."""
        return self.grids.view(self.minds.row(robot))

    def summary(self) -> dict[str, Any]:
        """Facts and figures of the mission so far."""
        scenario = self.scenario
        return {
            "version": package_version(),
            "rules_version": RULES_VERSION,
            "world": self.world.name,
            "start": scenario.start,
            "selector": self.destinations.name,
            "robots": scenario.robots,
            "seed": scenario.seed,
            "steps": self.step_number,
            "end_reason": self.end_reason,
            **self.judge.summary(self.minds, self.swarm),
            **self._llm_summary(),
        }

    def close(self) -> None:
        """Let go of a language model; harmless without one."""
        if self.asker is not None:
            self.asker.close()

    def _llm_summary(self) -> dict[str, Any]:
        if self.asker is None:
            return {}
        return {"llm": {**self.asker.figures(), **self.destinations.summary()}}

    def _links_now(self) -> NDArray[np.bool_]:
        if self._links is None:
            return self._no_links
        given = self._links(self.step_number)
        return checked_links(given, self.scenario.robots, self.step_number)

    def _map(
        self, ranges: NDArray[np.float64], links: NDArray[np.bool_]
    ) -> tuple[NDArray[np.int64], int]:
        """Scans become evidence, evidence flows; returns where each log's news begin, and cells."""
        self.log.make_room()
        since = self.log.length.copy()
        bodies, model = self.bodies, self.grids.model
        observe(
            self.log, self.minds.reading, self.minds.sending, ranges, self.senses.sensor.offsets,
            self.headings, self.senses.sensor.range_m, bodies.contact, bodies.contact_offset,
            self.frame, (model.free, model.occupied), model.hit_depth_m,
        )  # fmt: skip
        if self._links is not None:
            exchange_evidence(self.grids, self.log, self.known, links)
        return since, share_evidence(self.swarm, self.log, since)

    def _charge_and_modes(self) -> None:
        battery, minds, bodies = self.scenario.battery, self.minds, self.bodies
        if battery.enabled:
            spend_or_charge(
                bodies.position, bodies.charge, bodies.alive, minds.mode == CHARGE, self.stations_m,
                float(battery.capacity_steps), battery.charge_per_step, battery.station_range_m,
                self.events, self._count,
            )  # fmt: skip
        minds.reading[:, 3] = bodies.charge / battery.capacity_steps
        minds.sending[:] = bodies.alive
        choose_modes(
            minds.state, minds.reading, minds.sending, self.stations_m,
            battery.charge_below if battery.enabled else -1.0, *self._return_reserve,
            self.events, self._count,
        )  # fmt: skip

    def _why_over(self) -> str | None:
        if self.judge.moving == 0:
            return "no robot able to move"
        if self.judge.explored_m2 >= self.judge.reachable_m2 - 1e-9:
            return "everything reachable explored"
        # Before the first cell is known to be free there is no frontier either.
        if self.swarm.frontier_count(0) == 0 and self.judge.explored_m2 > 0.0:
            return "no frontier left"
        if self.step_number >= self.scenario.steps:
            return "steps used up"
        return None

    def _record(
        self,
        decisions: list[Decision],
        cells: NDArray[np.int64],
        log_odds: NDArray[np.int64],
        seconds: dict[str, float],
    ) -> StepRecord:
        return StepRecord(
            step=self.step_number,
            bodies=self.bodies,
            minds=self.minds,
            capacity_steps=self.scenario.battery.capacity_steps,
            action=self.action,
            events=self.events[: self._count[0]],
            map_cells=cells,
            map_log_odds=log_odds,
            decisions=decisions,
            coverage=self.judge.coverage(self.swarm),
            seconds=seconds,
        )
