"""World folders: what is written comes back, the same bytes each time, and damage is noticed."""

from __future__ import annotations

import dataclasses
import pickle
from pathlib import Path

import numpy as np
import pytest

from swarmscout.core.errors import WorldError
from swarmscout.worlds import (
    Mesh,
    World,
    load_folder,
    load_world,
    save_world,
    world_from_array,
    world_from_ascii,
)


@pytest.fixture
def world() -> World:
    return load_world("lava-tube-small", resolution_m=0.25)


def contents(folder: Path) -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in sorted(folder.iterdir())}


def same(one: World, two: World) -> None:
    np.testing.assert_array_equal(one.free, two.free)
    for name in ("ground_m", "ceiling_m", "stations_m"):
        a, b = getattr(one, name), getattr(two, name)
        assert (a is None) == (b is None)
        if a is not None:
            assert a.dtype == b.dtype
            np.testing.assert_array_equal(a, b)
    assert (one.name, one.resolution_m, one.origin_m) == (two.name, two.resolution_m, two.origin_m)
    assert one.start_m == two.start_m
    assert one.digest == two.digest


def test_round_trip(tmp_path, world):
    save_world(world, tmp_path / "w")
    for what in (tmp_path / "w", tmp_path / "w" / "world.toml"):
        back = load_world(what)
        same(world, back)
        assert dict(back.source) == dict(world.source)
        assert not back.free.flags.writeable
    small = world_from_ascii("####\n#SC#\n####", name="tïny")
    same(small, load_folder(save_world(small, tmp_path / "a" / "b")))


def test_heights_that_are_mostly_the_same_are_kept_where_they_are_not(tmp_path):
    free = np.zeros((300, 400), dtype=np.uint8)
    free[100:150, 50:120] = 1
    rng = np.random.default_rng(0)
    ground = np.where(free, rng.normal(size=free.shape), -0.1).astype(np.float32)
    ceiling = np.where(free, ground + 2.0, -0.1).astype(np.float32)
    ceiling[0, 399] = 7.0
    given = {"ground_m": ground, "ceiling_m": ceiling}
    world = world_from_array(free, name="hole", **given)
    one = contents(save_world(world, tmp_path / "one"))
    back = load_folder(tmp_path / "one")
    same(world, back)
    assert not back.ground_m.flags.writeable
    assert sum(map(len, one.values())) < 100_000 < 2 * ground.nbytes
    assert contents(save_world(back, tmp_path / "two")) == one
    save_world(world_from_ascii("..."), tmp_path / "one")
    assert sorted(contents(tmp_path / "one")) == ["free.npy", "world.toml"]
    (tmp_path / "two" / "inside.npy").unlink()
    with pytest.raises(WorldError, match=r"inside\.npy"):
        load_folder(tmp_path / "two")


def test_a_mesh_comes_back_and_goes_with_its_world(tmp_path, world):
    vertices = np.array([[0, 0, 0], [1, 0, 0.5], [0, 1, 0], [1, 1, 2]], dtype=np.float32)
    meshed = dataclasses.replace(world, mesh=Mesh(vertices, [[0, 1, 2], [1, 3, 2]]))
    back = load_folder(save_world(meshed, tmp_path))
    same(meshed, back)
    np.testing.assert_array_equal(back.mesh.vertices_m, vertices)
    assert back.mesh.triangles.tolist() == [[0, 1, 2], [1, 3, 2]]
    assert not back.mesh.vertices_m.flags.writeable
    (tmp_path / "triangles.npy").write_bytes(b"something else")
    with pytest.raises(WorldError, match=r"triangles\.npy is not the file that was written"):
        load_folder(tmp_path)
    save_world(world, tmp_path)
    assert load_folder(tmp_path).mesh is None
    assert "vertices.npy" not in contents(tmp_path)


def test_a_mesh_is_checked_and_does_not_change():
    vertices = np.zeros((3, 3), dtype=np.float32)
    mesh = Mesh(vertices, [[0, 1, 2]])
    vertices[:] = 7.0
    assert not mesh.vertices_m.any()
    with pytest.raises(WorldError, match="outside 0 to 2"):
        Mesh(vertices, [[0, 1, 3]])
    with pytest.raises(WorldError, match=r"shape \[3, 2\]"):
        Mesh(vertices[:, :2], [[0, 1, 2]])
    with pytest.raises(WorldError, match="not a finite number"):
        Mesh(vertices * np.nan, [[0, 1, 2]])


def test_the_same_world_gives_the_same_bytes(tmp_path, world):
    one = contents(save_world(world, tmp_path / "one"))
    two = contents(save_world(load_folder(tmp_path / "one"), tmp_path / "two"))
    assert one == two


def test_a_world_replaces_another(tmp_path, world):
    save_world(world, tmp_path)
    small = world_from_ascii("...")
    save_world(small, tmp_path)
    same(small, load_folder(tmp_path))
    assert sorted(contents(tmp_path)) == ["free.npy", "world.toml"]


def test_worlds_travel_to_other_processes(world):
    same(world, pickle.loads(pickle.dumps(world)))


@pytest.mark.parametrize("name", ["free.npy", "ground.npy", "world.toml"])
def test_missing_and_cut_files(tmp_path, world, name):
    save_world(world, tmp_path)
    file = tmp_path / name
    whole = file.read_bytes()
    file.write_bytes(whole[: len(whole) // 2])
    with pytest.raises(WorldError, match="damaged") as caught:
        load_folder(tmp_path)
    assert "\n" not in str(caught.value)
    file.unlink()
    with pytest.raises(WorldError, match=r"damaged|not a world folder"):
        load_folder(tmp_path)


def test_a_flipped_bit_is_noticed(tmp_path, world):
    save_world(world, tmp_path)
    packed = bytearray((tmp_path / "free.npy").read_bytes())
    packed[-1] ^= 1
    (tmp_path / "free.npy").write_bytes(packed)
    with pytest.raises(WorldError, match="not the file that was written"):
        load_folder(tmp_path)


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("format = 1", "format = 9"),
        ("rows = ", "rows = 1000000000000"),
        ("resolution_m = 0.25", "resolution_m = 0.5"),
        ("resolution_m = 0.25", "resolution_m = 'x'"),
        ("digest = ", "digits = "),
        ("columns = ", "columns = 1"),
        ("origin_m = [", "origin_m = [1.0, "),
        ("[rasters]", "[raster]"),
        ("start_m = [", "start_m = ['a', "),
    ],
)
def test_edited_facts(tmp_path, world, old, new):
    file = save_world(world, tmp_path) / "world.toml"
    text = file.read_text()
    assert old in text
    file.write_text(text.replace(old, new))
    with pytest.raises(WorldError) as caught:
        load_folder(tmp_path)
    assert "\n" not in str(caught.value).strip()


def test_no_world_at_all(tmp_path):
    with pytest.raises(WorldError, match="not a world folder"):
        load_world(tmp_path)
