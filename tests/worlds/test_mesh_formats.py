"""The same room in every form that mesh files come in; what cannot be read right is refused."""

from __future__ import annotations

import json
import struct

import numpy as np
import pytest
import room_files as room

from swarmscout.core.errors import WorldError
from swarmscout.worlds import import_mesh
from swarmscout.worlds.meshes.files import read_mesh_file
from swarmscout.worlds.meshes.polygons import Polygons, triangulated

OBJ = room.obj()
UPPER = room.obj(corner="{0}/{0}/{0}")


def cyrillic(text: str) -> bytes:
    return text.encode("cp1251")


WHOLE = {
    # OBJ
    "ngon.obj": OBJ,
    "relative.obj": room.obj(relative=True),
    "relative_slashes.obj": room.obj(relative=True, corner="{0}//{0}"),
    "textured.obj": UPPER,
    "bom.obj": b"\xef\xbb\xbf" + OBJ.encode(),
    "utf16.obj": OBJ.encode("utf-16"),
    "latin1.obj": b"# h\xf6hle\n" + OBJ.encode() + b"g h\xf6hle\n",
    "crlf.obj": OBJ.replace("\n", "\r\n"),
    "cr.obj": OBJ.replace("\n", "\r"),
    "continued.obj": OBJ.replace("f 25 26", "f 25 \\\n26"),
    "indented.obj": OBJ.replace("v ", "  v\t").replace("f ", "\tf  "),
    "coloured.obj": "\n".join(
        line + " 0.5 0.5 0.5" if line.startswith("v") else line for line in OBJ.splitlines()
    ),
    "commented.obj": OBJ.replace("\nf ", " # corner\no part\nl 1 2\np 1\nusemtl none\nf "),
    "numbers.obj": OBJ.replace("v 12 ", "v +1.2e1 ").replace(" 2.5\n", " 25.E-1\n"),
    "unended.obj": OBJ.rstrip("\n"),
    # PLY
    "text.ply": room.ply(),
    "little.ply": room.ply("<"),
    "big.ply": room.ply(">"),
    "order.ply": room.ply(axes="zyx"),
    "order_binary.ply": room.ply("<", axes="yzx", kind="double"),
    "upper_case.ply": room.ply(axes="XYZ"),
    "types.ply": room.ply(">", index="uint uint vertex_index"),
    "extra.ply": room.ply(extra=True),
    "extra_binary.ply": room.ply("<", extra=True),
    "latin1.ply": room.ply(comment="h\xf6hle"),
    "latin1_binary.ply": room.ply("<", comment="h\xf6hle"),
    "crlf.ply": room.ply().replace(b"\n", b"\r\n"),
    # STL
    "text.stl": room.stl_text(),
    "polygons.stl": room.stl_text(room.FACES),
    "latin1.stl": room.stl_text(name="h\xf6hle").encode("latin-1"),
    "named.stl": room.stl_text(name="facet vertex 1 2 3"),
    "upper.stl": room.stl_text().upper(),
    "crlf.stl": room.stl_text().replace("\n", "\r\n"),
    "indented.stl": room.stl_text().replace("\n", "\n\t "),
    "binary.stl": room.stl_binary(),
    "binary_solid.stl": room.stl_binary(b"solid facet normal"),
    # OFF
    "plain.off": room.off(),
    "one_line.off": room.off("OFF "),
    "no_word.off": room.off(""),
    "colours.off": room.off("COFF\n", " 255 0 0 255", " 0.5 0.5 0.5"),
    "normals.off": room.off("NOFF\n", " 0 0 1"),
    "comments.off": room.off("# first\nOFF # word\n\n# h\xf6hle\n").encode("latin-1"),
    # COLLADA
    "triangles.dae": room.dae(room.dae_triangles()),
    "several_lists.dae": room.dae(room.dae_triangles(parts=3)),
    "polylist.dae": room.dae(room.dae_polylist()),
    "polygons.dae": room.dae(room.dae_polygons()),
    "order.dae": room.dae(room.dae_polylist(), axes="ZXY"),
    "no_material.dae": room.dae(room.dae_triangles('material="gone"')),
    "broken_material.dae": room.dae(
        room.dae_triangles('material="M"'),
        materials="<bind_material><technique_common><instance_material symbol='M' target='#gone'/>"
        "</technique_common></bind_material>",
    ),
    "moved.dae": room.dae(
        room.dae_polylist(),
        "<translate>3 0 0</translate><rotate>0 0 1 90</rotate><rotate>0 0 1 -90</rotate>"
        "<scale>2 2 2</scale><matrix>.5 0 0 -1.5 0 .5 0 0 0 0 .5 0 0 0 0 1</matrix>",
    ),
    "latin1.dae": room.dae(room.dae_polylist())
    .replace('version="1.0"?', 'version="1.0" encoding="ISO-8859-1"?')
    .replace('id="s"', 'id="s" name="h\xf6hle"')
    .encode("latin-1"),
}
GLTF = {
    "float.gltf": room.gltf(),
    "short.gltf": room.gltf(indices="H"),
    "quantised.gltf": room.gltf("h", extensionsRequired=["KHR_mesh_quantization"]),
    "looks.gltf": room.gltf(extensionsRequired=["KHR_materials_unlit", "KHR_texture_transform"]),
    "no_scene.gltf": room.gltf(scenes=[]),
}


