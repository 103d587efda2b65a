"""Maps made by hand, cell by cell; and broken ones of every kind: one clear line each."""

from __future__ import annotations

import os
import time
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from PIL import Image
from scipy import ndimage

from swarmscout.core.errors import WorldError
from swarmscout.worlds import load_world, save_world, world_from_array, world_from_ascii
from swarmscout.worlds.resampling import refined, resampled
from swarmscout.worlds.world import World

NAV2 = {
    "image": "map.pgm", "resolution": 0.05, "origin": "[-1.0, 2.0, 0.0]", "negate": 0,
    "occupied_thresh": 0.65, "free_thresh": 0.25,
}  # fmt: skip
OCTILE = "type octile\nheight 2\nwidth 3\nmap\n.G@\nSTO\n"


def nav2(folder: Path, pixels: object, image: str = "map.pgm", **keys: object) -> Path:
    """Write a nav2 map; a key that is None is left out."""
    Image.fromarray(np.array(pixels, dtype=np.uint8)).save(folder / image)
    given_keys = {**NAV2, "image": image, **keys}
    lines = [f"{key}: {value}" for key, value in given_keys.items() if value is not None]
    file = folder / "map.yaml"
    file.write_text("\n".join(lines))
    return file


@pytest.mark.parametrize("image", ["map.pgm", "map.png"])
def test_nav2_trinary(tmp_path, image):
    # Top row: free, unknown (205), occupied; bottom row: barely free (192 of 255), not, occupied.
    world = load_world(nav2(tmp_path, [[254, 205, 0], [192, 191, 90]], image))
    # 205 is what map savers paint unknown in, although it is below free_thresh 0.25 (0.196).
    np.testing.assert_array_equal(world.free, [[1, 0, 0], [1, 0, 0]])
    assert world.resolution_m == 0.05
    assert world.origin_m == (-1.0, 2.0)
    assert world.extent == pytest.approx((-1.0, -0.85, 2.0, 2.1))


def test_nav2_unknown_is_not_free(tmp_path):
    world = load_world(nav2(tmp_path, [[254, 205, 0]], free_thresh=0.196))
    np.testing.assert_array_equal(world.free, [[1, 0, 0]])


def test_nav2_negate(tmp_path):
    world = load_world(nav2(tmp_path, [[0, 50, 254]], negate=1, free_thresh=0.196))
    np.testing.assert_array_equal(world.free, [[1, 0, 0]])
    world = load_world(nav2(tmp_path, [[0, 49, 254]], negate="true", free_thresh=0.196))
    np.testing.assert_array_equal(world.free, [[1, 1, 0]])


def test_nav2_scale_and_transparency(tmp_path):
    pixels = [[[255, 255, 255, 255], [255, 255, 255, 100], [128, 128, 128, 255]]]
    world = load_world(nav2(tmp_path, pixels, "map.png", mode="scale"))
    np.testing.assert_array_equal(world.free, [[1, 0, 0]])


def test_nav2_raw(tmp_path):
    # As nav2 since 2024: the threshold itself is free.
    world = load_world(nav2(tmp_path, [[0, 25, 26, 100, 101, 255]], mode="raw", negate=1))
    np.testing.assert_array_equal(world.free, [[1, 1, 0, 0, 0, 0]])
    world = load_world(nav2(tmp_path, [[0, 1, 2]], mode="raw", free_thresh=0))
    np.testing.assert_array_equal(world.free, [[1, 0, 0]])


@pytest.mark.parametrize("mode", ["Trinary", "TRINARY", "Scale", "sCALE", "'scale'"])
def test_nav2_modes_in_any_case_and_a_threshold_of_zero(tmp_path, mode):
    world = load_world(nav2(tmp_path, [[255, 254, 0]], mode=mode, free_thresh=0, occupied_thresh=1))
    np.testing.assert_array_equal(world.free, [[1, 0, 0]])
    world = load_world(nav2(tmp_path, [[255, 254, 0]], mode=mode, free_thresh="0.0", negate="True"))
    np.testing.assert_array_equal(world.free, [[0, 0, 1]])


