"""The map of one robot, out of a run, is the map that the robot had."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import polars as pl
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from swarmscout import Mission, Run, RunError, Scenario, explore, record_mission
from swarmscout.recording.own_maps import GatheredEvidence, OwnMaps
from swarmscout.recording.tables import OWN_MAPS

ROBOTS = 6
SCENARIO = Scenario(
    world="lava-tube-small", robots=ROBOTS, steps=70, seed=2, destinations="nearest",
    battery={"capacity_steps": 90, "start_min": 0.2},
)  # fmt: skip


def weather(seed: int, share: float, lasts: int = 9) -> Any:
    """Links that come and go, not always in both directions; the same whenever asked."""

    def links(step: int) -> np.ndarray:
        rng = np.random.default_rng([seed, step // lasts])
        return rng.random((ROBOTS, ROBOTS)) < share

    return links


def gathered_of(run: Run) -> GatheredEvidence:
    return GatheredEvidence.of(run.evidence, run.links, ROBOTS, run.last_step)


class Watch:
    """Keeps every robot's map and version vector after each step."""

    def __init__(self) -> None:
        self.maps: list[np.ndarray] = []
        self.known: list[np.ndarray] = []
        self.mission: Any = None

    def begin(self, mission: Any) -> None:
        self.mission = mission

    def record(self, _: Any) -> None:
        of = self.mission.map_of
        self.maps.append(np.stack([of(robot).log_odds for robot in range(ROBOTS)]))
        knowledge = self.mission.knowledge
        self.known.append(knowledge.versions[knowledge.ear])

    def end(self, summary: Any) -> None: ...


@pytest.fixture(scope="module")
def watch() -> Watch:
    return Watch()


@pytest.fixture(scope="module")
def run(watch: Watch, tmp_path_factory: pytest.TempPathFactory) -> Run:
    out = tmp_path_factory.mktemp("runs") / "apart"
    return record_mission(SCENARIO, out=out, links=weather(1, 0.15), watchers=[watch])


def test_a_robots_map_is_the_one_it_had(run: Run, watch: Watch) -> None:
    assert run.own_maps
    last = watch.maps[-1]
    assert any((last[0] != last[robot]).any() for robot in range(1, ROBOTS)), "no maps differ"
    for step in (0, 1, 17, 50, run.last_step):
        for robot in range(ROBOTS):
            np.testing.assert_array_equal(run.map_at(step, robot=robot), watch.maps[step][robot])
    np.testing.assert_array_equal(run.map_at(robot=3), last[3])


@settings(max_examples=6, deadline=None)
@given(seed=st.integers(0, 99), share=st.floats(0.0, 1.0))
def test_every_map_at_every_step(seed: int, share: float) -> None:
    """Law: forward replay gives each robot's map and version vector, whatever the links."""
    watch = Watch()
    run = record_mission(
        SCENARIO.model_copy(update={"steps": 25}), links=weather(seed, share, 3), watchers=[watch]
    )
    gathered = gathered_of(run)
    maps = run.robot_maps(range(ROBOTS))
    lengths = np.zeros((run.last_step + 1, ROBOTS), dtype=np.int64)
    for step in range(1, run.last_step + 1):
        ends = gathered.ends[step]
        begins = np.concatenate([gathered.ends[step - 1, -1:], ends[:-1]])
        lengths[step] = lengths[step - 1] + ends - begins
    changed = {robot: np.zeros(run.frame.size, dtype=np.int32) for robot in range(ROBOTS)}
    for step in range(1, run.last_step + 1):
        maps.advance(step)
        entries = lengths[maps.versions, np.arange(ROBOTS)]
        np.testing.assert_array_equal(entries, watch.known[step])
        for robot in range(ROBOTS):
            np.testing.assert_array_equal(maps.log_odds(robot), watch.maps[step][robot])
            news = maps.changes(robot, step)
            assert (news.step == step).all()
            assert (changed[robot][news.cell] != news.log_odds).all(), "that is no change"
            changed[robot][news.cell] = news.log_odds
            np.testing.assert_array_equal(changed[robot], watch.maps[step][robot].ravel())