def written(tmp_path, name, packed):
    file = tmp_path / name
    file.write_bytes(packed.encode() if isinstance(packed, str) else packed)
    return file


@pytest.mark.parametrize("name", WHOLE)
def test_the_room_in_every_form(tmp_path, name):
    read = read_mesh_file(written(tmp_path, name, WHOLE[name]))
    room.check(read.vertices, read.triangles)
    assert read.crossing == 0


@pytest.mark.parametrize("name", GLTF)
def test_the_room_as_gltf_and_glb(tmp_path, name):
    tree, buffer = GLTF[name]
    for file in (
        written(tmp_path, name, json.dumps(tree)),
        written(tmp_path, name.replace("gltf", "glb"), room.glb(tree, buffer)),
    ):
        read = read_mesh_file(file)
        room.check(read.vertices, read.triangles, y_up=True)


@pytest.mark.parametrize("stored", ["ext space.bin", "höhle.bin", "100%.bin"])
def test_buffers_beside_a_gltf_file(tmp_path, stored):
    from urllib.parse import quote

    for uri in (quote(stored), stored):
        tree, buffer = room.gltf(uri=uri)
        (tmp_path / stored).write_bytes(buffer)
        read = read_mesh_file(written(tmp_path, "room.gltf", json.dumps(tree)))
        room.check(read.vertices, read.triangles, y_up=True)
    (tmp_path / stored).unlink()
    refused(tmp_path, "room.gltf", json.dumps(tree), "a file that it needs is missing")


def test_sparse_accessors_strips_fans_and_nodes(tmp_path):
    # The vertices are zeros, and all of them are given as exceptions.
    tree, buffer = room.gltf()
    count = len(room.POINTS)
    places = np.arange(count, dtype="<u2").tobytes()
    tree["bufferViews"].append({"buffer": 0, "byteOffset": len(buffer), "byteLength": len(places)})
    tree["accessors"][0] = {
        "componentType": 5126, "count": count, "type": "VEC3",
        "sparse": {
            "count": count,
            "indices": {"bufferView": 2, "componentType": 5123}, "values": {"bufferView": 0},
        },
    }  # fmt: skip
    # A node turned by 90 degrees about y within one that turns it back; and moved to and fro.
    half = 0.5**0.5
    tree["nodes"] = [
        {"children": [1], "rotation": [0, half, 0, half], "translation": [1, 2, 3]},
        {"children": [2], "rotation": [0, -half, 0, half]},
        {"mesh": 0, "matrix": [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, -1, -2, -3, 1]},
    ]
    read = read_mesh_file(written(tmp_path, "a.glb", room.glb(tree, buffer + places)))
    # The inner translation happens before both turns, which cancel.
    room.check(read.vertices, read.triangles, y_up=True)
    square = np.array([[0, 0, 0], [1, 0, 0], [0, 0, 1], [1, 0, 1]], dtype="<f4").tobytes()
    for mode, order in ((5, (0, 1, 2, 3)), (6, (0, 1, 3, 2))):
        corners = np.array(order, dtype="<u4").tobytes()
        tree, _ = room.gltf()
        tree["meshes"][0]["primitives"][0]["mode"] = mode
        tree["bufferViews"] = [
            {"buffer": 0, "byteLength": 48}, {"buffer": 0, "byteOffset": 48, "byteLength": 16},
        ]  # fmt: skip
        tree["accessors"][0]["count"] = tree["accessors"][1]["count"] = 4
        read = read_mesh_file(written(tmp_path, f"{mode}.glb", room.glb(tree, square + corners)))
        a, b, c = (read.vertices[read.triangles[:, k]] for k in range(3))
        assert np.cross(b - a, c - a)[:, 1].tolist() in ([-1.0, -1.0], [1.0, 1.0])


def test_ply_strips(tmp_path):
    head = "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\n"
    head += "property float z\nelement tristrips 1\nproperty list int int vertex_indices\n"
    text = head + "end_header\n0 0 0\n1 0 0\n0 1 0\n1 1 0\n8 0 1 2 3 -1 0 1 2\n"
    read = read_mesh_file(written(tmp_path, "strip.ply", text))
    assert sorted(map(sorted, read.triangles.tolist())) == [[0, 1, 2], [0, 1, 2], [1, 2, 3]]