@pytest.mark.parametrize(
    "written",
    ["0.05", "5e-2", "+.05", "0.05 # metres", "'0.05'", "5.0E-02", "\t0.05\t# h\xf6he", "0050e-3"],
)
def test_nav2_numbers_in_any_form(tmp_path, written):
    file = nav2(tmp_path, [[254, 0]], resolution=written)
    file.write_bytes(file.read_text().encode("latin-1"))
    assert load_world(file).resolution_m == 0.05
    nav2(tmp_path, [[254, 0]], origin=f"[-{written.split('#')[0].strip()}, 1, 0]")
    if written[0] not in "+'":
        assert load_world(file).origin_m[1] == 1.0


PLAN = [[0, 0, 0, 0], [0, 254, 254, 0], [0, 254, 0, 0]]


@pytest.mark.parametrize("turn", range(-4, 9))
def test_nav2_quarter_turns_are_exact(tmp_path, turn):
    for error in (0.0, 1e-17, -1e-9, 1e-3):
        yaw = turn * np.pi / 2 + error
        file = nav2(tmp_path, PLAN, origin=f"[1.0, 2.0, {yaw!r}]", resolution=0.1)
        world = load_world(file)
        assert "notes" not in world.source
        assert world.free.sum() == 3
        # The centres of the free pixels, turned about the origin.
        along = np.array([[0.15, 0.05], [0.15, 0.15], [0.25, 0.15]])
        cos, sin = np.round(np.cos(turn * np.pi / 2)), np.round(np.sin(turn * np.pi / 2))
        centres = along @ np.array([[cos, sin], [-sin, cos]]) + (1.0, 2.0)
        for x, y in centres:
            assert world.free[world.frame.cell_of(x, y)]


def test_nav2_any_turn_is_resampled_and_never_freer(tmp_path):
    pixels = np.full((60, 80), 254)
    pixels[30, :] = 0
    yaw = 0.5
    file = nav2(tmp_path, pixels, origin=f"[-1.0, 2.0, {yaw}]", resolution=0.1)
    world = load_world(file)
    assert "turned by 28.65 degrees" in world.source["notes"]
    free = np.argwhere(world.free)
    x, y = (world.frame.centres_of(free) - (-1.0, 2.0)).T
    u, v = x * np.cos(yaw) + y * np.sin(yaw), y * np.cos(yaw) - x * np.sin(yaw)
    assert 0.0 < u.min() < u.max() < 8.0
    assert 0.0 < v.min() < v.max() < 6.0
    assert ((v < 2.9) | (v > 3.0)).all()
    assert world.free.sum() * 0.01 == pytest.approx(8 * 5.9, rel=0.1)
    _, count = ndimage.label(world.free)
    assert count == 2


def test_yaml_that_would_fill_the_memory(tmp_path):
    # 427 bytes that name 10^9 texts.
    text = "a: &a [x,x,x,x,x,x,x,x,x,x]\n"
    for number in range(8):
        ten = ",".join(["*" + chr(97 + number)] * 10)
        text += f"{chr(98 + number)}: &{chr(98 + number)} [{ten}]\n"
    file = nav2(tmp_path, [[254]])
    good = file.read_text()
    file.write_text(text + good)
    assert load_world(file).free.sum() == 1
    file.write_text(text + good.replace("image: map.pgm", "image: *i"))
    one_line("image = something nested", file)
    file.write_text(good + "# " + "x" * 200_000)
    one_line("bytes: no nav2 map is so large", file)


def test_nav2_at_another_resolution(tmp_path):
    file = nav2(tmp_path, [[254, 254, 254, 254], [254, 254, 0, 254]])
    world = load_world(file, resolution_m=0.1)
    np.testing.assert_array_equal(world.free, [[1, 0]])
    coarse = nav2(tmp_path, [[254, 0]], resolution=0.25)
    world = load_world(coarse)
    assert world.resolution_m == pytest.approx(0.25 / 3)
    assert world.free.shape == (3, 6)


