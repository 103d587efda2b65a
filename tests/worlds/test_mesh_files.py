"""Every kind of mesh file there and back, their tags, and broken ones: one clear line each."""

from __future__ import annotations

import sys

import numpy as np
import pytest
from mesh_shapes import pillar_hall, room, save

from swarmscout.core.errors import WorldError
from swarmscout.worlds import import_mesh, load_world
from swarmscout.worlds.meshes.cleaning import cleaned
from swarmscout.worlds.meshes.files import MESH_SUFFIXES, read_mesh_file


def one_line(says, what, *given, **options):
    with pytest.raises(WorldError) as caught:
        what(*given, **options)
    assert says in str(caught.value), str(caught.value)
    assert "\n" not in str(caught.value)
    assert len(str(caught.value)) < 400


@pytest.mark.parametrize("suffix", MESH_SUFFIXES)
def test_each_kind_of_file(tmp_path, suffix):
    vertices, triangles = pillar_hall()
    if suffix in (".glb", ".gltf"):  # These are y-up by their own rule.
        vertices = np.stack((vertices[:, 0], vertices[:, 2], -vertices[:, 1]), axis=1)
    if suffix == ".gltf":
        import trimesh

        parts = trimesh.Scene(trimesh.Trimesh(vertices, triangles, process=False)).export(
            file_type="gltf"
        )
        for name, packed in parts.items():
            (tmp_path / name).write_bytes(packed)
        file = (tmp_path / "model.gltf").rename(tmp_path / "hall.gltf")
    else:
        file = save((vertices, triangles), tmp_path / f"hall{suffix}")
    world = import_mesh(file)
    assert world.free.sum() == pytest.approx(25200, abs=20)
    assert len(world.mesh.triangles) == len(triangles)
    low, high = world.mesh.bounds_m
    np.testing.assert_allclose(low, [0, 0, 0], atol=1e-6)
    np.testing.assert_allclose(high, [16, 16, 3], atol=1e-6)


def test_parts_of_a_scene_are_put_where_they_stand(tmp_path):
    import trimesh

    scene = trimesh.Scene()
    body = trimesh.creation.box(extents=(1.0, 2.0, 3.0))
    for x in (0.0, 10.0):
        scene.add_geometry(
            body, geom_name="body", transform=trimesh.transformations.translation_matrix((x, 0, 0))
        )
    scene.export(tmp_path / "two.glb")
    read = read_mesh_file(tmp_path / "two.glb")
    assert len(read.triangles) == 24
    assert np.ptp(read.vertices, axis=0).tolist() == [11.0, 2.0, 3.0]


def tagged(tmp_path, axis, meter):
    file = save(pillar_hall(), tmp_path / "hall.dae")
    head, tail = file.read_text().split("<up_axis>")
    tail = tail[tail.index("</up_axis>") :]
    file.write_text(f'{head}<unit name="u" meter="{meter}"/><up_axis>{axis}_UP{tail}')
    return file


def test_tags_are_hints_that_the_geometry_may_overrule(tmp_path):
    # The hall is z-up and 16 long. A wrong axis is seen, and so is a unit that cannot be.
    for axis in "YZ":
        assert import_mesh(tagged(tmp_path, axis, "1.0")).source["up"] == "z"
    assert import_mesh(tagged(tmp_path, "Z", "2.0")).source["scale"] == 2.0
    assert import_mesh(tagged(tmp_path, "Z", "0.0001")).source["scale"] == 1.0
    assert import_mesh(tagged(tmp_path, "Z", "2.0"), scale=1.0).source["scale"] == 1.0