def refused(tmp_path, name, packed, says):
    with pytest.raises(WorldError) as caught:
        read_mesh_file(written(tmp_path, name, packed))
    message = str(caught.value)
    assert says in message, message
    assert "\n" not in message
    assert len(message) < 500


def without_last(text: str | bytes, rows: int) -> bytes:
    packed = text.encode() if isinstance(text, str) else text
    return b"\n".join(packed.rstrip(b"\n").split(b"\n")[:-rows]) + b"\n"


PLY = room.ply()
DAE = room.dae(room.dae_polylist())
REFUSED = {
    "cut.ply": (without_last(PLY, 4), "announces 11 of 'face' and holds 7 whole ones"),
    "torn.ply": (PLY[:-4], "cut off: it announces 11 of 'face' and holds 10"),
    "torn_binary.ply": (room.ply("<")[:-30], "cut off: it announces 11 of 'face'"),
    "more.ply": (PLY + b"3 0 1 2\n", "announces 59 rows and holds 60"),
    "more_binary.ply": (room.ply("<") + b"\x03\x01\0\0\0", "5 bytes follow"),
    "axes.ply": (PLY.replace(b"float z", b"float w"), "have no property 'z'"),
    "lists.ply": (PLY.replace(b"vertex_indices", b"corner_list"), "'vertex_indices'"),
    "digits.ply": (PLY.replace(b"element face 11", b"element face " + b"9" * 4400), "header"),
    "index.ply": (PLY.replace(b"\n4 0 1 2 3\n", b"\n4 0 1 2 99\n"), "names vertex 99"),
    "cut.off": (without_last(room.off(), 4), "announces 48 vertices and 11 faces and holds 7"),
    "more.off": (room.off() + "3 0 1 2\n", "announces 11 faces and holds 12"),
    "four.off": (room.off("4OFF\n"), "'4OFF' has coordinates that are not x, y, z"),
    "binary.off": (b"OFF BINARY\n\0\0\0\x08" + b"\0" * 60, "binary OFF is not supported"),
    "digits.off": (room.off().replace("48 11", "9" * 4400 + " 11"), "damaged"),
    "cut.stl": (without_last(room.stl_text(), 20), "facets begin"),
    "torn.stl": (without_last(room.stl_text(), 1), "the solid does not end"),
    "cut_binary.stl": (room.stl_binary()[:-300], "announces 26 triangles and holds 20"),
    "comma.stl": (room.stl_text().replace("2.5", "2,5"), "not a number"),
    "comma.obj": (OBJ.replace("2.5", "2,5"), "line 5: '2,5' is not a number"),
    "torn.obj": (OBJ[: OBJ.rindex(" ")].rsplit(" ", 1)[0], "has 2 corners, expected 3 or more"),
    "zero.obj": (OBJ.replace("f 1 ", "f 0 "), "OBJ counts vertices from 1"),
    "far.obj": (OBJ.replace("f 1 ", "f 99 "), "line 49: a face names a vertex that is missing"),
    "back.obj": (room.obj(relative=True).replace("f -4", "f -5"), "a vertex that is missing"),
    "digits.obj": (OBJ.replace("f 1 ", f"f {'9' * 5000} "), "a vertex that is missing"),
    "surface.obj": (OBJ + "cstype bspline\nsurf 0 1 0 1 1 2 3 4\n", "'surf': free-form"),
    "count.dae": (DAE.replace('polylist count="11"', 'polylist count="12"'), "announces 12"),
    "short.dae": (DAE.replace(" 47</p>", "</p>"), "announces 48 corners and holds 47"),
    "numbers.dae": (DAE.replace("0 0 0 12", "0 0 x 12"), "not a number"),
    "array.dae": (DAE.replace('count="48"', 'count="49"'), "announces 49 points and holds 48"),
    "gone.dae": (DAE.replace('url="#g"', 'url="#other"'), "names the geometry '#other'"),
    "spline.dae": (DAE.replace("polylist", "splines"), "<splines>, which is not supported"),
    "holes.dae": (
        room.dae(room.dae_polygons()).replace("<p>0 ", "<ph><p>0 1 2</p></ph><p>0 "), "holes"
    ),
    "cut.dae": (DAE[:1200], "damaged, cut off, or no DAE file"),
    "laughs.dae": ("<!DOCTYPE x [<!ENTITY a 'b'>]>" + DAE, "declares a document type"),
    "brackets.gltf": ("[" * 100_000, "damaged, cut off"),
    "digits.gltf": ('{"asset": {"version": ' + "9" * 5000 + "}}", "damaged, cut off"),
    "version.gltf": ('{"asset": {"version": "1.0"}}', "not a glTF 2.0 file"),
}  # fmt: skip


