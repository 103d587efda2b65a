"""The same scenario and seed give the same bytes, in any process and with any number of threads."""

from __future__ import annotations

import hashlib
import os
import subprocess
import sys
from pathlib import Path

import pytest

PROGRAM = """
import sys
from swarmscout import explore, map_picture
run = explore(robots=7, steps=120, seed=5, destinations="quantile", out=sys.argv[1])
map_picture(run, sys.argv[1] + "/map.png")
"""


def _hashes(folder: Path) -> dict[str, str]:
    return {
        str(file.relative_to(folder)): hashlib.sha256(file.read_bytes()).hexdigest()
        for file in sorted(folder.rglob("*"))
        if file.is_file() and file.name != "timing.zip"
    }


@pytest.mark.slow
def test_two_processes_write_the_same_bytes(tmp_path: Path) -> None:
    for name, threads, hashing in (("a", "1", "1"), ("b", "4", "2")):
        settings = {"POLARS_MAX_THREADS": threads, "PYTHONHASHSEED": hashing}
        subprocess.run(
            [sys.executable, "-c", PROGRAM, str(tmp_path / name)],
            env={**os.environ, **settings},
            check=True,
        )
    first, second = _hashes(tmp_path / "a"), _hashes(tmp_path / "b")
    assert {"steps.parquet", "map.npz", "summary.json", "map.png", "run.json"} <= set(first)
    assert first == second