def test_broken_files(tmp_path):
    for suffix in MESH_SUFFIXES:
        for number, packed in enumerate((b"", b"no mesh at all", b"\x00\xff" * 50)):
            file = tmp_path / f"broken{number}{suffix}"
            file.write_bytes(packed)
            one_line(f"broken{number}{suffix}'", import_mesh, file)
    whole = save(room(), tmp_path / "room.ply").read_bytes()
    (tmp_path / "cut.ply").write_bytes(whole[: len(whole) // 2])
    one_line("cut.ply'", import_mesh, tmp_path / "cut.ply")
    (tmp_path / "far.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n")
    one_line("far.obj'", import_mesh, tmp_path / "far.obj")
    one_line("unknown kind of file '.fbx'", import_mesh, tmp_path / "cave.fbx")
    one_line("cannot read the mesh", import_mesh, tmp_path / "none.ply")
    (tmp_path / "folder.ply").mkdir()
    one_line("cannot read the mesh", import_mesh, tmp_path / "folder.ply")


@pytest.mark.parametrize("suffix", MESH_SUFFIXES)
def test_what_is_wrong_with_a_file_is_said_in_plain_words(tmp_path, suffix):
    # Not in those of the library that reads it, as "not enough values to unpack".
    file = tmp_path / f"cave{suffix}"
    file.write_bytes(b"")
    one_line("the file is empty", import_mesh, file)
    file.write_text("this is no mesh\n")
    one_line(f"damaged, cut off, or no {suffix[1:].upper()} file", import_mesh, file)


def test_a_cut_off_stl_is_not_called_empty(tmp_path):
    packed = save(room(), tmp_path / "room.stl").read_bytes()
    (tmp_path / "room.stl").write_bytes(packed[: len(packed) // 2])
    one_line("damaged, cut off", import_mesh, tmp_path / "room.stl")


def test_off_with_polygons(tmp_path):
    # A floor of five corners, ceiling, and sides of four; with a comment and a colour.
    ring = [(0, 0), (8, 0), (8, 8), (4, 10), (0, 8)]
    places = [f"{x} {y} {z}" for z in (0, 3) for x, y in ring]
    sides = [f"4 {i} {i + 5} {(i + 1) % 5 + 5} {(i + 1) % 5}" for i in range(5)]
    lines = ["OFF # polygons", "10 7 0", *places, "5 0 1 2 3 4", "5 9 8 7 6 5 255 0 0", *sides]
    (tmp_path / "hall.off").write_text("\n".join(lines) + "\n")
    world = import_mesh(tmp_path / "hall.off")
    assert np.count_nonzero(world.free) * 0.01 == pytest.approx(72.0, abs=1.0)


def test_points_are_no_surface(tmp_path):
    rows = "\n".join(f"{x} {y} 0" for x in range(5) for y in range(5))
    (tmp_path / "scan.ply").write_text(
        "ply\nformat ascii 1.0\nelement vertex 25\nproperty float x\nproperty float y\n"
        f"property float z\nend_header\n{rows}\n"
    )
    one_line("only 25 points; make a surface", import_mesh, tmp_path / "scan.ply")


def test_a_mesh_is_no_world_yet(tmp_path):
    one_line("swarmscout worlds import", load_world, save(room(), tmp_path / "room.stl"))


def test_without_the_extra_it_says_what_to_install(tmp_path, monkeypatch):
    file = save(room(), tmp_path / "room.ply")
    monkeypatch.setitem(sys.modules, "plyfile", None)
    # The command names the pip of this environment where that pip is not on the path.
    one_line("reading meshes needs an extra: ", import_mesh, file)
    one_line("pip install", import_mesh, file)


def test_cleaning_counts_what_it_takes_out():
    vertices, triangles = room()
    # Each triangle with corners of its own, as STL has it; −0.0 is 0.0.
    alone = vertices[triangles].reshape(-1, 3)
    alone[alone == 0.0] = -0.0
    count = len(triangles)
    own = np.arange(3 * count).reshape(-1, 3)
    far = np.concatenate((alone, vertices, [[np.nan] * 3]))
    doubled = triangles[:, [1, 2, 0]] + 3 * count
    odd = np.array([[0, 0, 1], [0, 1, 3 * count + 8]])
    clean = cleaned(far, np.concatenate((own, doubled, odd)))
    assert (clean.not_finite, clean.degenerate, clean.doubled) == (1, 1, count)
    assert len(clean.vertices) == 8
    assert len(clean.triangles) == count
    corners = {tuple(map(tuple, t)) for t in clean.vertices[clean.triangles].tolist()}
    assert corners == {tuple(map(tuple, t)) for t in vertices[triangles].tolist()}
