from __future__ import annotations

import json
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from swarmscout import Mission, Run, RunError, RunWriter, Scenario, World, record_mission


def test_the_map_at_any_step_is_what_the_mission_had(finished: Run, tape: Any) -> None:
    log_odds = np.zeros(finished.frame.size, dtype=np.int64)
    for record in tape.records:
        log_odds[record.map_cells] = record.map_log_odds
        if record.step % 10 == 0:
            np.testing.assert_array_equal(finished.map_at(record.step).ravel(), log_odds)
    np.testing.assert_array_equal(finished.map_at(), tape.mission.map.log_odds)


def test_the_last_map_by_changes_is_the_final_map(finished: Run, tape: Any, empty: Path) -> None:
    writer = RunWriter(empty)
    tape.play(writer, end=False)
    writer.close()
    assert not Run.open(empty).finished
    np.testing.assert_array_equal(Run.open(empty).map_at(), finished.map_at())


def test_steps_that_are_not_there(finished: Run) -> None:
    for step in (-1, finished.last_step + 1):
        with pytest.raises(RunError, match=f"no step {step}: the run holds steps 0 to 130"):
            finished.map_at(step)


def test_a_finished_run_knows_itself(finished: Run, scenario: Scenario) -> None:
    assert finished.finished
    assert finished.summary is not None
    assert finished.summary["steps"] == scenario.steps == finished.last_step
    assert finished.coverage["explored_m2"][-1] == finished.summary["explored_m2"] > 0
    assert finished.scenario == scenario.model_copy(
        update={"world_seed": finished.scenario.world_seed}
    )
    mission = Mission(scenario)
    assert finished.frame == mission.frame
    np.testing.assert_array_equal(finished.stations_m, mission.stations_m)
    np.testing.assert_array_equal(finished.world().free, mission.world.free)
    assert repr(finished).endswith("6 robots, finished>")


def test_a_run_folder_runs_again(finished: Run, empty: Path) -> None:
    again = record_mission(finished.scenario, out=empty)
    assert again.summary == finished.summary
    assert again.steps.equals(finished.steps)


def test_an_imported_world_is_kept_and_moves_with_its_run(tmp_path: Path) -> None:
    free = np.zeros((80, 120), dtype=np.uint8)
    free[10:70, 10:110] = 1
    world = World("hall", free, 0.1, origin_m=(-3.0, 2.0), start_m=(0.0, 5.0))
    scenario = Scenario(world="hall", robots=3, steps=12)
    run = record_mission(scenario, out=tmp_path / "a", world=world)
    shutil.move(tmp_path / "a", tmp_path / "b")
    moved = Run.open(tmp_path / "b")
    kept = moved.world()
    np.testing.assert_array_equal(kept.free, free)
    assert (kept.origin_m, kept.resolution_m) == (world.origin_m, world.resolution_m)
    assert 'world = "world"\n' in (tmp_path / "b" / "scenario.toml").read_text()
    again = record_mission(moved.scenario)
    assert again.steps.equals(moved.steps)
    assert again.summary is not None
    assert run.summary is not None
    assert again.summary["explored_m2"] == run.summary["explored_m2"]


def test_a_generated_world_that_changed_is_noticed(finished: Run, tmp_path: Path) -> None:
    broken = _copy(finished, tmp_path)
    facts = json.loads((broken / "run.json").read_text())
    facts["world"]["source"]["digest"] = "another"
    (broken / "run.json").write_text(json.dumps(facts))
    with pytest.raises(RunError, match="generates another 'lava-tube'"):
        Run.open(broken).world()


def _copy(run: Run, folder: Path) -> Path:
    assert run.path is not None
    return Path(shutil.copytree(run.path, folder / "copy"))


def _cut(file: str) -> Callable[[Path], None]:
    def spoil(folder: Path) -> None:
        data = (folder / file).read_bytes()
        (folder / file).write_bytes(data[: len(data) // 2])

    return spoil


def _remove(file: str) -> Callable[[Path], None]:
    return lambda folder: (folder / file).unlink()


def _text(file: str, text: str) -> Callable[[Path], None]:
    def spoil(folder: Path) -> None:
        (folder / file).write_text(text)

    return spoil


def _everything(run: Run) -> None:
    for table in ("steps", "coverage", "map_changes", "decisions", "events", "timing"):
        run.table(table)
    run.map_at()
    run.map_at(5)
    run.world()


@pytest.mark.parametrize(
    ("spoil", "message"),
    [
        (_cut("steps.parquet"), r"steps\.parquet' is damaged: it is no whole Parquet file"),
        (_cut("coverage.parquet"), r"coverage\.parquet' is damaged"),
        (_text("events.parquet", ""), r"events\.parquet' is damaged"),
        (_remove("decisions.parquet"), r"is damaged: its table 'decisions' is missing"),
        (_cut("map.npz"), r"map\.npz' is damaged: it is no map"),
        (_remove("map.npz"), r"map\.npz' is missing"),
        (_cut("summary.json"), r"summary\.json' is damaged: it is no JSON"),
        (_text("summary.json", "[]"), r"summary\.json' is damaged: it holds no JSON object"),
        (_cut("run.json"), r"run\.json' is damaged: it is no JSON"),
        (_remove("run.json"), r"is no run: it has no run\.json"),
        (_text("run.json", '{"name": "x"}'), r"is no run: its run\.json is something else's"),
        (_text("run.json", '{"format": 99, "version": "9"}'), r"newer swarmscout \(9\)"),
        (_text("run.json", '{"format": 1, "record": "x"}'), r"recording level 'x' is unknown"),
        (_text("run.json", '{"format": 1, "record": "full"}'), r"run\.json' is damaged: 'frame'"),
        (_remove("scenario.toml"), r"scenario file '.*scenario\.toml' does not exist"),
        (
            _text("scenario.toml", "robots = ["),
            r"run '.*' is damaged: .*scenario\.toml' is not valid",
        ),
        (_text("scenario.toml", "robts = 3"), r"unknown key 'robts'"),
    ],
)
def test_what_is_damaged_is_said_in_one_line(
    finished: Run, tmp_path: Path, spoil: Callable[[Path], None], message: str
) -> None:
    broken = _copy(finished, tmp_path)
    spoil(broken)
    with pytest.raises(RunError, match=message) as caught:
        _everything(Run.open(broken))
    assert "\n" not in str(caught.value)


def test_what_is_no_run_is_refused(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("x")
    (tmp_path / "folder").mkdir()
    for name, message in (
        ("nothing", "does not exist"),
        ("file", "is a file, not a run's folder"),
        ("folder", "is no run"),
    ):
        with pytest.raises(RunError, match=message):
            Run.open(tmp_path / name)


def test_a_run_that_has_only_just_begun_opens(tape: Any, empty: Path) -> None:
    tape.play(RunWriter(empty), until=3, end=False)
    run = Run.open(empty)
    assert (run.finished, run.summary, run.last_step) == (False, None, -1)
    assert run.steps.height == run.coverage.height == run.events.height == 0
    with pytest.raises(RunError, match="no step"):
        run.map_at()


def test_a_table_that_no_run_has(finished: Run) -> None:
    with pytest.raises(RunError, match="no table 'stepss'"):
        finished.table("stepss")
