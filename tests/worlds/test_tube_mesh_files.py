"""Meshes in files, in world folders and on the command line."""

from __future__ import annotations

import os

import numpy as np
import pytest
import trimesh
from PIL import Image

from swarmscout.core.errors import ViewError, WorldError
from swarmscout.viewing.mesh_picture import mesh_picture
from swarmscout.worlds import Mesh, TubeParameters, load_world, tube_mesh, write_mesh
from swarmscout.worlds.meshes import files, writing

TINY = TubeParameters(size_m=32.0, length_m=25.0, width_m=5.0, braids=0, branches=0, piles=3)
WORDS = (
    "generate", "mine", "--like", "lava-tube-small", "--size", "32", "--length", "25",
    "--branches", "0", "--robots", "5",
)  # fmt: skip


@pytest.fixture(scope="module")
def tiny() -> Mesh:
    return tube_mesh(TINY, mesh_resolution_m=0.3)


@pytest.mark.parametrize("suffix", writing.MESH_SUFFIXES)
def test_other_programs_read_the_same_closed_mesh(tiny, tmp_path, suffix):
    file = write_mesh(tiny, tmp_path / f"cave{suffix}")
    read = trimesh.load_mesh(file)
    low, high = tiny.bounds_m
    if suffix == ".glb":  # There y is up, and z points to the viewer.
        low, high = (
            np.array([low[0], low[2], -high[1]]),
            np.array([high[0], high[2], -low[1]]),
        )
    np.testing.assert_allclose(read.bounds, [low, high], atol=1e-4)
    assert len(read.faces) == len(tiny.triangles)
    read.merge_vertices()
    assert read.is_watertight


def test_what_cannot_be_written_is_said_before_the_work(tiny, tmp_path):
    (tmp_path / "there.ply").write_text("mine")
    for name, says in (
        ("there.ply", "there.ply' exists"),
        ("cave.max", "unknown kind of file '.max': known are .ply, .obj"),
        ("cave", "unknown kind of file ''"),
        ("missing/cave.ply", "there is no folder"),
    ):
        with pytest.raises(WorldError, match=says):
            write_mesh(tiny, tmp_path / name)
    assert (tmp_path / "there.ply").read_text() == "mine"


@pytest.mark.skipif(os.geteuid() == 0, reason="root may write anywhere")
def test_a_closed_folder(tiny, tmp_path):
    tmp_path.chmod(0o500)
    with pytest.raises(WorldError, match="no permission"):
        write_mesh(tiny, tmp_path / "cave.ply")


def test_a_full_disk_leaves_no_half_a_file(tiny, tmp_path, monkeypatch):
    class Full(type(tmp_path)):
        def open(self, *args, **kwargs):
            super().open(*args, **kwargs).close()
            raise OSError(28, "No space left on device")

    monkeypatch.setattr(writing, "check_mesh_file", lambda path: Full(path))
    with pytest.raises(WorldError, match="No space left"):
        write_mesh(tiny, tmp_path / "cave.ply")
    assert not (tmp_path / "cave.ply").exists()


def test_without_the_extra_it_says_how_to_get_it(tiny, tmp_path, monkeypatch):
    monkeypatch.setattr(files, "find_spec", lambda package: None)
    with pytest.raises(WorldError, match=r"pip install -e '\.\[mesh\]'"):
        write_mesh(tiny, tmp_path / "cave.ply")


def test_generate_with_a_mesh(command, tmp_path):
    told = command(*WORDS, "--mesh", "cave.ply", "--skylights", "1", "--mesh-resolution", "0.3")
    assert "making the mesh" in told
    assert "mesh: cave.ply, " in told
    world = load_world(tmp_path / "mine")
    assert world.mesh is not None
    assert world.source["skylights"] == 1
    file = trimesh.load_mesh(tmp_path / "cave.ply", process=False)
    np.testing.assert_array_equal(file.faces, world.mesh.triangles)
    np.testing.assert_array_equal(file.vertices.astype(np.float32), world.mesh.vertices_m)
    picture = Image.open(tmp_path / "mine" / "mesh.png").convert("RGB")
    colours = np.asarray(picture).reshape(-1, 3)
    assert len(np.unique(colours[::7], axis=0)) > 60


def test_the_world_beside_a_mesh_is_the_world_without_one(command, tmp_path):
    command(*WORDS, "--out", "without")
    command(*WORDS, "--out", "with", "--mesh", "cave.stl", "--mesh-resolution", "0.4")
    for name in ("free.npy", "ground.npy", "ceiling.npy"):
        same = [(tmp_path / folder / name).read_bytes() for folder in ("with", "without")]
        assert same[0] == same[1]


@pytest.mark.parametrize(
    ("words", "says"),
    [
        (("--skylights", "2"), "--skylights has no meaning without --mesh"),
        (("--mesh-resolution", "0.2"), "--mesh-resolution has no meaning without --mesh"),
        (("--mesh", "cave.txt"), "unknown kind of file '.txt'"),
        (("--mesh", "there.ply"), "'there.ply' exists"),
        (("--mesh", "cave.ply", "--mesh-resolution", "9"), "expected 0.05 to 0.5"),
        (("--mesh", "cave.ply", "--out", "."), "'.' exists and is not empty"),
    ],
)
def test_generate_refuses_before_the_work(command, tmp_path, words, says):
    (tmp_path / "there.ply").write_text("mine")
    with pytest.raises(WorldError) as caught:
        command(*WORDS, *words)
    assert says in str(caught.value)
    assert [path.name for path in tmp_path.iterdir()] == ["there.ply"]


def test_a_picture_needs_a_mesh(tmp_path):
    with pytest.raises(ViewError, match="has no mesh to draw"):
        mesh_picture(load_world("lava-tube-small", resolution_m=0.25), tmp_path / "no.png")
