"""``swarmscout worlds``: list, show, generate, import."""

from __future__ import annotations

import subprocess
import sys

import numpy as np
import pytest
from PIL import Image

from swarmscout.core.errors import WorldError
from swarmscout.worlds import load_world


def test_list(command):
    assert "lava-tube-braided  " in command("list")


def test_show(command, tmp_path):
    told = command("show", "lava-tube-small", "--seed", "2", "--resolution", "0.25")
    assert "reachable from the start" in told
    assert (tmp_path / "lava-tube-small-2.png").stat().st_size > 10_000


def test_show_never_draws_over_the_map(command, tmp_path):
    free = np.zeros((60, 60), dtype=np.uint8)
    free[5:55, 5:55] = 255
    for name in ("my map.png", "plan.pgm"):
        Image.fromarray(free).save(tmp_path / name)
    (tmp_path / "plan.yaml").write_text(
        "image: plan.pgm\nresolution: 0.1\norigin: [0, 0, 0]\nnegate: 0\n"
        "occupied_thresh: 0.65\nfree_thresh: 0.2\n"
    )
    before = {path.name: path.read_bytes() for path in tmp_path.iterdir()}
    assert "picture: my map-world.png" in command("show", "my map.png", "--robots", "3")
    assert "picture: plan-world.png" in command("show", "plan.yaml", "--robots", "3")
    for map_, out in (("my map.png", "my map.png"), ("plan.yaml", "plan.pgm")):
        with pytest.raises(WorldError, match="is the map itself"):
            command("show", map_, "--out", out)
    assert before == {name: (tmp_path / name).read_bytes() for name in before}


@pytest.mark.parametrize("words", [("show", "lava-tube-small"), ("generate", "x")])
@pytest.mark.parametrize("robots", ["-1", "0", "1000000000000"])
def test_impossible_numbers_of_robots(command, words, robots):
    with pytest.raises(WorldError, match="--robots"):
        command(*words, "--robots", robots)


def test_generate(command, tmp_path):
    told = command(
        "generate", "mine", "--like", "lava-tube-small", "--seed", "4", "--branches", "1",
        "--resolution", "0.25", "--out", "made",
    )  # fmt: skip
    assert "world: made" in told
    world = load_world(tmp_path / "made")
    assert world.name == "mine"
    assert world.source["branches"] == 1
    assert world.source["seed"] == 4
    assert (tmp_path / "made" / "world.png").exists()
    with pytest.raises(WorldError, match="is there already"):
        command("generate", "--out", "made")


def test_import(command, tmp_path):
    np.save("plan.npy", np.ones((40, 60), dtype=np.uint8))
    told = command(
        "import", "plan.npy", "--metres-per-cell", "0.1", "--start", "1,1", "--station", "2,2",
        "--station=3,1.5", "--robots", "5",
    )  # fmt: skip
    assert "free: 24.0 m², reachable from the start: 24.0 m²" in told
    world = load_world(tmp_path / "plan")
    assert world.start_m == (1.0, 1.0)
    assert world.stations_m is not None
    assert world.stations_m.tolist() == [[2.0, 2.0], [3.0, 1.5]]


def test_import_of_what_no_mission_can_use_writes_nothing(command, tmp_path):
    np.save("plan.npy", np.ones((40, 60), dtype=np.uint8))
    with pytest.raises(WorldError, match=r"station 0 .* lies outside"):
        command("import", "plan.npy", "--station", "99,2", "--out", "w")
    with pytest.raises(WorldError, match="--start 'here': expected X,Y"):
        command("import", "plan.npy", "--start", "here")
    with pytest.raises(WorldError, match="no named world: did you mean 'lava-tube'"):
        command("generate", "--like", "lava-tub")
    assert not (tmp_path / "w").exists()


def test_help_imports_nothing_heavy():
    code = (
        "import sys, swarmscout.cli.worlds as w\n"
        "w.app(['generate', '--help'], result_action='return_value')\n"
        "assert not {'numpy', 'numba', 'scipy', 'matplotlib'} & set(sys.modules)\n"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert "--branch-length" in done.stdout
