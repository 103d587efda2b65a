"""``swarmscout worlds import`` of a mesh, as it is typed; and a mission in what it made."""

from __future__ import annotations

import os
import time

import pytest
from mesh_shapes import box, joined, pillar_hall, room, save, sheet

import swarmscout as ss
from swarmscout.core.errors import WorldError
from swarmscout.worlds import load_world


def test_import_tells_what_it_decided_and_found(command, tmp_path):
    save(pillar_hall(), tmp_path / "hall.ply")
    told = command("import", "hall.ply", "--start", "2,2", "--station", "3,3", "--robots", "8")
    for line in (
        "cutting columns …",
        "mesh: hall.ply, 16.0 × 16.0 × 3.0 m, 60 triangles",
        "up axis: z (",
        "roof: yes (",
        "floor: 256 m², of which free: 252 m²",
        "left out: 4 m² not connected with the start",
        "start: 2.00,2.00,0.00 m (as given)",
        "world: hall",
    ):
        assert line in told
    assert (tmp_path / "hall" / "world.png").exists()
    world = load_world("hall")
    assert world.stations_m.tolist() == [[3.0, 3.0]]
    assert world.mesh is not None
    run = ss.explore(world="hall", robots=8, steps=40, seed=1)
    assert run.coverage["explored_m2"][-1] > 20.0
    with pytest.raises(WorldError, match="exists and is not empty"):
        command("import", "hall.ply")


def test_options_for_meshes_reach_the_importer(command, tmp_path):
    vertices, triangles = room()
    file = save((vertices[:, [0, 2, 1]] * 1000.0 * [1, 1, -1], triangles), tmp_path / "room.obj")
    told = command(
        "import", file.name, "--up", "y", "--scale", "0.001", "--no-roof", "--resolution", "0.2",
        "--step-height", "0.1", "--start", "2,2,0", "--out", "made",
    )  # fmt: skip
    assert "start: 2.00,2.00,0.00 m (as given)" in told
    source = load_world("made").source
    expected = {"up": "y", "scale": 0.001, "roof": False, "resolution_m": 0.2}
    assert {key: source[key] for key in expected} == expected


@pytest.mark.parametrize(
    ("words", "says"),
    [
        (("plan.npy", "--up", "z"), "is not a mesh: --up has no meaning"),
        (("plan.npy", "--scale", "2"), "is not a mesh: --scale has no meaning"),
        (("plan.npy", "--no-roof"), "is not a mesh: --roof has no meaning"),
        (("plan.npy", "--step-height", "0.1"), "is not a mesh: --step-height has no meaning"),
        (("plan.npy", "--start", "1,2,3"), "--start '1,2,3': expected X,Y in metres"),
        (("room.ply", "--metres-per-cell", "1"), "is a mesh .use --scale.: --metres-per-cell"),
        (("room.ply", "--start", "1"), "--start '1': expected X,Y or X,Y,Z"),
        (("room.ply", "--start", "1,2,3,4"), "expected X,Y or X,Y,Z"),
        (("room.ply", "--robots", "0"), "--robots 0"),
        (("room.ply", "--station", "77,2"), "station 0 .* lies outside"),
        (("none.ply",), "mesh 'none.ply' does not exist"),
        (("folder.ply",), "cannot read the mesh 'folder.ply': Is a directory"),
    ],
)
def test_what_makes_no_sense_is_one_line_and_writes_nothing(command, tmp_path, words, says):
    save(room(), tmp_path / "room.ply")
    (tmp_path / "folder.ply").mkdir()
    with pytest.raises(WorldError, match=says) as caught:
        command("import", *words, "--out", "made")
    assert "\n" not in str(caught.value)
    assert not (tmp_path / "made").exists()


@pytest.mark.parametrize("out", ["a_file/made", "/proc/version/made", "readonly/made"])
def test_a_folder_that_cannot_be_made_is_told_before_the_work(
    command, tmp_path, monkeypatch, capsys, out
):
    save(room(), tmp_path / "room.ply")
    (tmp_path / "a_file").touch()
    (tmp_path / "readonly").mkdir()
    may_write = os.access
    monkeypatch.setattr(  # Root may write everywhere.
        os, "access", lambda path, mode: "readonly" not in str(path) and may_write(path, mode)
    )
    with pytest.raises(
        WorldError, match=r"cannot make the folder .* is not a folder to write into"
    ):
        command("import", "room.ply", "--out", out)
    assert "reading" not in capsys.readouterr().out


def test_a_building_without_a_floor(command, tmp_path):
    # Four hollow walls, 0.5 m thick, round a yard of 11 m × 7 m.
    sides = [(0, 12, 0, 0.5), (0, 12, 7.5, 8), (0, 0.5, 0.5, 7.5), (11.5, 12, 0.5, 7.5)]
    walls = joined(*[box(*side, 0.0, 2.0) for side in sides])
    save(walls, tmp_path / "yard.stl")
    with pytest.raises(WorldError, match=r"no floor but inside its walls.*--ground-plane"):
        command("import", "yard.stl")
    assert not (tmp_path / "yard").exists()
    for number, words in enumerate((["--ground-plane"], ["--ground", "0"])):
        out = command("import", "yard.stl", *words, "--robots", "5", "--out", f"w{number}")
        assert "of which free: 77 m²" in out
    # Under a roof of its own, and above sea level.
    roofed = joined(walls, box(0, 12, 0, 8, 2.0, 2.2))
    save((roofed[0] - (0, 0, 5.0), roofed[1]), tmp_path / "hall.stl")
    assert "if it is the top of a roof" in command("import", "hall.stl", "--out", "roof")
    out = command("import", "hall.stl", "--ground", "-5", "--robots", "5", "--out", "hall")
    assert "of which free: 77 m²" in out
    with pytest.raises(WorldError, match="exclude each other"):
        command("import", "yard.stl", "--ground", "0", "--ground-plane")
    (tmp_path / "m.map").write_text("type octile\nheight 1\nwidth 1\nmap\n.\n")
    with pytest.raises(WorldError, match="--ground-plane has no meaning"):
        command("import", "m.map", "--ground-plane")


def test_stacked_floors_are_refused_quickly(command, tmp_path):
    save(joined(*[sheet(0, 12, 0, 8, 0.5 * k, 1) for k in range(5000)]), tmp_path / "stack.ply")
    began = time.process_time()
    with pytest.raises(WorldError, match="lie one above the other") as caught:
        command("import", "stack.ply")
    assert "stack.ply" in str(caught.value)
    assert time.process_time() - began < 10.0  # Most of it is compiling.