@pytest.mark.parametrize(
    ("keys", "says"),
    [
        ({"resolution": None}, "key 'resolution' is missing"),
        ({"image": None}, "key 'image' is missing"),
        ({"free_thresh": None}, "key 'free_thresh' is missing"),
        ({"free_thresh": None, "free_tresh": 0.2}, "did you mean 'free_tresh'"),
        ({"origin": "[0, 0, .inf]"}, "origin = "),
        ({"origin": "[0, 0, 0, 0]"}, "origin = "),
        ({"origin": "[[0, 0], 0]"}, "origin = something nested"),
        ({"origin": "[0, a, 0]"}, "origin = "),
        ({"origin": 3}, "origin = '3'"),
        ({"resolution": 0}, "resolution = 0.0: expected metres above 0"),
        ({"free_thresh": 0}, "no pixel of 'map.pgm' is free"),
        ({"resolution": -0.1}, "resolution = -0.1"),
        ({"resolution": ".nan"}, "resolution = '.nan'"),
        ({"resolution": "fine"}, "resolution = 'fine'"),
        ({"image": "other.pgm"}, "does not exist"),
        ({"image": "[a, b]"}, "image = '[a, b]'"),
        ({"negate": "[0]"}, "negate = '[0]'"),
        ({"resolution": "9" * 5000}, "resolution = '9999"),
        ({"resolution": "1_000"}, "resolution = '1_000'"),
        ({"resolution": "1:30"}, "resolution = '1:30'"),
        ({"resolution": "0.05\nresolution: 0.1"}, "'resolution' is there twice"),
        ({"mode": "trinry"}, "did you mean 'trinary'"),
        ({"negate": 2}, "negate = '2'"),
        ({"free_thresh": 0.7}, "free_thresh = 0.7, occupied_thresh = 0.65"),
        ({"free_thresh": -0.1}, "free_thresh = -0.1"),
        ({"resolution": 100.0}, "too large"),
        ({"image": "[a, b"}, "is not YAML"),
    ],
)
def test_broken_nav2(tmp_path, keys, says):
    shown = {**keys}
    pixels = np.full((40, 40), 254)
    nav2(tmp_path, pixels)
    file = nav2(tmp_path, pixels) if "image" not in keys else tmp_path / "map.yaml"
    given_keys = {**NAV2, **shown}
    text = "\n".join(f"{key}: {value}" for key, value in given_keys.items() if value is not None)
    file.write_text(text)
    one_line(says, file)


def one_line(says: str, *what: object, **options: object) -> None:
    """Loading fails with one line that says this."""
    with pytest.raises(WorldError) as caught:
        load_world(*what, **options)
    assert says in str(caught.value), str(caught.value)
    assert "\n" not in str(caught.value)
    assert len(str(caught.value)) < 500


def test_broken_yaml_files(tmp_path):
    file = tmp_path / "map.yaml"
    file.write_bytes(b"\xff\xfe\x00\x01")
    one_line("is not a nav2 map", file)
    file.write_bytes(b"image: \x00")
    one_line("is not YAML", file)
    file.write_text("- 1\n- 2\n")
    one_line("is not a nav2 map", file)
    one_line("does not exist", tmp_path / "none.yaml")


def test_numbers_that_yaml_takes_for_texts_and_a_byte_order_mark(tmp_path):
    file = nav2(tmp_path, np.full((40, 40), 254))
    keys = {**NAV2, "resolution": "5e-2", "origin": "[1e0, -2e0, 0]"}
    text = "\n".join(f"{key}: {value}" for key, value in keys.items())
    file.write_bytes(b"\xef\xbb\xbf" + text.encode())
    world = load_world(file)
    assert (world.resolution_m, world.origin_m) == (0.05, (1.0, -2.0))
    file.write_text(text.replace("5e-2", "1e-9"))
    one_line("cells that small are not supported", file)
    for text in ("[" * 5000, "image: " + "{" * 90_000, "- " * 40_000):
        file.write_text(text)
        began = time.process_time()
        one_line("is not YAML: too many nested brackets", file)
        assert time.process_time() - began < 1.0


