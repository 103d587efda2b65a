from __future__ import annotations

import os
import re
from pathlib import Path

import pytest

from swarmscout import RunError, Scenario, record_mission
from swarmscout.recording.run_folder import (
    claim_folder,
    claim_next_free,
    default_name,
    release_folder,
)
from swarmscout.recording.tables import LEVELS, OWN_MAPS


@pytest.mark.parametrize(
    ("world", "destinations", "name"),
    [
        ("lava-tube", "nearest", "lava-tube-nearest-n15-s0"),
        ("maps/My cave.yaml", "rules/mine.py:Far", "My-cave-Far-n15-s0"),
        ("../x/cave.map", "nearest", "cave-nearest-n15-s0"),
    ],
)
def test_a_run_is_named_after_its_mission(world: str, destinations: str, name: str) -> None:
    assert default_name(Scenario(world=world, destinations=destinations)) == name


def test_the_next_free_name_is_taken(tmp_path: Path) -> None:
    folders = [claim_next_free(tmp_path / "runs" / "x") for _ in range(3)]
    assert [folder.name for folder in folders] == ["x", "x-2", "x-3"]
    assert all(folder.is_dir() for folder in folders)


def test_only_an_empty_folder_can_be_claimed(tmp_path: Path) -> None:
    claim_folder(tmp_path / "new" / "deeper")
    assert claim_folder(tmp_path / "new" / "deeper").is_dir()
    (tmp_path / "new" / "note.txt").write_text("mine")
    with pytest.raises(RunError, match=r"not empty: give a new one, for example '.*new-2'"):
        claim_folder(tmp_path / "new")
    assert (tmp_path / "new" / "note.txt").read_text() == "mine"


def test_files_are_in_the_way(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("mine")
    with pytest.raises(RunError, match=r"'.*file' is a file: a run needs a folder"):
        claim_folder(tmp_path / "file")
    with pytest.raises(RunError, match=r"cannot make the run folder '.*': Not a directory"):
        claim_folder(tmp_path / "file" / "below")
    with pytest.raises(RunError, match=r"'.*file' is a file: runs need a folder"):
        claim_next_free(tmp_path / "file" / "x")


@pytest.mark.skipif(os.geteuid() == 0, reason="the superuser may write everywhere")
def test_a_folder_without_permission(tmp_path: Path) -> None:
    (tmp_path / "locked").mkdir(mode=0o555)
    with pytest.raises(RunError, match=r"cannot make the run folder '.*': Permission denied"):
        claim_folder(tmp_path / "locked" / "run")


def test_releasing_removes_nothing_but_an_empty_folder(tmp_path: Path) -> None:
    (tmp_path / "full").mkdir()
    (tmp_path / "full" / "note.txt").write_text("mine")
    release_folder(tmp_path / "full")
    assert (tmp_path / "full" / "note.txt").exists()
    release_folder(claim_folder(tmp_path / "empty"))
    assert not (tmp_path / "empty").exists()


@pytest.mark.skipif(not Path("/proc/self/fd").exists(), reason="needs /proc")
def test_what_finishes_a_run_is_on_the_disk_before_its_summary(
    scenario: Scenario, empty: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    seen: list[tuple[str, str]] = []
    sync, replace = os.fsync, os.replace

    def synced(number: int) -> None:
        file = Path(os.readlink(f"/proc/self/fd/{number}"))
        seen.append(("synced", re.sub(r"^\.|\.\d+@.*\.tmp$", "", file.name)))
        sync(number)

    def replaced(old: Path, new: Path) -> None:
        seen.append(("in place", Path(new).name))
        replace(old, new)

    monkeypatch.setattr(os, "fsync", synced)
    monkeypatch.setattr(os, "replace", replaced)
    record_mission(scenario.model_copy(update={"steps": 60}), out=empty)
    assert seen[-1] == ("in place", "summary.json")
    tables = [table for table in LEVELS["full"] if table not in ("attempts", "timing", *OWN_MAPS)]
    for name in (*(f"{table}.parquet" for table in tables), "map.npz", "summary.json"):
        assert seen.index(("synced", name)) < seen.index(("in place", name))
