"""One door for every kind of world."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import swarmscout.worlds
from swarmscout.core.errors import WorldError
from swarmscout.worlds import load_world, named_worlds, save_world, world_from_ascii


def test_names():
    lines = named_worlds()
    assert {"lava-tube", "lava-tube-braided", "lava-tube-wide", "lava-maze"} <= set(lines)
    assert all(line and "\n" not in line for line in lines.values())


def test_a_world_is_handed_back():
    world = world_from_ascii("....")
    assert load_world(world) is world
    moved = load_world(world, start_m=(1.0, 0.25), stations_m=[(0.3, 0.2)])
    assert moved.start_m == (1.0, 0.25)
    assert moved.stations_m is not None
    assert moved.stations_m.tolist() == [[0.3, 0.2]]
    assert world.start_m is None


def test_relative_paths_are_tried_from_the_base_first(tmp_path, monkeypatch):
    (tmp_path / "base").mkdir()
    monkeypatch.chdir(tmp_path)
    np.save("w.npy", np.ones((4, 4), dtype=np.uint8))
    np.save("base/w.npy", np.ones((5, 5), dtype=np.uint8))
    assert load_world("w.npy").free.shape == (4, 4)
    assert load_world("w.npy", base=tmp_path / "base").free.shape == (5, 5)
    assert load_world(Path("base") / "w.npy", base=tmp_path / "none").free.shape == (5, 5)


@pytest.mark.parametrize(
    ("what", "options", "says"),
    [
        ("lava-tub", {}, "unknown world 'lava-tub': did you mean 'lava-tube'?"),
        ("moon", {}, "unknown world 'moon': known: lava-maze"),
        ("none/such.png", {}, "does not exist: looked for"),
        ("lava-tube", {"cell_m": 0.5}, "cell_m = 0.5 has no meaning for a generated world"),
        ("lava-tube", {"seed": -1}, "seed = -1"),
        ("lava-tube", {"start_m": (1.0,)}, "start_m = (1.0,)"),
        ("lava-tube-small", {"stations_m": [["a", "b"]]}, "stations_m = "),
    ],
)
def test_what_cannot_be_loaded(what, options, says):
    with pytest.raises(WorldError) as caught:
        load_world(what, **options)
    assert says in str(caught.value)
    assert "\n" not in str(caught.value)


def test_options_without_effect_are_refused(tmp_path):
    world = world_from_ascii("....")
    save_world(world, tmp_path / "w")
    for what in (world, tmp_path / "w"):
        for options in ({"seed": 1}, {"cell_m": 0.5}, {"resolution_m": 0.1}):
            with pytest.raises(WorldError, match="has no meaning"):
                load_world(what, **options)
    np.save(tmp_path / "a.npy", world.free)
    with pytest.raises(WorldError, match="seed = 3 has no meaning for a map"):
        load_world(tmp_path / "a.npy", seed=3)
    (tmp_path / "a.txt").write_text("....")
    with pytest.raises(WorldError, match=r"unknown kind of file '.txt': known are .yaml"):
        load_world(tmp_path / "a.txt")


def test_public_names():
    assert list(swarmscout.worlds.__all__) == sorted(swarmscout.worlds.__all__)
    for name in swarmscout.worlds.__all__:
        assert getattr(swarmscout.worlds, name) is not None