def test_things_that_are_no_worlds(tmp_path):
    one_line("not by a NoneType", None)
    one_line("not by a ndarray", np.ones((5, 5)))
    one_line("unknown world", "a\0b")
    with pytest.raises(WorldError, match="x, y in metres"):
        World("mine", np.ones((5, 5), dtype=np.bool_), 0.1, start_m=(1.0,))
    with pytest.raises(WorldError, match="resolution_m = 'fine'"):
        World("mine", np.ones((5, 5), dtype=np.bool_), "fine")
    assert "array" not in repr(World("mine", np.ones((50, 50), dtype=np.bool_), 0.1))


def test_broken_images(tmp_path):
    good = nav2(tmp_path, np.full((40, 40), 254))
    packed = (tmp_path / "map.pgm").read_bytes()
    (tmp_path / "map.pgm").write_bytes(packed[: len(packed) // 2])
    one_line("cannot read the image", good)
    (tmp_path / "map.pgm").write_bytes(b"P5\n100000 100000\n255\n" + b"\0" * 100)
    one_line("too many pixels", good)
    (tmp_path / "map.pgm").write_bytes(b"P5\n9000 9000\n255\n" + b"\0" * 100)
    one_line("too large", good)
    (tmp_path / "map.pgm").write_bytes(b"no image at all")
    one_line("cannot read the image", good)
    (tmp_path / "map.pgm").write_bytes(b"P5\nx y\n255\n")
    one_line("cannot read the image", good)


def test_movingai(tmp_path):
    file = tmp_path / "tiny.map"
    file.write_text(OCTILE)
    world = load_world(file, resolution_m=0.5)
    np.testing.assert_array_equal(world.free, [[1, 0, 0], [1, 1, 0]])
    assert load_world(file).free.shape == (10, 15)
    assert load_world(file).resolution_m == pytest.approx(0.1)
    assert load_world(file, cell_m=0.3).free.shape == (6, 9)
    file.write_bytes(OCTILE.replace("\n", "\r\n").encode())
    assert load_world(file).free.sum() == 3 * 25


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("", "line 1: '', expected 'type octile'"),
        (OCTILE.replace("octile", "tile"), "expected 'type octile'"),
        (
            OCTILE.replace("height 2", "height two"),
            "line 2: 'height two', expected 'height NUMBER'",
        ),
        (OCTILE.replace("height 2", "height -2"), "expected 'height NUMBER'"),
        (OCTILE.replace("height 2", "height 0"), "expected 'height NUMBER'"),
        (OCTILE.replace("width 3", "w 3"), "expected 'width NUMBER'"),
        (OCTILE.replace("height 2", "height 3"), "height says 3 rows, but there are 2"),
        (OCTILE.replace("STO", "ST"), "line 6: 2 characters, but width says 3"),
        (OCTILE.replace("T", "x"), "line 6, column 2: unknown terrain 'x'"),
        (OCTILE.replace("width 3", "width 999999999"), "too large"),
        ("type octile\nheight 1\nwidth 2\nmap\n@T\n", "nothing is free"),
    ],
)
def test_broken_movingai(tmp_path, text, says):
    file = tmp_path / "tiny.map"
    file.write_text(text)
    one_line(says, file)


@pytest.mark.parametrize("cell_m", [0.0, -1.0, float("nan"), float("inf")])
def test_impossible_cells(tmp_path, cell_m):
    file = tmp_path / "tiny.map"
    file.write_text(OCTILE)
    one_line("cell_m = ", file, cell_m=cell_m)
    one_line("resolution_m = ", file, resolution_m=cell_m)
    one_line("resolution_m = ", "lava-tube", resolution_m=cell_m)


