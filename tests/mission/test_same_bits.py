"""Law 7: same scenario and seed, same bits: in any process, on any number of threads."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from tape import Tape, digest, scenario_of, small_world, state_of

from swarmscout.core.streams import stream
from swarmscout.mission.mission import Mission

HERE = Path(__file__).parent
SCRIPT = """
import sys
sys.path.insert(0, sys.argv[1])
from tape import digest, scenario_of, small_world
from swarmscout.mission.mission import Mission
for destinations in ("quantile", "nearest"):
    mission = Mission(scenario_of(seed=4, destinations=destinations), world=small_world(4))
    mission.run()
    print(digest(mission))
"""


def test_the_same_in_other_processes_and_on_other_thread_counts() -> None:
    expected = []
    for destinations in ("quantile", "nearest"):
        mission = Mission(scenario_of(seed=4, destinations=destinations), world=small_world(4))
        mission.run()
        expected.append(digest(mission))
    assert expected[0] != expected[1]
    for threads, hashes in (("1", "0"), ("2", "12345")):
        environment = {
            **os.environ,
            "NUMBA_NUM_THREADS": threads,
            "OMP_NUM_THREADS": threads,
            "OPENBLAS_NUM_THREADS": threads,
            "PYTHONHASHSEED": hashes,
            "PYTHONPATH": os.pathsep.join(sys.path),
        }
        done = subprocess.run(
            [sys.executable, "-c", SCRIPT, str(HERE)],
            env=environment,
            capture_output=True,
            text=True,
            check=True,
        )
        assert done.stdout.split() == expected


def test_the_same_mission_twice_and_seeds_matter() -> None:
    missions = [Mission(scenario_of(seed=s), world=small_world(1)) for s in (6, 6, 7)]
    for mission in missions:
        mission.run()
    one, again, other = (digest(mission) for mission in missions)
    assert one == again
    assert one != other


def test_stepping_by_hand_is_running() -> None:
    by_hand = Mission(scenario_of(seed=6), world=small_world(1))
    while not by_hand.done:
        by_hand.step()
    at_once = Mission(scenario_of(seed=6), world=small_world(1))
    at_once.run()
    assert digest(by_hand) == digest(at_once)


def test_a_recorder_changes_nothing() -> None:
    without = Mission(scenario_of(seed=2), world=small_world(1))
    summary = without.run()
    tape = Tape()
    recorded = Mission(scenario_of(seed=2), world=small_world(1), recorder=tape)
    assert recorded.run() == summary == tape.summary
    assert digest(without) == digest(recorded)
    assert [record.step for record in tape.records] == list(range(without.step_number + 1))
    assert (tape.records[-1].pose == without.bodies.pose).all()


def test_missions_beside_each_other_do_not_meet() -> None:
    alone = Mission(scenario_of(seed=2), world=small_world(1))
    alone.run()
    pair = [Mission(scenario_of(seed=s), world=small_world(s - 1)) for s in (2, 3)]
    while not all(mission.done for mission in pair):
        for mission in pair:
            if not mission.done:
                mission.step()
    assert digest(pair[0]) == digest(alone)


@pytest.mark.parametrize("start", ["one-place", "spread"])
def test_selectors_are_compared_in_pairs(start: str) -> None:
    """Whichever selector runs: same starts, headings, charges and noise."""
    missions = [
        Mission(
            scenario_of(seed=9, start=start, destinations=name, sensor={"range_m": 3.0}),
            world=small_world(0),
        )
        for name in ("quantile", "nearest", "random")
    ]
    starts = [state_of(mission) for mission in missions]
    for other in starts[1:]:
        for name in ("position", "heading", "charge"):
            assert other[name].tobytes() == starts[0][name].tobytes()
    for mission in missions:
        mission.step()
    first = [mission.sensing.last.ranges for mission in missions]
    assert np.isfinite(first[0]).any()
    assert all(ranges.tobytes() == first[0].tobytes() for ranges in first[1:])
    assert all((m.swarm.evidence == missions[0].swarm.evidence).all() for m in missions[1:]), (
        "all see the same in their first step"
    )
    while not any(mission.done for mission in missions):
        for mission in missions:
            mission.step()
    noise = [noise_of(mission) for mission in missions]
    assert all(drawn.tobytes() == noise[0].tobytes() for drawn in noise[1:])
    block, within = divmod(missions[0].step_number, 50)
    expected = stream(9, "sensor", block).standard_normal((50, *noise[0].shape))[within]
    assert (noise[0] == expected).all()


def noise_of(mission: Mission) -> NDArray[np.float64]:
    shape = mission.sensing.last.ranges.shape
    return mission.sensing.sensor._noise.at(mission.scenario.seed, shape, mission.step_number)


def test_a_death_shifts_nobodys_noise() -> None:
    given = scenario_of(seed=1, steps=30, battery={"station_range_m": 0.01})
    missions = [Mission(given, world=small_world(0)) for _ in range(2)]
    missions[1].bodies.charge[3] = 2.0
    for _ in range(10):
        for mission in missions:
            mission.step()
    assert not missions[1].bodies.alive[3]
    a, b = (noise_of(mission) for mission in missions)
    assert a.tobytes() == b.tobytes()
