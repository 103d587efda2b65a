"""Figures are drawn, in every form, of what the run holds."""

from __future__ import annotations

import numpy as np
import pytest
from PIL import Image

from swarmscout import Mission, explore
from swarmscout.core.errors import RunError, ViewError
from swarmscout.viewing.mission_figures.catalogue import MISSION_FIGURES, make_figures
from swarmscout.viewing.mission_figures.maps import explored_area, growing_map, team_map
from swarmscout.viewing.mission_figures.sensor import Scans
from swarmscout.viewing.replay import Replay


def test_all_figures_are_drawn(run, tmp_path):
    files = make_figures(run, tmp_path / "new" / "folder", dpi=60)
    assert [file.stem for file in files] == list(MISSION_FIGURES)
    for file in files:
        with Image.open(file) as picture:
            pixels = np.asarray(picture.convert("RGB"))
            assert min(pixels.shape[:2]) > 100
            assert len(np.unique(pixels.reshape(-1, 3), axis=0)) > 20


@pytest.mark.parametrize(("form", "begin"), [("svg", b"<?xml"), ("pdf", b"%PDF")])
def test_the_same_run_gives_the_same_bytes(run, tmp_path, form, begin):
    names = ("explored-area", "team-map")
    both = [make_figures(run, tmp_path / k, names=names, form=form, step=40) for k in "ab"]
    for one, other in zip(*both, strict=True):
        assert one.read_bytes().startswith(begin)
        assert one.read_bytes() == other.read_bytes()


def test_rays_are_those_of_the_mission(run):
    mission = Mission(run.scenario)
    scans, kept = Scans(Replay(run)), []
    for step in range(1, 56):  # Over the end of a block of noise.
        mission.step()
        if step in (1, 20, 50, 55):
            ranges = scans.at(step)[0].ranges
            assert (ranges == mission.sensing.last.ranges).all()
            kept.append((ranges, ranges.copy()))
    for ranges, copy in kept:  # A later scan does not change an earlier one.
        assert (ranges == copy).all()


def test_figures_show_the_run(run):
    replay = Replay(run)
    figure = team_map(replay, 60)
    axes = figure.axes[0]
    moment = replay.moment(60)
    drawn = {line.get_label(): line.get_xydata() for line in axes.lines}
    exploring = moment.alive & ~moment.charging
    assert (drawn["robot (EXP)"] == moment.place_m[exploring]).all()
    assert (drawn["charging station"] == run.stations_m).all()
    circled = [team for team in moment.teams if len(team.members) > 1]
    assert len(axes.patches) == len(circled) > 0
    assert len(drawn["leader"]) == len(circled)

    titles = [axes.get_title() for axes in growing_map(replay, 60).axes]
    assert [title.split(" · ")[0] for title in titles] == [
        "step 6",
        "step 24",
        "step 42",
        "step 60",
    ]
    (line,) = explored_area(replay, 60).axes[0].lines
    assert (line.get_ydata() == run.coverage["explored_m2"].to_numpy()).all()


def test_a_robot_that_charges_is_named(tmp_path):
    run = explore(
        "lava-tube-small",
        robots=4,
        steps=30,
        seed=1,
        battery={"charge_below": 1.0, "return_rule": "threshold"},
    )
    axes = team_map(Replay(run), 20).axes[0]
    assert [text.get_text() for text in axes.texts] == ["charging"]


@pytest.mark.parametrize(
    ("more", "told"),
    [
        ({"names": ["team-mop"]}, "did you mean 'team-map'"),
        ({"form": "bmp"}, "cannot be written as 'bmp'"),
        ({"step": 61}, "holds steps 0 to 60"),
        ({"step": 0, "names": ["sensor-fan"]}, "do not measure in step 0"),
        ({"dpi": 5}, "choose 30 to 1200"),
    ],
)
def test_mistakes_are_one_clear_line(run, tmp_path, more, told):
    with pytest.raises((ViewError, RunError), match=told):
        make_figures(run, tmp_path, **more)
