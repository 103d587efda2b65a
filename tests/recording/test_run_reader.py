from __future__ import annotations

import contextlib
import random
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import polars as pl
import pytest

from swarmscout import Mission, Run, RunError, RunWriter, Scenario, World, record_mission
from swarmscout.mission.mission import RULES_VERSION
from swarmscout.recording.json_files import read_json, write_json
from swarmscout.recording.table_files import write_tables


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
        with pytest.raises(RunError, match=f"no step {step}: the run has steps 0 to 130"):
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
    facts = read_json(broken / "run.json") or {}
    facts["world"]["source"]["digest"] = "another"
    write_json(broken / "run.json", facts)
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


def _sealed(file: str, **changes: Any) -> Callable[[Path], None]:
    """Other content with the right checksum, as another program would write it."""

    def spoil(folder: Path) -> None:
        write_json(folder / file, {**(read_json(folder / file) or {}), **changes})

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
        (_cut("steps.parquet"), r"steps\.parquet' is damaged: its \d+ bytes do not match"),
        (_cut("coverage.parquet"), r"coverage\.parquet' is damaged"),
        (_text("events.parquet", ""), r"events\.parquet' is damaged: its 0 bytes"),
        (_remove("decisions.parquet"), r"is damaged: 'decisions\.parquet' is missing"),
        (_cut("timing.zip"), r"timing\.zip' is damaged: its 'timing\.arrows' is not whole"),
        (_remove("timing.zip"), r"is damaged: its table 'timing' is missing"),
        (_cut("map.npz"), r"map\.npz' is damaged: its \d+ bytes do not match"),
        (_remove("map.npz"), r"is damaged: 'map\.npz' is missing"),
        (_cut("summary.json"), r"summary\.json' is damaged: it is not valid JSON"),
        (_text("summary.json", "[]"), r"summary\.json' is damaged: it holds no JSON object"),
        (_text("summary.json", "[" * 99999), r"summary\.json' is damaged: it is not valid JSON"),
        (_text("summary.json", "9" * 5000), r"summary\.json' is damaged: it is not valid JSON"),
        (_text("summary.json", "{}"), r"summary\.json' is damaged: its content does not match"),
        (_cut("run.json"), r"run\.json' is damaged: it is not valid JSON"),
        (_remove("run.json"), r"is not a run: it has no run\.json"),
        (_text("run.json", '{"name": "x"}'), r"is not a run: its run\.json has another format"),
        (_text("run.json", '{"format": 99, "version": "9"}'), r"newer swarmscout \(9\) in format"),
        (_text("run.json", '{"format": 1, "version": "0.1"}'), r"older swarmscout \(0\.1\) in"),
        (_sealed("run.json", record="x"), r"recording level 'x' is unknown"),
        (_sealed("run.json", frame=None), r"run\.json' is damaged: "),
        (_sealed("run.json", frame={}), r"run\.json' is damaged: "),
        (_sealed("run.json", files=None), r"run\.json' is damaged: "),
        (_sealed("run.json", tables=["texts"]), r"tables texts are not those of level 'full'"),
        (_sealed("run.json", robots=7), r"run\.json: it has 7 robots, the scenario 6"),
        (
            _sealed("run.json", rules_version=99),
            rf"rules_version is 99, in summary\.json {RULES_VERSION}",
        ),
        (_sealed("run.json", stations_m="here"), r"run\.json' is damaged: "),
        (_sealed("summary.json", steps="many"), r"does not say how many steps"),
        (_text("scenario.toml", "robots = 6"), r"scenario\.toml' is damaged: its 10 bytes do not"),
        (_remove("scenario.toml"), r"is damaged: 'scenario\.toml' is missing"),
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


def test_what_is_not_a_run_is_refused(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("x")
    (tmp_path / "folder").mkdir()
    for name, message in (
        ("nothing", "does not exist"),
        ("file", "is a file, not a run's folder"),
        ("folder", "is not a run"),
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


def _resealed(run: Run, folder: Path, table: str, frame: pl.DataFrame) -> Run:
    """A run with another table whose checksum is right."""
    broken = _copy(run, folder)
    summary = read_json(broken / "summary.json") or {}
    summary["files"] |= write_tables(broken, {table: frame})
    write_json(broken / "summary.json", summary)
    return Run.open(broken)


@pytest.mark.parametrize(
    ("table", "change", "message"),
    [
        ("steps", lambda f: f.head(-1), "steps or robots are missing"),
        ("steps", lambda f: f.head(-6), r"it has 780 rows, expected 786"),
        ("steps", lambda f: f.drop("charge"), "column 'charge' of 'steps' is missing, expected Fl"),
        ("steps", lambda f: f.with_columns(extra=1), "'extra' of 'steps' is Int32, expected no"),
        (
            "steps",
            lambda f: f.with_columns(pl.col("team").cast(pl.Int32, strict=False)),
            "column 'team' of 'steps' is Int32, expected Int64",
        ),
        (
            "steps",
            lambda f: f.with_columns(leader=pl.lit(6, pl.Int32)),
            "column 'leader' has the value 6, which is not a robot",
        ),
        (
            "steps",
            lambda f: f.with_columns(x_m=pl.lit(None, pl.Float64)),
            "column 'x_m' has empty values",
        ),
        (
            "map_changes",
            lambda f: f.with_columns(cell=pl.lit(-1, pl.Int32)),
            "column 'cell' has the value -1, which is not a cell",
        ),
        ("map_changes", lambda f: f.reverse(), "its steps are not in order"),
        ("coverage", lambda f: f.tail(-1), "steps or robots are missing"),
        ("timing", lambda f: f.head(-1), "it has 130 rows, expected 131"),
    ],
)
def test_impossible_tables_are_said_in_one_line(
    finished: Run, tmp_path: Path, table: str, change: Any, message: str
) -> None:
    broken = _resealed(finished, tmp_path, table, change(finished.table(table)))
    with pytest.raises(RunError, match=message) as caught:
        broken.table(table)
    assert "\n" not in str(caught.value)


def test_one_flipped_bit_is_noticed_or_changes_nothing(finished: Run, tmp_path: Path) -> None:
    draw = random.Random(5)
    broken = _copy(finished, tmp_path)
    expected = repr(_content(finished))
    for file in sorted(broken.iterdir()):
        data = file.read_bytes()
        for _ in range(25):
            wrong = bytearray(data)
            at = draw.randrange(len(data))
            wrong[at] ^= 1 << draw.randrange(8)
            file.write_bytes(wrong)
            with contextlib.suppress(RunError):
                assert repr(_content(Run.open(broken))) == expected, (file.name, at)
        file.write_bytes(data)


def _content(run: Run) -> list[Any]:
    hashes = [run.table(table).hash_rows().sum() for table in run.tables]
    return [*hashes, run.map_at().tobytes(), run.summary, run.facts, run.scenario]
