"""One recorded mission that the tests of this folder share, and its steps to be played again."""

from __future__ import annotations

import copy
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import pytest

from swarmscout import Mission, Run, Scenario, record_mission
from swarmscout.core.recorder import StepRecord

STEPS = 130  # More than two parts of fifty steps and a rest.


class Tape:
    """A recorder that keeps copies of everything, and plays them to another recorder.

    With a tape a test can write the same mission many times without running it again.
    """

    def __init__(self) -> None:
        self.mission: Any = None
        self.records: list[StepRecord] = []
        self.summary: dict[str, Any] = {}

    def begin(self, mission: Any) -> None:
        self.mission = mission

    def record(self, record: StepRecord) -> None:
        self.records.append(copy.deepcopy(record))

    def end(self, summary: Mapping[str, Any]) -> None:
        self.summary = dict(summary)

    def play(self, recorder: Any, *, until: int | None = None, end: bool = True) -> None:
        recorder.begin(self.mission)
        for record in self.records:
            if until is None or record.step <= until:
                recorder.record(record)
        if end:
            recorder.end(self.summary)


@pytest.fixture(scope="session")
def scenario() -> Scenario:
    return Scenario(robots=6, steps=STEPS, seed=4, destinations="nearest")


@pytest.fixture(scope="session")
def finished(scenario: Scenario, tmp_path_factory: pytest.TempPathFactory) -> Run:
    return record_mission(scenario, out=tmp_path_factory.mktemp("runs") / "finished")


@pytest.fixture(scope="session")
def tape(scenario: Scenario) -> Tape:
    recorder = Tape()
    Mission(scenario, recorder=recorder).run()
    return recorder


@pytest.fixture
def empty(tmp_path: Path) -> Path:
    return tmp_path / "run"