def test_the_swarms_map_is_still_there(run: Run) -> None:
    known = run.map_at() != 0
    assert all((run.map_at(robot=robot) != 0).sum() <= known.sum() for robot in range(ROBOTS))


def test_a_broken_off_run_and_one_in_memory_know_it_too(
    run: Run, watch: Watch, tmp_path: Path
) -> None:
    def fail(mission: Any) -> None:
        if mission.step_number == 50:
            raise RuntimeError

    with pytest.raises(RuntimeError):
        record_mission(SCENARIO, out=tmp_path / "x", links=weather(1, 0.15), on_step=fail)
    broken = Run.open(tmp_path / "x")
    assert (broken.finished, broken.last_step) == (False, 50)
    np.testing.assert_array_equal(broken.map_at(robot=2), watch.maps[50][2])

    memory = record_mission(SCENARIO, links=weather(1, 0.15))
    np.testing.assert_array_equal(memory.map_at(30, robot=4), watch.maps[30][4])


def test_links_are_kept_as_changes(run: Run) -> None:
    links = weather(1, 0.15)
    there = np.zeros((ROBOTS, ROBOTS), dtype=bool)
    for step in range(1, run.last_step + 1):
        for _, listener, speaker, hears in run.links.filter(pl.col("step") == step).rows():
            assert there[listener, speaker] != hears, "that is no change"
            there[listener, speaker] = hears
        np.testing.assert_array_equal(there, links(step) & ~np.eye(ROBOTS, dtype=bool))


def test_full_communication_keeps_nothing_more(tmp_path: Path) -> None:
    run = record_mission(SCENARIO.model_copy(update={"steps": 10}), out=tmp_path / "one")
    assert not run.own_maps
    assert not any((run.path / f"{table}.parquet").exists() for table in OWN_MAPS)
    assert [run.evidence.height, run.links.height] == [0, 0]
    np.testing.assert_array_equal(run.map_at(5, robot=3), run.map_at(5))


def test_mistakes_are_one_clear_line(run: Run) -> None:
    for robot, words in ((6, "robots 0 to 5"), (-1, "robots 0 to 5"), ("3", "whole number")):
        with pytest.raises(RunError, match=words):
            run.map_at(3, robot=robot)
    curves = record_mission(
        SCENARIO.model_copy(update={"steps": 5}), links=weather(1, 0.5), record="curves"
    )
    with pytest.raises(RunError, match="was not recorded"):
        curves.map_at(2, robot=1)


def test_explore_takes_links() -> None:
    run = explore(
        "lava-tube-small", robots=ROBOTS, steps=12, seed=2, links=lambda _: np.eye(ROBOTS) > 0
    )
    assert run.own_maps
    assert run.links.height == 0
    mission = Mission(run.scenario, links=lambda _: np.eye(ROBOTS) > 0)
    mission.run()
    np.testing.assert_array_equal(run.map_at(robot=5), mission.map_of(5).log_odds)


def test_one_who_reads_while_another_writes(run: Run) -> None:
    """What was gathered up to a step stays as it is while more comes."""
    whole = gathered_of(run)
    growing = GatheredEvidence(ROBOTS)
    maps = OwnMaps(growing, [1], run.frame, run.robot_maps([1])._model)
    for step in range(1, run.last_step + 1):
        begin, end = whole.ends[step - 1, -1], whole.ends[step, -1]
        counts = np.diff(whole.ends[step], prepend=begin)
        robot = np.repeat(np.arange(ROBOTS), counts)
        rows = np.column_stack([robot, whole.cells[begin:end], whole.increments[begin:end]])
        growing.add(rows, whole.links_in(step))
        if step % 20 == 0:
            maps.advance(step)
            np.testing.assert_array_equal(maps.log_odds(1), run.map_at(step, robot=1))
