"""Runs for the Rerun viewer."""

from __future__ import annotations

import subprocess
import sys

import numpy as np
import pytest

from swarmscout.core.errors import RunError, ViewError
from swarmscout.viewing import rerun_recording
from swarmscout.viewing.relief import relief_of
from swarmscout.viewing.replay import Replay
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


def columns_of(file):
    """Every logged component of a recording: {(entity, component): {step or None: values}}."""
    chunk = pytest.importorskip("rerun.chunk")
    found = {}
    for piece in chunk.RrdReader(file).stream():
        batch = piece.to_record_batch()
        names = batch.schema.names
        steps = batch["step"].to_pylist() if "step" in names else [None] * batch.num_rows
        for name in names:
            if ":" in name:
                rows = found.setdefault((str(piece.entity_path), name), {})
                rows |= dict(zip(steps, batch[name].to_pylist(), strict=True))
    return found


def test_what_it_holds_is_what_the_run_holds(run, tmp_path):
    told = columns_of(record_rrd(run, tmp_path / "m.rrd"))
    relief = relief_of(run.world(), rerun_recording.MOST_CELLS)
    places = told["/cave/robots", "Points3D:positions"]
    assert sorted(places) == list(range(run.last_step + 1))
    for step in (0, 25, run.last_step):
        moment = Replay(run).moment(step)
        at = np.array(places[step])
        assert at[:, :2] == pytest.approx(moment.place_m, abs=1e-5)
        # Robots stand on the ground that is shown, a little above it to be seen.
        assert at[:, 2] == pytest.approx(relief.ground_at(moment.place_m) + 0.15, abs=1e-5)
        ahead = np.array(told["/cave/headings", "Arrows3D:vectors"][step])
        turn = np.arctan2(ahead[:, 1], ahead[:, 0]) - moment.heading_rad
        assert np.abs(np.angle(np.exp(1j * turn))).max() < 1e-5
        height = run.frame.rows * run.frame.cell_m
        flat = np.array(told["/map/robots", "Points2D:positions"][step])
        x = flat[:, 0] * run.frame.cell_m + run.frame.origin_x_m
        y = height - flat[:, 1] * run.frame.cell_m + run.frame.origin_y_m
        assert np.column_stack([x, y]) == pytest.approx(moment.place_m, abs=1e-4)
        area = told["/curves/explored_m2", "Scalars:scalars"][step][0]
        assert area == pytest.approx(moment.explored_m2)
    assert told["/cave", "ViewCoordinates:xyz"][None] == [[3, 5, 1]]  # Right, forward, up.
