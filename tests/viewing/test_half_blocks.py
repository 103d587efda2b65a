"""The map in a terminal."""

from __future__ import annotations

import io
import os
import pty
import select
import subprocess
import sys

import numpy as np
import pytest
from rich.console import Console

from swarmscout import Mission, Scenario
from swarmscout.viewing.half_blocks import COLOURS, colours_of, half_blocks


def test_a_picture_becomes_half_blocks():
    rng = np.random.default_rng(0)
    pixels = rng.integers(0, 3, (7, 9, 1)) * np.array([80, 40, 20])
    out = io.StringIO()
    console = Console(file=out, force_terminal=True, color_system="truecolor", width=40)
    console.print(half_blocks(pixels.astype(np.uint8)))
    lines = half_blocks(pixels.astype(np.uint8)).plain.splitlines()
    assert lines == ["▀" * 9] * 4
    r, g, b = pixels[0, 0]
    assert f"38;2;{r};{g};{b}" in out.getvalue()


@pytest.mark.parametrize(("width", "height"), [(200, 200), (40, 30), (12, 9)])
def test_the_map_fits_and_shows_the_robots(width, height):
    mission = Mission(Scenario(world="lava-tube-small", robots=9, steps=40, destinations="nearest"))
    for _ in range(30):
        mission.step()
    picture = colours_of(mission, width, height)
    assert picture.shape[0] <= height
    assert picture.shape[1] <= width
    kinds = {tuple(colour) for colour in picture.reshape(-1, 3).tolist()}
    assert kinds <= {tuple(colour) for colour in COLOURS.tolist()}
    assert (255, 93, 79) in kinds  # Somebody explores.
    if (width, height) == (200, 200):
        red = (picture == (255, 93, 79)).all(axis=2).sum()
        exploring = mission.bodies.alive & (mission.minds.mode == 0)
        cells = mission.frame.cells_of(mission.bodies.position[exploring])
        assert red == len(np.unique(cells, axis=0))


def in_a_terminal(words, columns, lines, folder):
    """What a command writes on a terminal of its own."""
    keeper, theirs = pty.openpty()
    settings = {
        **os.environ, "COLUMNS": str(columns), "LINES": str(lines),
        "TERM": "xterm-256color", "COLORTERM": "truecolor",
    }  # fmt: skip
    process = subprocess.Popen(
        [sys.executable, "-m", "swarmscout", *words],
        stdin=theirs, stdout=theirs, stderr=theirs, env=settings, cwd=folder, close_fds=True,
    )  # fmt: skip
    os.close(theirs)
    told = b""
    while True:
        ready, _, _ = select.select([keeper], [], [], 0.2)
        if ready:
            try:
                told += os.read(keeper, 65536)
            except OSError:
                break
        elif process.poll() is not None:
            break
    os.close(keeper)
    assert process.wait() == 0
    return told.decode(errors="replace")


def test_explore_shows_a_map_on_a_terminal_with_room_for_it(tmp_path):
    words = ("explore", "--robots", "40", "--steps", "250", "--no-picture")
    assert "▀" in in_a_terminal(words, 100, 30, tmp_path)
    assert "▀" not in in_a_terminal(words, 100, 12, tmp_path)
