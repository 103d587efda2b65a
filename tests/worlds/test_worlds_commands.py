"""``swarmscout worlds``: list, show, generate, import."""

from __future__ import annotations

import re
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
    with pytest.raises(WorldError, match="exists and is not empty"):
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
    with pytest.raises(WorldError, match="is not a named world: did you mean 'lava-tube'"):
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


@pytest.mark.parametrize("form", ["{0} {1}", "{0}={1}"])
def test_coordinates_may_be_negative(command, tmp_path, form):
    np.save(tmp_path / "m.npy", np.ones((40, 40), dtype=bool))
    Image.fromarray(np.full((80, 80), 254, dtype=np.uint8)).save(tmp_path / "m.pgm")
    keys = "resolution: 0.1\norigin: [-4, -4, 0]\nnegate: 0\noccupied_thresh: 0.65\n"
    (tmp_path / "m.yaml").write_text(f"image: m.pgm\n{keys}free_thresh: 0.25\n")
    words = " ".join(
        form.format(*option)
        for option in (("--start", "-1.5,-0.5"), ("--station", "-1,0"), ("--station", "-.5,-2e0"))
    )
    out = command("import", "m.yaml", *words.split(), "--robots", "3", "--out", "w")
    assert "start: -1.50,-0.50 m" in out
    world = load_world(tmp_path / "w")
    assert world.start_m == (-1.5, -0.5)
    assert world.stations_m.tolist() == [[-1.0, 0.0], [-0.5, -2.0]]


def test_a_start_inside_is_proposed_with_a_picture(command, tmp_path):
    plan = np.full((200, 300), 255, dtype=np.uint8)
    plan[40:160, 60:240] = 0
    plan[42:158, 62:238] = 255
    Image.fromarray(plan).save(tmp_path / "plan.png")
    out = command("import", "plan.png", "--robots", "3", "--out", "w")
    hint = re.search(r"(\d+) m² lie inside: --start (\S+) starts there", out)
    assert int(hint[1]) == pytest.approx(11.6 * 17.6, abs=1)
    assert (tmp_path / "w" / "inside.png").exists()
    again = command("import", "plan.png", "--start", hint[2], "--robots", "3", "--out", "v")
    assert "reachable from the start: 204." in again
    assert "hint" not in again
    out = command("show", "plan.png")
    assert "picture: plan-world-inside.png" in out


def test_arrays_and_images_with_the_other_meaning(command, tmp_path):
    occupied = np.ones((60, 80), dtype=np.uint8)
    occupied[10:30, 10:70] = 0
    np.save(tmp_path / "m.npy", occupied)
    out = command("import", "m.npy", "--robots", "1", "--out", "a")
    assert "hint: what is free (36.0 m²) surrounds all else: here 1 is free" in out
    assert "--free 0 gives 12.0 m²" in out
    for number, words in enumerate((["--free", "0"], ["--occupied", "1"], ["--free=-1..0"])):
        out = command("import", "m.npy", *words, "--robots", "1", "--out", f"b{number}")
        assert "free: 12.0 m²" in out
        assert "hint" not in out
    # Walls are thin lines, and no robot fits into them.
    walls = np.full((80, 120), 0, dtype=np.uint8)
    walls[::40], walls[:, ::40], walls[-1], walls[:, -1] = 255, 255, 255, 255
    Image.fromarray(walls).save(tmp_path / "walls.png")
    with pytest.raises(WorldError, match=r"no robot of 0\.3 m fits.*--free 0\.\.100 gives"):
        command("import", "walls.png")
    assert "hint" not in command("import", "walls.png", "--free", "0..100", "--out", "c")
    with pytest.raises(WorldError, match="free = 0 has no meaning for"):
        command("show", "lava-tube", "--free", "0")


def test_paths_with_a_home(command, tmp_path, monkeypatch):
    monkeypatch.setenv("HOME", str(tmp_path / "home"))
    (tmp_path / "home").mkdir()
    np.save(tmp_path / "home" / "m.npy", np.ones((40, 40), dtype=bool))
    command("import", "~/m.npy", "--out=~/w", "--robots", "2")
    assert (tmp_path / "home" / "w" / "world.toml").exists()
    command("show", "$HOME/m.npy", "--out=$HOME/p.png", "--robots", "2")
    assert (tmp_path / "home" / "p.png").exists()
    assert not (tmp_path / "~").exists()


def test_a_world_reader(command, tmp_path):
    (tmp_path / "my.py").write_text(
        "import numpy as np\nfrom swarmscout.worlds import world_from_array\n"
        "class Square:\n    suffixes = ()\n    def read(self, path, seed):\n"
        "        return world_from_array(np.ones((40, 40 + seed), dtype=bool), name='square')\n"
    )
    assert "4.0 m x 4.0 m" in command("show", "my.py:Square", "--robots", "2", "--out", "p.png")
    assert "4.5 m x 4.0 m" in command("import", "my.py:Square", "--seed", "5", "--robots", "2")
    assert load_world(tmp_path / "square").free.shape == (40, 45)
