"""Pictures of worlds need no display and leave no global state."""

from __future__ import annotations

import sys

import numpy as np
import pytest
from PIL import Image

from swarmscout.core.errors import WorldError
from swarmscout.viewing.world_picture import world_figure, world_picture
from swarmscout.worlds import load_world, world_from_array, world_from_ascii


def test_a_picture_of_a_tube(tmp_path, monkeypatch):
    # Another test of the same process may have imported it.
    monkeypatch.delitem(sys.modules, "matplotlib.pyplot", raising=False)
    world = load_world("lava-tube-small", resolution_m=0.25)
    file = world_picture(world, tmp_path / "new" / "w.png", robots=30, dpi=50)
    pixels = np.asarray(Image.open(file).convert("RGB"))
    assert pixels.std() > 30
    assert "matplotlib.pyplot" not in sys.modules
    # Rock is dark, ground is light: about as much of each as in the world.
    dark = (pixels.sum(axis=2) < 200).mean()
    assert 0.3 < dark < 0.9


def test_flat_and_odd_worlds(tmp_path):
    for world in (
        world_from_ascii("S"),
        world_from_array(np.ones((3, 400), dtype=np.uint8), 0.1, origin_m=(-50.0, 1.0)),
        world_from_array(np.ones((3000, 20), dtype=np.uint8), 0.1),
    ):
        assert world_picture(world, tmp_path / "w.png", robots=1, dpi=30).stat().st_size > 500


def test_the_title_says_the_area():
    title = world_figure(world_from_ascii("#S...#")).axes[0].get_title()
    assert title == "ascii · 1 m² reachable · 3 m × 0 m"


def test_what_cannot_be_drawn(tmp_path):
    world = world_from_ascii("S...")
    with pytest.raises(WorldError, match="unknown format 'txt'"):
        world_picture(world, tmp_path / "w.txt")
    (tmp_path / "f").write_text("")
    with pytest.raises(WorldError, match="cannot write"):
        world_picture(world, tmp_path / "f" / "w.png")
