"""Run folders from elsewhere: damaged, malicious, left by a dead process, or written by two."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import threading
from pathlib import Path
from typing import Any

import polars as pl
import pytest

from swarmscout import Mission, Run, RunError, RunWriter, Scenario, record_mission
from swarmscout.core.language_model import Reply, Request
from swarmscout.recording.decisions import text_hash
from swarmscout.recording.json_files import read_json, write_json
from swarmscout.recording.run_folder import claim_for_writing
from swarmscout.recording.table_files import leftovers, write_tables, write_whole
from swarmscout.recording.verify import verify_run


class Parrot:
    def complete(self, request: Request) -> Reply:
        return Reply(text="Choice: 1", model="parrot")


@pytest.fixture(scope="module")
def asked(tmp_path_factory: pytest.TempPathFactory) -> Run:
    scenario = Scenario(
        world="lava-tube-small", robots=3, steps=25, destinations="llm", llm={"provider": "openai"}
    )
    folder = tmp_path_factory.mktemp("runs") / "asked"
    return record_mission(scenario, out=folder, model=Parrot())


def test_texts_stay_inside_the_run(asked: Run, tmp_path: Path) -> None:
    (tmp_path / "secret.txt").write_text("secret")
    evil = tmp_path / "evil"
    shutil.copytree(asked.path or "", evil)
    named = pl.lit("../../secret")
    frame = asked.attempts.with_columns(prompt=named, answer=named)
    summary = read_json(evil / "summary.json") or {}
    summary["files"] |= write_tables(evil, {"attempts": frame})
    write_json(evil / "summary.json", summary)
    run = Run.open(evil)
    with pytest.raises(RunError, match="secret' does not name a text"):
        run.text(run.attempts["prompt"][0])
    assert any("does not name a text" in fault for fault in verify_run(evil).faults)


def test_a_text_is_the_one_that_its_name_says(asked: Run, tmp_path: Path) -> None:
    (tmp_path / "secret.txt").write_text("secret")
    evil = tmp_path / "evil"
    shutil.copytree(asked.path or "", evil)
    run = Run.open(evil)
    name = run.attempts["prompt"][0]
    assert text_hash(run.text(name)) == name
    file = evil / "texts" / f"{name}.txt"
    file.unlink()
    file.symlink_to(tmp_path / "secret.txt")
    with pytest.raises(RunError, match="content does not match its name"):
        run.text(name)
    assert any(name in fault for fault in verify_run(evil).faults)


def test_verify_finds_every_damaged_file(asked: Run, tmp_path: Path) -> None:
    assert not verify_run(asked.path or "").faults
    broken = tmp_path / "broken"
    for file in sorted(file for file in (asked.path or Path()).rglob("*") if file.is_file()):
        shutil.copytree(asked.path or "", broken)
        spoiled = broken / file.relative_to(asked.path or "")
        data = bytearray(file.read_bytes())
        data[len(data) // 2] ^= 4
        spoiled.write_bytes(data)
        faults = verify_run(broken).faults
        assert any(spoiled.name in fault for fault in faults), (spoiled, faults)
        spoiled.unlink()
        assert verify_run(broken).faults, f"nobody misses {spoiled}"
        shutil.rmtree(broken)


def test_files_outside_the_folder_are_no_files_of_a_run(asked: Run, tmp_path: Path) -> None:
    evil = tmp_path / "evil"
    shutil.copytree(asked.path or "", evil)
    facts = read_json(evil / "run.json") or {}
    write_json(evil / "run.json", {**facts, "files": {**facts["files"], "../x": "00000000"}})
    assert any("lies outside its folder" in fault for fault in verify_run(evil).faults)


def test_of_two_writers_one_gets_the_folder(tmp_path: Path) -> None:
    outcomes: list[Any] = []

    def claim(folder: Path, ready: threading.Barrier) -> None:
        ready.wait()
        try:
            outcomes.append(claim_for_writing(folder))
        except RunError as error:
            outcomes.append(str(error))

    for attempt in range(30):
        outcomes.clear()
        folder, ready = tmp_path / str(attempt), threading.Barrier(4)
        threads = [threading.Thread(target=claim, args=(folder, ready)) for _ in range(4)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        assert outcomes.count(None) == 1, outcomes
        for line in filter(None, outcomes):
            assert "give a new one, for example" in line


def test_two_missions_into_one_folder(tmp_path: Path) -> None:
    scenario = Scenario(world="lava-tube-small", robots=2, steps=3)
    first = RunWriter(tmp_path / "two")
    mission = Mission(scenario, recorder=first)
    with pytest.raises(RunError, match="not empty"):
        Mission(scenario, recorder=RunWriter(tmp_path / "two"))
    mission.run()
    assert first.run().finished


def test_a_mission_that_cannot_begin_leaves_no_folder(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def broken(*_: Any, **__: Any) -> Any:
        raise RunError("no world today")

    monkeypatch.setattr("swarmscout.recording.writer.keep_world", broken)
    with pytest.raises(RunError, match="no world today"):
        record_mission(Scenario(robots=2, steps=3), out=tmp_path / "x")
    assert not (tmp_path / "x").exists()


def test_a_folder_without_its_facts_is_not_finished(asked: Run, tmp_path: Path) -> None:
    shutil.copytree(asked.path or "", tmp_path / "half")
    (tmp_path / "half" / "run.json").unlink()
    with pytest.raises(RunError, match="is not a run"):
        Run.open(tmp_path / "half")


def test_what_dead_processes_left_is_swept(tmp_path: Path) -> None:
    program = (
        "import os, sys; from pathlib import Path; from swarmscout.recording import table_files\n"
        "table_files.os.replace = lambda *_: os._exit(9)\n"
        "table_files.write_whole(Path(sys.argv[1]), b'half')\n"
    )
    file = tmp_path / "report.html"
    assert subprocess.run([sys.executable, "-c", program, str(file)]).returncode == 9
    other = tmp_path / f".report.html.{os.getpid()}@{os.uname().nodename}.00000000.tmp"
    other.write_text("of a process that lives")
    (left,) = leftovers(tmp_path)
    assert left.read_text() == "half"
    write_whole(file, b"whole")
    assert sorted(path.name for path in tmp_path.iterdir()) == [other.name, "report.html"]


def test_a_run_holds_no_path_of_this_machine(tmp_path: Path) -> None:
    rule = tmp_path / "my.py"
    rule.write_text("from swarmscout.destinations.nearest import Nearest as Far\n")
    scenario = Scenario(world="lava-tube-small", robots=2, steps=2, destinations=f"{rule}:Far")
    record_mission(scenario, out=tmp_path / "run", record="summary")
    for file in (tmp_path / "run").rglob("*"):
        if file.is_file() and file.suffix in (".json", ".toml"):
            assert str(tmp_path) not in file.read_text(), file
