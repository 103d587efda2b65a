"""Runs for the Rerun viewer."""

from __future__ import annotations

import subprocess
import sys

import pytest

from swarmscout.core.errors import RunError, ViewError
from swarmscout.viewing import rerun_recording
from swarmscout.viewing.rerun_recording import record_rrd, show_rrd


def test_a_recording_holds_every_step(run, tmp_path):
    file = record_rrd(run, tmp_path / "m.rrd")
    assert file.read_bytes()[:3] == b"RRF"
    told = subprocess.run(
        [sys.executable, "-m", "rerun", "rrd", "print", str(file)],
        capture_output=True, text=True, check=True,
    ).stdout  # fmt: skip
    for path in ("/cave/ground", "/cave/robots", "/map/grid", "/curves/explored_m2", "/decisions"):
        assert path in told


def test_mistakes_are_one_clear_line(run, tmp_path, monkeypatch):
    with pytest.raises(ViewError, match=r"ends in \.rrd"):
        record_rrd(run, tmp_path / "m.rr")
    with pytest.raises(RunError, match="cannot write"):
        record_rrd(run, tmp_path / "no" / "m.rrd")
    monkeypatch.setitem(sys.modules, "rerun", None)
    with pytest.raises(ViewError, match="pip install"):
        record_rrd(run, tmp_path / "m.rrd")


def test_the_viewer_is_bound_to_loopback_and_is_no_web_page(monkeypatch, tmp_path):
    asked = []
    monkeypatch.setattr(rerun_recording.subprocess, "call", lambda words: asked.append(words) or 0)
    assert show_rrd(tmp_path / "m.rrd") == 0
    assert asked[0][asked[0].index("--bind") + 1] == "127.0.0.1"
    assert not any("web" in word for word in asked[0][2:-1])
