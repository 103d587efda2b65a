"""Films have the frames that were asked for, and frames show what the run holds."""

from __future__ import annotations

import subprocess

import numpy as np
import pytest
from PIL import Image

from swarmscout.core.errors import RunError, ViewError
from swarmscout.viewing.film import Film
from swarmscout.viewing.map_image import labels_at
from swarmscout.viewing.overview import Overview
from swarmscout.viewing.palette import DARK, rgb
from swarmscout.viewing.relief import relief_of
from swarmscout.viewing.replay import Replay
from swarmscout.viewing.video import ffmpeg_program, make_video

SMALL = (320, 180)


def test_replay_gives_the_run_forward_and_backward(run):
    replay = Replay(run)
    for step in (0, 7, 60, 30, 31):
        moment = replay.moment(step)
        assert (moment.labels == labels_at(run, step)).all()
        rows = run.steps.filter(run.steps["step"] == step)
        assert (moment.place_m == rows.select("x_m", "y_m").to_numpy()).all()
        assert moment.explored_m2 == run.coverage["explored_m2"][step]
        members = np.concatenate([team.members for team in moment.teams])
        active = np.flatnonzero(rows["alive"].to_numpy() & (rows["mode"] == "EXP").to_numpy())
        assert sorted(members.tolist()) == active.tolist()
        for team in moment.teams:
            assert len(set(rows["team"].to_numpy()[team.members])) == 1
    with pytest.raises(RunError, match="no step 61"):
        replay.moment(61)


def test_an_mp4_has_a_frame_per_step(run, tmp_path):
    seen = []
    file = make_video(
        run, tmp_path / "m.mp4", size=SMALL, on_frame=lambda done, total: seen.append((done, total))
    )
    assert seen[-1] == (61, 61)
    command = [ffmpeg_program(), "-loglevel", "error", "-i", file, "-f", "rawvideo"]
    decoded = subprocess.run(
        [*command, "-pix_fmt", "rgb24", "-"], capture_output=True, check=True
    ).stdout
    shown = np.frombuffer(decoded, np.uint8).reshape(-1, 180, 320, 3)
    assert len(shown) == 61
    film = Film(Replay(run), SMALL)
    for step in (0, 60):
        drawn = np.asarray(film.frame(step))
        assert np.abs(shown[step].astype(int) - drawn).mean() < 6  # As far as H.264 keeps it.
    assert np.abs(shown[0].astype(int) - shown[60]).mean() > 1
    assert [path.name for path in tmp_path.iterdir()] == ["m.mp4"]


@pytest.mark.parametrize("name", ["m.webp", "m.gif"])
def test_animated_pictures(run, tmp_path, name):
    file = make_video(run, tmp_path / name, size=SMALL, every=25, fps=5)
    with Image.open(file) as animation:
        # Steps 0, 25, 50 and the last; a GIF has every second frame, twice as long.
        assert animation.n_frames == (3 if name == "m.gif" else 4)
        assert animation.size == SMALL


@pytest.mark.parametrize(
    ("name", "more", "told"),
    [
        ("m.avi", {}, "ends in .mp4, .webp, .gif"),
        ("m.mp4", {"size": (321, 180)}, "even numbers"),
        ("m.mp4", {"fps": 0.0}, "frames per second"),
        ("m.mp4", {"every": 0}, "choose 1 or more"),
        ("no/m.gif", {}, "cannot write"),
    ],
)
def test_mistakes_end_before_anything_is_drawn(run, tmp_path, name, more, told):
    with pytest.raises((ViewError, RunError), match=told):
        make_video(run, tmp_path / name, **{"size": SMALL, **more})
    assert not list(tmp_path.iterdir())


def test_a_broken_ffmpeg_is_one_line_and_leaves_nothing(run, tmp_path, monkeypatch):
    broken = tmp_path / "ffmpeg"
    broken.write_text("#!/bin/sh\necho no such codec >&2\nexit 3\n")
    broken.chmod(0o755)
    monkeypatch.setenv("SWARMSCOUT_FFMPEG", str(broken))
    with pytest.raises(ViewError, match="cannot make the film: no such codec"):
        make_video(run, tmp_path / "m.mp4", size=SMALL)
    assert [path.name for path in tmp_path.iterdir()] == ["ffmpeg"]


def test_the_overview_lights_what_is_known(run):
    relief = relief_of(run.world())
    labels = labels_at(run, 60)
    view = Overview(relief, relief.frame.extent, 400, 300, run.frame)
    nothing, some = view.picture(labels > 9), view.picture(labels > 0)
    rng = np.random.default_rng(1)
    free = run.frame.centres_of(np.argwhere(labels == 1))
    # Cells in the middle of what is known are seen bright, and nothing else changes.
    pixels = np.rint(view.pixels_of(free[rng.integers(0, len(free), 60)], 0.0)).astype(int)
    inside = ((pixels >= 0) & (pixels < (400, 300))).all(axis=1)
    x, y = pixels[inside].T
    brighter = some.astype(int).sum(axis=2) - nothing.astype(int).sum(axis=2)
    assert np.median(brighter[y, x]) > 100
    assert (brighter >= 0).all()
    assert (brighter == 0).mean() > 0.5


def test_the_overview_hides_what_is_behind(run):
    """Each visible place is seen at the pixel that it projects to."""
    relief = relief_of(run.world())
    view = Overview(relief, relief.frame.extent, 240, 180, run.frame)
    _, _, x_m, y_m = view._render(DARK, DARK.background)
    seen = np.argwhere(~np.isnan(x_m))
    places = np.column_stack([x_m[~np.isnan(x_m)], y_m[~np.isnan(x_m)]])
    height = relief.height_m()
    cells = relief.frame.cells_of(places)
    z = height[cells[:, 0].clip(0, height.shape[0] - 1), cells[:, 1].clip(0, height.shape[1] - 1)]
    pixels = view._pixels(places, z)
    off = np.abs(pixels - seen[:, ::-1] - 0.25)
    assert np.median(off) < 1.0
    assert np.quantile(off[:, 0], 0.99) < 1.0


def test_a_gif_is_small_and_keeps_the_colours_of_the_signs(run, tmp_path):
    file = make_video(run, tmp_path / "m.gif", size=(640, 360))
    assert file.stat().st_size < 800_000
    film = Film(Replay(run), (640, 360))
    with Image.open(file) as animation:
        assert animation.n_frames == 31
        assert animation.info["duration"] in (60, 70)
        colours = set()
        for index, step in ((15, 30), (30, 60)):
            animation.seek(index)
            shown = np.asarray(animation.convert("RGB")).astype(int)
            colours |= {tuple(colour) for colour in np.unique(shown.reshape(-1, 3), axis=0)}
            drawn = np.asarray(film.frame(step)).astype(int)
            assert np.abs(shown - drawn).mean() < 3
            for colour in (DARK.frontier, DARK.free, DARK.background):
                same = (drawn == rgb(colour)).all(axis=2)
                assert same.any()
                assert (shown[same] == rgb(colour)).all()
            red = (drawn[..., 0] > 200) & (drawn[..., 1:].max(axis=2) < 150)  # Robots.
            assert red.any()
            assert np.abs(shown - drawn)[red].mean() < 15
        assert len(colours) <= 240  # One palette for all frames: nothing flickers.