def test_absurd_cells(tmp_path):
    file = tmp_path / "tiny.map"
    file.write_text(OCTILE)
    one_line("too large", file, cell_m=1e6)
    one_line("expected metres above 0", file, cell_m=1e300)
    for tiny in ({"resolution_m": 1e-6}, {"cell_m": 1e-9}):
        one_line("cells that small are not supported", file, **tiny)
    one_line("too large", file, resolution_m=0.005, cell_m=100.0)
    one_line("coarser than the whole raster", file, resolution_m=50.0)


def test_plain_images(tmp_path):
    colours = np.zeros((2, 3, 3), dtype=np.uint8)
    colours[0, 0] = 255
    colours[1, 1] = (200, 190, 180)
    Image.fromarray(colours).save(tmp_path / "plan.png")
    world = load_world(tmp_path / "plan.png", cell_m=0.05)
    np.testing.assert_array_equal(world.free, [[0, 1, 0], [1, 0, 0]])
    Image.fromarray(np.array([[0, 60000], [65535, 100]], dtype=np.uint16)).save(tmp_path / "d.png")
    np.testing.assert_array_equal(load_world(tmp_path / "d.png").free, [[1, 0], [0, 1]])
    Image.fromarray(colours).convert("P").save(tmp_path / "p.png")
    np.testing.assert_array_equal(load_world(tmp_path / "p.png").free, [[0, 1, 0], [1, 0, 0]])
    Image.fromarray(np.eye(4) > 0).save(tmp_path / "bits.png")
    assert load_world(tmp_path / "bits.png").free.sum() == 4
    Image.new("L", (9, 9), 100).save(tmp_path / "grey.png")
    one_line("has no free pixel", tmp_path / "grey.png")


def test_arrays_on_disk(tmp_path):
    file = tmp_path / "a.npy"
    np.save(file, np.array([[True, False], [True, True]]))
    world = load_world(file, cell_m=0.1)
    np.testing.assert_array_equal(world.free, [[1, 0], [1, 1]])
    for broken, says in (
        (np.ones((2, 2, 2), dtype=np.uint8), "expected (rows, columns)"),
        (np.ones((2, 2)), "dtype float64"),
        (np.array([[255, 0]], dtype=np.uint8), "from 0 to 255"),
        (np.array([[-1, 0]]), "from -1 to 0"),
        (np.zeros((3, 3), dtype=np.int8), "nothing is free"),
        (np.zeros((0, 3), dtype=np.uint8), "expected (rows, columns)"),
        (np.array([["a"]]), "dtype <U1"),
    ):
        np.save(file, broken)
        one_line(says, file)
    np.save(file, np.array([{"a": 1}], dtype=object), allow_pickle=True)
    one_line("cannot read the array", file)
    np.save(file, np.ones((50, 50), dtype=np.uint8))
    packed = file.read_bytes()
    for length in (0, 5, 60, 500):
        file.write_bytes(packed[:length])
        one_line("cannot read the array", file)
    huge = packed.replace(b"(50, 50), }" + b" " * 10, b"(5000000, 5000000), }")
    assert huge != packed
    file.write_bytes(huge)
    one_line("cannot read the array", file)


def test_values_of_arrays_that_are_free(tmp_path):
    file = tmp_path / "a.npy"
    np.save(file, np.array([[0, 1], [1, 0]]))
    np.testing.assert_array_equal(load_world(file, free="0").free, [[1, 0], [0, 1]])
    np.testing.assert_array_equal(load_world(file, occupied="1").free, [[1, 0], [0, 1]])
    np.save(file, np.array([[0, 49, 50], [-1, 100, 30]], dtype=np.int8))
    one_line("from -1 to 100, expected 1 where free", file)
    np.testing.assert_array_equal(load_world(file, free="0..49").free, [[1, 1, 0], [0, 0, 1]])
    both = load_world(file, free="-1..49", occupied="-1, 30").free
    np.testing.assert_array_equal(both, [[1, 1, 0], [0, 0, 0]])
    np.save(file, np.array([[0.0, 0.2], [np.nan, 1.0]]))
    np.testing.assert_array_equal(load_world(file, free="0..0.5").free, [[1, 1], [0, 0]])
    np.testing.assert_array_equal(load_world(file, occupied="1.0").free, [[1, 1], [0, 0]])
    for text in ("", "a", "1..", "5..1", "1;2", "9" * 5000, "1e9999"):
        one_line("free = '", file, free=text)
    one_line("nothing is free: the values go from 0 to 1", file, free="7")
    one_line("has no meaning for a generated world", "lava-tube", free="0")
    one_line("has no meaning for a nav2 map", nav2(tmp_path, [[254]]), free="0")


