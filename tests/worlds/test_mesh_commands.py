"""``swarmscout worlds import`` of a mesh, as it is typed; and a mission in what it made."""

from __future__ import annotations

import os

import pytest
from mesh_shapes import pillar_hall, room, save

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
        "start: 2.00,2.00,0.00 m (as asked)",
        "world: hall",
    ):
        assert line in told
    assert (tmp_path / "hall" / "world.png").exists()
    world = load_world("hall")
    assert world.stations_m.tolist() == [[3.0, 3.0]]
    assert world.mesh is not None
    run = ss.explore(world="hall", robots=8, steps=40, seed=1)
    assert run.coverage["explored_m2"][-1] > 20.0
    with pytest.raises(WorldError, match="is there already"):
        command("import", "hall.ply")


def test_options_for_meshes_reach_the_importer(command, tmp_path):
    vertices, triangles = room()
    file = save((vertices[:, [0, 2, 1]] * 1000.0 * [1, 1, -1], triangles), tmp_path / "room.obj")
    told = command(
        "import", file.name, "--up", "y", "--scale", "0.001", "--no-roof", "--resolution", "0.2",
        "--step-height", "0.1", "--start", "2,2,0", "--out", "made",
    )  # fmt: skip
    assert "start: 2.00,2.00,0.00 m (as asked)" in told
    source = load_world("made").source
    expected = {"up": "y", "scale": 0.001, "roof": False, "resolution_m": 0.2}
    assert {key: source[key] for key in expected} == expected


@pytest.mark.parametrize(
    ("words", "says"),
    [
        (("plan.npy", "--up", "z"), "is no mesh: --up has no meaning"),
        (("plan.npy", "--scale", "2"), "is no mesh: --scale has no meaning"),
        (("plan.npy", "--no-roof"), "is no mesh: --roof has no meaning"),
        (("plan.npy", "--step-height", "0.1"), "is no mesh: --step-height has no meaning"),
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
    with pytest.raises(WorldError, match=r"cannot make the folder .* no folder to write into"):
        command("import", "room.ply", "--out", out)
    assert "reading" not in capsys.readouterr().out
