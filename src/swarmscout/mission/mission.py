"""The step: the order of phases, and nothing else."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from time import perf_counter
from typing import Any

import numpy as np
from numpy.typing import NDArray

from swarmscout.comms.knowledge import Knowledge
from swarmscout.core.enums import CHARGE
from swarmscout.core.errors import ScenarioError
from swarmscout.core.events import EventLog
from swarmscout.core.language_model import Model
from swarmscout.core.links import Links
from swarmscout.core.recorder import Decision, Recorder, StepRecord
from swarmscout.core.scan import Scan
from swarmscout.core.version import package_version
from swarmscout.destinations.selector import Selector
from swarmscout.mapping.occupancy import BeliefView
from swarmscout.mapping.scan_evidence import observe
from swarmscout.minds.minds import blank_minds
from swarmscout.minds.modes import choose_modes
from swarmscout.mission import build
from swarmscout.mission.memory import check_memory, map_rows
from swarmscout.mission.plug_ins import complete
from swarmscout.mission.route_costs import keep_stations_clear
from swarmscout.mission.scenario import Scenario
from swarmscout.mission.validation import HandCheck
from swarmscout.robots.battery import spend_or_charge
from swarmscout.robots.localization import Localization
from swarmscout.robots.radio.full import Full
from swarmscout.robots.radio.radio import Radio, links_now
from swarmscout.robots.sensors.sensor import Sensor
from swarmscout.tasks.task import Task
from swarmscout.teams.policy import DesiredSizePolicy
from swarmscout.worlds.catalogue import load_world
from swarmscout.worlds.placement import place_stations
from swarmscout.worlds.world import World

__all__ = ["RULES_VERSION", "Mission"]

RULES_VERSION = 4
"""Goes up when behaviour changes on purpose, so that old results are not compared with new ones."""


class Mission:
    """A swarm of robots that explores an unknown world, step by step.

    Args:
        scenario: what is run.
        seed: overrides the scenario's.
        world: overrides the scenario's; a world that was loaded or made before.
        recorder: keeps what happens; without one nothing is written.
        links: who hears whom, instead of the scenario's radio: a step to bool[N, N].
        base: folder for relative paths of the scenario, besides the working directory.
        selector: overrides the scenario's ``destinations``; an object with a method ``choose``.
        policy: overrides the scenario's ``teams.policy``; an object with a method ``desired``.
        sensor: overrides the scenario's ``sensor``; an object with a method ``scan``.
        radio: overrides the scenario's ``radio``; an object with a method ``links``.
        task: overrides the scenario's ``task``; an object with a method ``candidates``.
        model: answers a selector that asks a language model; None: what the scenario's section
            ``llm`` and the environment name.

    Attributes:
        scenario, world: what is run, and where; they do not change.
        bodies: the truth about the robots (:class:`~swarmscout.robots.bodies.Bodies`).
        minds: what robots believe, record i of robot i (:class:`~swarmscout.minds.minds.Minds`).
        knowledge: what they have heard, and their maps
            (:class:`~swarmscout.comms.knowledge.Knowledge`).
        map, map_of: what the swarm knows together, and what one robot knows.
        own_maps: whether maps of robots can differ.
        task: what the swarm is to do (:class:`~swarmscout.tasks.checked_task.CheckedTask`).
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
        links: Callable[[int], Any] | None = None,
        base: Path | None = None,
        selector: Selector | None = None,
        policy: DesiredSizePolicy | None = None,
        sensor: Sensor | None = None,
        radio: Radio | None = None,
        task: Task | None = None,
        model: Model | None = None,
    ) -> None:
        scenario = complete(scenario, seed, selector, policy, sensor, radio, task)
        if world is None:
            world = load_world(scenario.world, seed=scenario.world_seed, base=base)
        self.world = load_world(world)  # Of any other kind of argument it says what is wrong.
        self.scenario, self.base = scenario, base
        self.frame = build.make_frame(self.world, scenario)
        rows = 1 if radio is not None or links is not None else map_rows(scenario, self.world)
        check_memory(scenario, self.world, self.frame, rows)
        # What the world is for these bodies: they do not drive where it is too steep.
        self._ground = ground = build.make_ground(self.world, scenario)
        self.stations_m = place_stations(ground, scenario.robots)
        # Bodies: the truth about robots.
        self.bodies = build.make_bodies(ground, scenario)
        self.sensing = build.make_sensing(scenario, base, sensor, self.bodies, self.world, ground)
        body = scenario.body
        self.localization = Localization(body.position_noise_m, body.heading_noise_deg)
        self.radio = build.make_radio(scenario, base, radio, links)
        self.motion = build.make_motion(ground, scenario)
        self.action = np.zeros(scenario.robots, dtype=np.int64)
        # Minds: what robots believe, have heard, and decide by.
        self.minds = blank_minds(scenario.robots)
        self.minds.own["desired"] = scenario.teams.desired_size
        self.log, self._scan_model = build.make_log(
            scenario, self.world.resolution_m, self.frame, self.sensing.last
        )
        grids = build.make_grids(scenario, self.frame)
        keep_stations_clear(grids, scenario, self.stations_m)
        self.knowledge = Knowledge(scenario.robots, grids)
        self.sizes = build.make_desired_sizes(scenario, base, policy)
        self.formation = build.make_formation(scenario)
        self.task = build.make_task(scenario, base, task)
        self.planner = build.make_planner(scenario, self.frame, self.stations_m)
        self.destinations = build.make_destinations(
            scenario, self.frame, base, selector, self.task,
            self.sensing.last.max_range_m, self.planner.stop_m,
        )  # fmt: skip
        self.asker = build.make_asker(scenario, self.destinations.selector, model)
        self.destinations.ask = self.asker
        self._charger = build.make_charger(scenario)
        # Judging. While one map serves all robots, it is the swarm's.
        self.swarm = self.knowledge.grids
        self.judge = build.make_judge(ground, scenario, self.frame, self.bodies)
        self.events = EventLog(scenario.robots)
        self.decisions: list[Decision] = []
        self.step_number = 0
        self.end_reason: str | None = None
        self._hand_check = HandCheck(
            ground, self.frame.size, len(self.stations_m), self.bodies, self.minds
        )
        given = {"links": links, "model": model}
        self.by_hand = tuple(name for name, value in given.items() if value is not None)
        self._recorder = recorder
        if recorder is not None:
            recorder.begin(self)
            nothing = np.zeros(0, dtype=np.int64)
            recorder.record(self._record((nothing, nothing), {"step": 0.0, "decide": 0.0}))

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
            SensorError: the sensor failed.
            TaskError: the task failed.
            ScenarioError: the mission is over, its radio failed, or something impossible was
                written into it.
        """
        started = perf_counter()
        self._begin()
        step, minds, bodies, events = self.step_number, self.minds, self.bodies, self.events
        knowledge, planner = self.knowledge, self.planner

        # "Robot model and environment representation": nine noisy rays, additive log-odds.
        self.localization.read(bodies, step, minds.own)
        since = self._integrate(self.sensing.scan(bodies, step))
        # "… when it encounters nearby robots, integrates the received maps with its own."
        links = links_now(self.radio, self.scenario.radio.model, step, bodies, self.world)
        self._exchange(links, since)
        # "Task description and team behavior": limited charge, EXP and CHR.
        self._charge_and_modes()
        # "Decentralized team formation": by desired sizes, leave, join and lead.
        self.sizes.decide(minds, knowledge, step)
        self.formation.reorganize(minds, knowledge, step, events)
        # "Team destination determination": leaders that need one choose from their own view.
        self.decisions = self.destinations.decide(minds, knowledge, planner, step, events)
        # "Each member then independently plans its route to the shared target and moves."
        planner.plan(minds, knowledge, step, events)
        planner.steer(minds, knowledge, bodies.touch, step, self.action)
        self.motion.carry_out(self.action, bodies, step)

        # Against the truth, which minds never see.
        self._judge(links, since, started)

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
    def own_maps(self) -> bool:
        """Whether maps of robots can differ: not under full communication."""
        return not isinstance(self.radio, Full)

    @property
    def map(self) -> BeliefView:
        """The swarm's map: what all logs of evidence together say."""
        return self.swarm.view(0)

    def map_of(self, robot: int) -> BeliefView:
        """One robot's own map (the shared one under full communication)."""
        return self.knowledge.grids.view(int(self.knowledge.ear[robot]))

    def summary(self) -> dict[str, Any]:
        """Facts and figures of the mission so far."""
        scenario = self.scenario
        return {
            "version": package_version(),
            "rules_version": RULES_VERSION,
            "world": self.world.name,
            "start": scenario.start,
            "task": self.task.name,
            "selector": self.destinations.name,
            "robots": scenario.robots,
            "seed": scenario.seed,
            "steps": self.step_number,
            "end_reason": self.end_reason,
            "score": self.task.score(self.map, self.explored_m2),
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

    def _begin(self) -> None:
        if self.done:
            raise ScenarioError(f"the mission is over: {self.end_reason}")
        self._hand_check.before(self.bodies, self.minds, self.knowledge, self.log)
        self.log.allow_writing(True)
        self.step_number += 1
        self.events.clear()

    def _integrate(self, scan: Scan) -> NDArray[np.int64]:
        """Scans become evidence in each robot's log; returns where each log's new entries begin."""
        log, bodies = self.log, self.bodies
        log.make_room(self.knowledge.oldest())
        since = log.length.copy()
        observe(log, self.minds.own, bodies.can, scan, bodies.touch, self._scan_model)
        return since

    def _exchange(self, links: Links, since: NDArray[np.int64]) -> None:
        """Beacons and evidence flow along the links; the swarm's map takes in all evidence."""
        knowledge, log = self.knowledge, self.log
        sound = knowledge.send(self.minds, self.step_number)
        if self.swarm is knowledge.grids and not (sound and links.complete):
            # From now on maps of robots may differ from what the swarm as a whole knows.
            self.swarm = knowledge.grids.fork(0)
        knowledge.receive(self.minds, log, links, self.step_number)
        if self.swarm is not knowledge.grids:
            self.swarm.apply(0, log.cells, log.increments, since, log.length)

    def _charge_and_modes(self) -> None:
        battery, minds, bodies = self.scenario.battery, self.minds, self.bodies
        if battery.enabled:
            spend_or_charge(
                bodies.position, bodies.charge, bodies.alive, bodies.can, minds.mode == CHARGE,
                self.stations_m, self._charger, self.events.rows,
            )  # fmt: skip
        minds.own["charge"] = bodies.charge / battery.capacity_steps
        for capability in ("think", "send", "hear"):
            minds.own[f"{capability}s"] = bodies.can[capability]
        below = -1.0
        if battery.enabled and battery.return_rule == "threshold":
            below = battery.charge_below
        charging = self.planner.charging
        per_m, reserve = charging.share_per_m, charging.share_reserve
        if per_m > 0.0 and not self.planner.look_home(
            minds, self.knowledge, self.action, bodies.contact, self.step_number
        ):
            per_m = reserve = 0.0
        choose_modes(minds.own, below, per_m, reserve, self.events.rows)

    def _judge(self, links: Links, since: NDArray[np.int64], started: float) -> None:
        """Count what the step achieved, and hand it to the recorder."""
        bodies, minds = self.bodies, self.minds
        self._hand_check.after(bodies, minds, self.knowledge, self.log)
        self.judge.judge_robots(bodies, minds, self.action, self.events)
        changes = self.judge.judge_map(self.log, since, self.swarm)
        self.log.allow_writing(False)
        self.end_reason = self._why_over()
        if self._recorder is not None:
            seconds = {"step": perf_counter() - started, "decide": self.destinations.seconds}
            record = self._record(changes, seconds)
            if self.own_maps:
                record.evidence = self.log.entries_from(since)
                record.links = self.knowledge.effective(links, minds)
            self._recorder.record(record)

    def _why_over(self) -> str | None:
        judge = self.judge
        if judge.mobile == 0:
            return "no robot able to move"
        reason = self.task.done(self.swarm.view(0), judge.explored_m2, judge.reachable_m2)
        if reason is None and self.destinations.exhausted(
            self.minds, self.knowledge, self.planner, self.bodies.can["drive"], self.step_number
        ):
            return "no reachable frontier left"
        if reason is None and self.step_number >= self.scenario.steps:
            return "steps used up"
        return reason

    def _record(
        self, changes: tuple[NDArray[np.int64], NDArray[np.int64]], seconds: dict[str, float]
    ) -> StepRecord:
        return StepRecord(
            step=self.step_number,
            bodies=self.bodies,
            minds=self.minds,
            capacity_steps=self.scenario.battery.capacity_steps,
            action=self.action,
            events=self.events.entries,
            map_cells=changes[0],
            map_log_odds=changes[1],
            decisions=self.decisions,
            coverage=self.judge.coverage(self.swarm),
            seconds=seconds,
        )