def test_values_of_images_that_are_free(tmp_path):
    file = tmp_path / "m.tif"
    levels = np.array([[0, 100, 30], [100, 0, 60]], dtype=np.float32)
    Image.fromarray(levels).save(file)
    one_line("holds values from 0 to 100, expected brightness from 0 to 1", file)
    np.testing.assert_array_equal(load_world(file, free="0..49").free, [[0, 1, 0], [1, 0, 1]])
    for bad in (np.float32(np.nan), np.float32(-0.1)):
        Image.fromarray(np.array([[0.5, bad]], dtype=np.float32)).save(file)
        one_line("expected brightness from 0 to 1", file)
    Image.fromarray(np.array([[0.0, 1.0]], dtype=np.float32)).save(file)
    np.testing.assert_array_equal(load_world(file).free, [[0, 1]])
    Image.fromarray(np.array([[0, 70000]], dtype=np.int32)).save(file)
    one_line("from 0 to 70000, expected brightness from 0 to 65535", file)
    pages = [Image.new("L", (3, 3), 255), Image.new("L", (3, 3), 0)]
    pages[0].save(file, save_all=True, append_images=pages[1:])
    one_line("has 2 pages", file)
    grey = tmp_path / "dark.png"
    Image.fromarray(np.array([[0, 255]], dtype=np.uint8)).save(grey)
    np.testing.assert_array_equal(load_world(grey, free="0").free, [[1, 0]])


def test_a_picture_is_turned_as_viewers_show_it(tmp_path):
    image = Image.fromarray(np.array([[255, 0], [255, 0], [255, 255]], dtype=np.uint8))
    exif = Image.Exif()
    exif[0x0112] = 6  # Shown turned by 90 degrees clockwise.
    image.save(tmp_path / "photo.png", exif=exif)
    shown = np.rot90(np.array([[1, 0], [1, 0], [1, 1]]), -1)
    np.testing.assert_array_equal(load_world(tmp_path / "photo.png").free, np.flipud(shown))


def test_the_grey_of_map_savers_is_unknown_without_a_yaml_file_too(tmp_path):
    pixels = np.full((20, 30), 205)
    pixels[5:15, 5:25] = 254
    pixels[5, 5:25] = 0
    for name in ("map.pgm", "map.png"):
        Image.fromarray(pixels.astype(np.uint8)).save(tmp_path / name)
        world = load_world(tmp_path / name)
        assert world.free.sum() == 9 * 20
        assert "grey 205" in world.source["notes"]
        assert load_world(tmp_path / name, free="205..255").free.sum() == 600 - 20
    # Of a picture with all greys it is one of many.
    ramp = np.tile(np.arange(256, dtype=np.uint8), (10, 1))
    Image.fromarray(ramp).save(tmp_path / "ramp.png")
    world = load_world(tmp_path / "ramp.png")
    assert world.free.sum() == 10 * (256 - 153)
    assert "notes" not in world.source
    (tmp_path / "map.yml").write_text("image: map.pgm")
    assert "'map.yml' beside it" in load_world(tmp_path / "map.pgm").source["notes"]