@pytest.mark.parametrize("name", REFUSED)
def test_what_cannot_be_read_right_is_refused(tmp_path, name):
    refused(tmp_path, name, *REFUSED[name])


def test_gltf_that_needs_what_is_not_supported(tmp_path):
    for name in ("XYZ_unknown", "EXT_meshopt_compression", "EXT_mesh_gpu_instancing"):
        tree, _ = room.gltf(extensionsRequired=[name], extensionsUsed=[name])
        refused(tmp_path, "a.gltf", json.dumps(tree), f"requires the extension {name}")
    tree, _ = room.gltf(extensionsUsed=["EXT_mesh_gpu_instancing"])
    tree["nodes"][0]["extensions"] = {"EXT_mesh_gpu_instancing": {"attributes": {}}}
    refused(tmp_path, "a.gltf", json.dumps(tree), "EXT_mesh_gpu_instancing")
    tree, buffer = room.gltf()
    tree["meshes"][0]["primitives"][0]["extensions"] = {
        "KHR_draco_mesh_compression": {"bufferView": 1, "attributes": {"POSITION": 0}}
    }
    # Not required, and the plain data is there: that is read.
    read = read_mesh_file(written(tmp_path, "b.gltf", json.dumps(tree)))
    room.check(read.vertices, read.triangles, y_up=True)
    tree["extensionsRequired"] = ["KHR_draco_mesh_compression"]
    refused(tmp_path, "b.gltf", json.dumps(tree), "compressed with Draco")
    tree, buffer = room.gltf()
    refused(tmp_path, "c.glb", room.glb(tree, buffer)[:-40], "cut off: it announces")
    tree["accessors"][1]["count"] = 81
    refused(tmp_path, "d.gltf", json.dumps(tree), "cut off: 81 values need")
    tree, buffer = room.gltf()
    tree["nodes"][0]["children"] = [0]
    refused(tmp_path, "e.gltf", json.dumps(tree), "contain each other")
    # Forty nodes with two references each to the next one name 2^40 instances.
    tree["nodes"] = [{"children": [k + 1, k + 1]} for k in range(40)] + [{"mesh": 0}]
    refused(tmp_path, "e.gltf", json.dumps(tree), "have several parents")
    tree, buffer = room.gltf()
    tree["nodes"][0]["skin"] = 0
    refused(tmp_path, "f.gltf", json.dumps(tree), "skinned")
    tree, buffer = room.gltf(uri="https://example.org/room.bin")
    refused(tmp_path, "g.gltf", json.dumps(tree), "save it beside the file")
    old = b"glTF" + struct.pack("<II", 1, 20) + b"\0" * 8
    refused(tmp_path, "h.glb", old, "GLB of version 1")


def test_polygons_are_divided_without_closing_what_is_open():
    # A square with a square hole, joined by a slit, wound either way, lying in each plane.
    ring = [(0, 0), (4, 0), (4, 4), (0, 4), (0, 0), (1, 1), (1, 3), (3, 3), (3, 1), (1, 1)]
    for order in (ring, ring[::-1]):
        for axes in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
            points = np.array([(x, y, 5.0) for x, y in order])[:, axes]
            polygon = Polygons(points, np.arange(10), np.array([10]))
            triangles, crossing = triangulated(polygon)
            a, b, c = (points[triangles[:, k]] for k in range(3))
            across = np.cross(b - a, c - a)
            assert 0.5 * np.linalg.norm(across, axis=1).sum() == pytest.approx(12.0)
            # All triangles face as the polygon does.
            normal = np.cross(points, np.roll(points, -1, axis=0)).sum(axis=0)
            assert (across @ normal >= -1e-9).all()
            assert crossing == 0
    bow_tie = Polygons(
        np.array([[0, 0, 0], [1, 1, 0], [1, 0, 0], [0, 1, 0.0]]), np.arange(4), np.array([4])
    )
    assert triangulated(bow_tie)[1] == 1


def test_a_door_in_a_polygon_stays_open(tmp_path):
    world = import_mesh(written(tmp_path, "room.obj", OBJ))
    assert world.free.sum() * 0.01 == pytest.approx(94.0, abs=0.5)
    swapped = import_mesh(written(tmp_path, "x_up.obj", room.obj(room.POINTS[:, [2, 0, 1]])))
    assert swapped.source["up"] == "x"
    assert swapped.free.sum() * 0.01 == pytest.approx(94.0, abs=0.5)
