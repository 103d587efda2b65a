from __future__ import annotations

import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

from swarmscout import Mission, Run, RunError, RunWriter, Scenario, map_picture, record_mission
from swarmscout.viewing.map_image import frontier_cells, labels_at
from swarmscout.viewing.map_picture import map_figure


def test_labels_and_frontiers_are_the_mission_s(finished: Run, tape: Any) -> None:
    labels = labels_at(finished)
    np.testing.assert_array_equal(labels, tape.mission.map.labels)
    np.testing.assert_array_equal(np.argwhere(frontier_cells(labels)), tape.mission.map.frontiers())


def test_four_neighbours_make_fewer_frontiers(scenario: Scenario) -> None:
    four = scenario.model_copy(
        update={"map": scenario.map.model_copy(update={"frontier_neighbours": 4}), "steps": 30}
    )
    mission = Mission(four)
    mission.run()
    labels = mission.map.labels
    np.testing.assert_array_equal(np.argwhere(frontier_cells(labels, 4)), mission.map.frontiers())
    assert frontier_cells(labels, 4).sum() < frontier_cells(labels, 8).sum()


def _share(file: Path, colour: tuple[int, int, int]) -> float:
    """Share of a picture's pixels that have nearly a colour."""
    with Image.open(file) as picture:
        pixels = np.asarray(picture.convert("RGB"), dtype=np.int64)
    return float((np.abs(pixels - np.array(colour)).max(axis=-1) <= 6).mean())


def test_the_picture_has_the_paper_s_colours(finished: Run, tmp_path: Path) -> None:
    file = map_picture(finished, tmp_path / "map.png")
    assert file.stat().st_size < 300_000
    for colour, least in (
        ((158, 158, 158), 0.1),  # unknown
        ((255, 255, 255), 0.05),  # free
        ((0, 0, 0), 0.001),  # occupied
        ((92, 212, 92), 0.005),  # frontier
        ((227, 33, 28), 0.0002),  # a robot in EXP mode
        ((138, 43, 226), 0.0001),  # round a destination
    ):
        assert _share(file, colour) > least, colour


def test_the_legend_names_every_colour_and_lies_below_the_map(finished: Run) -> None:
    figure = map_figure(finished)
    figure.canvas.draw()
    (axes,), (legend,) = figure.axes, figure.legends
    said = [text.get_text() for text in legend.get_texts()]
    assert said[:4] == ["unknown", "free", "wall", "frontier"]
    assert {"charging station", "destination", "robot (EXP)"} <= set(said)
    assert legend.get_window_extent().y1 <= axes.get_tightbbox().y0
    title = axes.get_title()
    for word in ("lava-tube", "6 robots", "nearest", "m² explored"):
        assert word in title


def test_white_grows_with_the_steps(finished: Run, tmp_path: Path) -> None:
    early = labels_at(finished, 10)
    assert (early == 1).sum() < (labels_at(finished) == 1).sum()
    for step in (0, 10):
        assert map_picture(finished, tmp_path / f"{step}.png", step).exists()
    with pytest.raises(RunError, match="made of a Run, not of a str"):
        map_picture("runs/x", tmp_path / "x.png")  # type: ignore[arg-type]
    with pytest.raises(RunError, match="no step 999"):
        map_picture(finished, tmp_path / "999.png", 999)
    with pytest.raises(RunError, match="cannot write"):
        map_picture(finished, tmp_path / "missing" / "map.png")


@pytest.mark.parametrize("level", ["curves", "summary"])
def test_a_run_without_steps_shows_its_last_map(
    level: str, scenario: Scenario, tmp_path: Path
) -> None:
    run = record_mission(scenario, record=level)
    assert map_picture(run, tmp_path / "map.png").exists()
    assert _share(tmp_path / "map.png", (227, 33, 28)) == 0.0
    with pytest.raises(RunError, match="was not recorded"):
        map_picture(run, tmp_path / "map.png", step=3)


def test_a_killed_run_has_a_picture(tape: Any, empty: Path, tmp_path: Path) -> None:
    tape.play(RunWriter(empty), until=60, end=False)
    assert map_picture(Run.open(empty), tmp_path / "map.png").exists()


def test_no_pyplot_and_no_display(finished: Run, tmp_path: Path) -> None:
    program = (
        "import sys, swarmscout; "
        "swarmscout.map_picture(swarmscout.Run.open(sys.argv[1]), sys.argv[2]); "
        "assert 'matplotlib.pyplot' not in sys.modules"
    )
    words = [sys.executable, "-c", program, str(finished.path), str(tmp_path / "map.png")]
    subprocess.run(words, check=True)