def test_numbers_of_thousands_of_digits(tmp_path):
    digits = "9" * 5000
    file = tmp_path / "a.map"
    file.write_text(OCTILE.replace("height 2", f"height {digits}"))
    one_line("expected 'height NUMBER'", file)
    (tmp_path / "w").mkdir()
    for text in (f"format = {digits}", "format = " + "[" * 5000, f"format = {digits[:4000]}"):
        (tmp_path / "w" / "world.toml").write_text(text)
        one_line("world.toml'", tmp_path / "w")
    save_world(world_from_array(np.ones((9, 9), dtype=bool)), tmp_path / "v")
    text = (tmp_path / "v" / "world.toml").read_text()
    for key in ("rows = 9", "resolution_m = 0.1"):
        (tmp_path / "v" / "world.toml").write_text(text.replace(key, f"{key[:-1]}{digits[:4000]}"))
        one_line("", tmp_path / "v")


def test_pipes_and_devices_are_not_waited_for(tmp_path):
    os.mkfifo(tmp_path / "f.npy")
    one_line("neither a file nor a folder", tmp_path / "f.npy")


def test_paths_with_a_home_and_variables(tmp_path, monkeypatch):
    monkeypatch.setenv("HOME", str(tmp_path))
    monkeypatch.setenv("MAPS", str(tmp_path))
    nav2(tmp_path, [[254]])
    for path in ("~/map.yaml", "$HOME/map.yaml", "${MAPS}/map.yaml"):
        assert load_world(path).free.sum() == 1
    one_line("known are .yaml, .yml, .map", nav2(tmp_path, [[254]]).rename(tmp_path / "a.cavev"))


def test_ascii():
    world = world_from_ascii("\n#####\n#S.C#\n##\n", 0.5)
    np.testing.assert_array_equal(world.free, [[0] * 5, [0, 1, 1, 1, 0], [0] * 5])
    assert world.start_m == (0.75, 0.75)
    np.testing.assert_allclose(world.stations_m, [[1.75, 0.75]])
    with pytest.raises(WorldError, match="line 2, column 2: unknown character 'x'"):
        world_from_ascii("...\n.x.")
    with pytest.raises(WorldError, match="2 starts"):
        world_from_ascii("SS")
    for empty in ("", "\n\n", "###"):
        with pytest.raises(WorldError, match=r"nothing is free|expected \(rows"):
            world_from_ascii(empty)


def test_arrays_in_memory_are_not_shared():
    free = np.ones((3, 3), dtype=np.uint8)
    world = world_from_array(free)
    free[:] = 0
    assert world.free.sum() == 9
    with pytest.raises(WorldError, match="start_m = "):
        world_from_array(world.free, start_m=(1.0, float("nan")))
    with pytest.raises(WorldError, match="stations_m = "):
        world_from_array(world.free, stations_m=[[1.0, 2.0, 3.0]])


@given(
    st.integers(0, 2**32 - 1), st.sampled_from([0.03, 0.05, 0.1, 0.5]),
    st.sampled_from([0.05, 0.07, 0.1, 0.13, 0.25]),
)  # fmt: skip
def test_resampling_never_frees_a_wall(seed, cell, wanted):
    rng = np.random.default_rng(seed)
    free = (rng.uniform(size=(23, 31)) < 0.9).astype(np.uint8)
    new = resampled(free, cell, wanted)
    assert new.shape[0] * wanted <= 23 * cell + 1e-6
    for row, col in np.ndindex(new.shape):
        rows = slice(
            int(row * wanted / cell + 1e-6), int(np.ceil((row + 1) * wanted / cell - 1e-6))
        )
        cols = slice(
            int(col * wanted / cell + 1e-6), int(np.ceil((col + 1) * wanted / cell - 1e-6))
        )
        assert new[row, col] == free[rows, cols].all()


@given(st.floats(0.01, 3.0), st.integers(1, 5))
def test_refining_keeps_the_area(cell, size):
    free = np.eye(size, dtype=np.uint8)
    raster, edge = refined(free, cell, None)
    assert edge <= 0.1 + 1e-9 or edge == cell
    assert raster.sum() * edge**2 == pytest.approx(size * cell**2)
