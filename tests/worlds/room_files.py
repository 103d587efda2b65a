"""One room in the forms in which mesh files come: 12 × 8 × 2.5 m, a wall with a door, a pillar.

The wall at x = 6 is a single polygon round the door (y from 1 to 2.2, 2 m high). 94 m² are free.
"""

from __future__ import annotations

import base64
import json
import struct

import numpy as np

from swarmscout.worlds.meshes.polygons import Polygons, triangulated


def _box_sides(x: float, y: float, edge: float, high: float) -> list[list[tuple[float, ...]]]:
    ring = [(x, y), (x + edge, y), (x + edge, y + edge), (x, y + edge)]
    pairs = zip(ring, ring[1:] + ring[:1], strict=True)
    return [[(*a, 0.0), (*b, 0.0), (*b, high), (*a, high)] for a, b in pairs]


DOOR = [(0, 0), (1, 0), (1, 2), (2.2, 2), (2.2, 0), (8, 0), (8, 2.5), (0, 2.5)]
FACES: list[list[tuple[float, ...]]] = [
    [(0, 0, 0), (12, 0, 0), (12, 8, 0), (0, 8, 0)],
    [(0, 0, 2.5), (0, 8, 2.5), (12, 8, 2.5), (12, 0, 2.5)],
    [(0, 0, 0), (0, 0, 2.5), (12, 0, 2.5), (12, 0, 0)],
    [(0, 8, 0), (12, 8, 0), (12, 8, 2.5), (0, 8, 2.5)],
    [(0, 0, 0), (0, 8, 0), (0, 8, 2.5), (0, 0, 2.5)],
    [(12, 0, 0), (12, 0, 2.5), (12, 8, 2.5), (12, 8, 0)],
    [(6, y, z) for y, z in DOOR],
    *_box_sides(1.0, 5.0, 1.0, 2.5),
]
POINTS = np.array([point for face in FACES for point in face], dtype=np.float64)
COUNTS = np.array([len(face) for face in FACES], dtype=np.int64)
ROWS = [list(range(end - n, end)) for n, end in zip(COUNTS, np.cumsum(COUNTS), strict=True)]
AREA = 2 * 96 + 2 * 30 + 2 * 20 + (8 * 2.5 - 1.2 * 2) + 4 * 2.5


def check(vertices: np.ndarray, triangles: np.ndarray, y_up: bool = False) -> None:
    """The triangles are those of the room: same area, same bounds, and an open door."""
    if y_up:
        vertices = np.stack((vertices[:, 0], -vertices[:, 2], vertices[:, 1]), axis=1)
    corners = vertices[triangles]
    across = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    assert 0.5 * np.linalg.norm(across, axis=1).sum() == np.float64(AREA).round(6) or np.isclose(
        0.5 * np.linalg.norm(across, axis=1).sum(), AREA, rtol=1e-3
    )
    used = vertices[np.unique(triangles)]
    np.testing.assert_allclose(used.min(axis=0), [0, 0, 0], atol=2e-3)
    np.testing.assert_allclose(used.max(axis=0), [12, 8, 2.5], atol=2e-3)
    wall = corners[np.abs(corners[:, :, 0] - 6.0).max(axis=1) < 2e-3][:, :, 1:]
    assert len(wall) == 6
    for point in ((1.6, 1.0), (1.1, 0.5), (2.1, 1.9)):
        signs = []
        for a, b in ((0, 1), (1, 2), (2, 0)):
            edge, to = wall[:, b] - wall[:, a], np.array(point) - wall[:, a]
            signs.append(edge[:, 0] * to[:, 1] - edge[:, 1] * to[:, 0])
        inside = np.all(np.array(signs) > 0, axis=0) | np.all(np.array(signs) < 0, axis=0)
        assert not inside.any(), "the door is closed"


def triangles() -> np.ndarray:
    """int64[26, 3], rows of POINTS."""
    rows = np.array([row for face in ROWS for row in face])
    return triangulated(Polygons(POINTS, rows, COUNTS))[0]


def obj(points: np.ndarray = POINTS, relative: bool = False, corner: str = "{}") -> str:
    """OBJ text; relative: every face directly after its own vertices, counted back."""
    lines = []
    for face in ROWS:
        own = [f"v {x:g} {y:g} {z:g}" for x, y, z in points[face]]
        lines += own if relative else []
        words = [
            corner.format(i - len(face) if relative else face[i] + 1) for i in range(len(face))
        ]
        lines.append("f " + " ".join(words))
    if not relative:
        lines = [f"v {x:g} {y:g} {z:g}" for x, y, z in points] + lines
    return "\n".join(lines) + "\n"


def ply(
    order: str = "",
    axes: str = "xyz",
    kind: str = "float",
    index: str = "uchar int vertex_indices",
    extra: bool = False,
    comment: str = "made by hand",
) -> bytes:
    """PLY, in text or binary (order '<' or '>')."""
    form = {"": "ascii", "<": "binary_little_endian", ">": "binary_big_endian"}[order]
    head = ["ply", f"format {form} 1.0", f"comment {comment}", f"element vertex {len(POINTS)}"]
    head += [f"property {kind} {axis}" for axis in axes] + ["property uchar red"] * extra
    head += [f"element face {len(ROWS)}"] + ["property short flags"] * extra
    head += [f"property list {index}"] + ["property float quality"] * extra
    packed = "\n".join([*head, "end_header\n"]).encode("latin-1")
    columns = POINTS[:, ["xyz".index(axis.lower()) for axis in axes]]
    code = {"float": "f", "double": "d"}[kind]
    length, number = (
        {"uchar": "B", "int": "i", "uint": "I", "short": "h", "uint8": "B", "int32": "i"}[word]
        for word in index.split()[:2]
    )
    rows = []
    for row in columns.tolist():
        values = [*row, 7] if extra else row
        rows.append((f"3{code}" + "B" * extra, values))
    for face in ROWS:
        values = [3] * extra + [len(face), *face] + [0.5] * extra
        rows.append(("h" * extra + length + number * len(face) + "f" * extra, values))
    if not order:
        return packed + "".join(" ".join(f"{v:g}" for v in row) + "\n" for _, row in rows).encode()
    return packed + b"".join(struct.pack(order + form, *row) for form, row in rows)


def gltf(
    kind: str = "f", indices: str = "I", uri: str | None = None, **changes: object
) -> tuple[dict, bytes]:
    """glTF with y up: its JSON and its buffer (embedded where there is no uri).

    kind 'f' floats, 'h' normalized 16-bit numbers with a scale on the node.
    """
    points = np.stack((POINTS[:, 0], POINTS[:, 2], -POINTS[:, 1]), axis=1)
    node: dict = {"mesh": 0}
    accessor: dict = {"bufferView": 0, "componentType": 5126, "count": len(points), "type": "VEC3"}
    if kind == "h":
        node["scale"] = [12, 12, 12]
        accessor |= {"componentType": 5122, "normalized": True}
        packed = np.zeros((len(points), 4), "<i2")
        packed[:, :3] = np.round(points / 12.0 * 32767)
        first = packed.tobytes()
    else:
        first = points.astype("<f4").tobytes()
    second = triangles().astype(np.dtype(indices)).tobytes()
    code = {"H": 5123, "I": 5125}[indices]
    buffer = first + second
    views = [
        {"buffer": 0, "byteLength": len(first)} | ({"byteStride": 8} if kind == "h" else {}),
        {"buffer": 0, "byteOffset": len(first), "byteLength": len(second)},
    ]
    entry: dict = {"byteLength": len(buffer)}
    entry["uri"] = (
        uri or "data:application/octet-stream;base64," + base64.b64encode(buffer).decode()
    )
    tree = {
        "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [node],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
        "accessors": [
            accessor, {"bufferView": 1, "componentType": code, "count": 78, "type": "SCALAR"},
        ],
        "bufferViews": views, "buffers": [entry], **changes,
    }  # fmt: skip
    return tree, buffer


def glb(tree: dict, buffer: bytes) -> bytes:
    """GLB of a glTF tree whose buffer moves into the file."""
    tree = {**tree, "buffers": [{"byteLength": len(buffer)}]}
    text = json.dumps(tree).encode()
    text += b" " * (-len(text) % 4)
    buffer += b"\0" * (-len(buffer) % 4)
    chunks = struct.pack("<I4s", len(text), b"JSON") + text
    chunks += struct.pack("<I4s", len(buffer), b"BIN\0") + buffer
    return b"glTF" + struct.pack("<II", 2, 12 + len(chunks)) + chunks


def dae(
    primitive: str, node: str = "", up: str = "Z", axes: str = "XYZ", materials: str = ""
) -> str:
    """COLLADA with one geometry; primitive: the element with the faces."""
    params = "".join(f'<param name="{axis}" type="float"/>' for axis in axes)
    columns = POINTS[:, ["XYZ".index(axis) for axis in axes]]
    numbers = " ".join(f"{value:g}" for value in columns.ravel())
    return f"""<?xml version="1.0"?>
<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
<asset><unit meter="1"/><up_axis>{up}_UP</up_axis></asset>
<library_geometries><geometry id="g"><mesh><source id="p">
<float_array id="f" count="{columns.size}">{numbers}</float_array>
<technique_common><accessor source="#f" count="{len(columns)}" stride="3">{params}</accessor>
</technique_common></source>
<vertices id="v"><input semantic="POSITION" source="#p"/></vertices>{primitive}</mesh></geometry>
</library_geometries><library_visual_scenes><visual_scene id="s"><node>{node}
<instance_geometry url="#g">{materials}</instance_geometry></node></visual_scene>
</library_visual_scenes><scene><instance_visual_scene url="#s"/></scene></COLLADA>"""


INPUT = '<input semantic="VERTEX" source="#v" offset="0"/>'


def dae_triangles(material: str = "", parts: int = 1) -> str:
    """``<triangles>``; parts: in how many ``<p>`` (one is what the standard wants)."""
    rows = np.array_split(triangles(), parts)
    texts = "".join(f"<p>{' '.join(map(str, part.ravel()))}</p>" for part in rows)
    return f'<triangles count="26" {material}>{INPUT}{texts}</triangles>'


def dae_polylist() -> str:
    counts = " ".join(map(str, COUNTS))
    rows = " ".join(str(row) for face in ROWS for row in face)
    return f'<polylist count="11">{INPUT}<vcount>{counts}</vcount><p>{rows}</p></polylist>'


def dae_polygons() -> str:
    rows = "".join(f"<p>{' '.join(map(str, face))}</p>" for face in ROWS)
    return f'<polygons count="11">{INPUT}{rows}</polygons>'


def stl_text(faces: list | None = None, name: str = "room") -> str:
    """STL text; by default in triangles."""
    corners = POINTS[triangles()].tolist() if faces is None else faces
    lines = [f"solid {name}"]
    for face in corners:
        lines += ["facet normal 0 0 0", "outer loop"]
        lines += [f"vertex {x:g} {y:g} {z:g}" for x, y, z in face]
        lines += ["endloop", "endfacet"]
    return "\n".join([*lines, f"endsolid {name}"]) + "\n"


def stl_binary(head: bytes = b"") -> bytes:
    corners = POINTS[triangles()].astype("<f4")
    rows = b"".join(b"\0" * 12 + face.tobytes() + b"\0\0" for face in corners)
    return head.ljust(80, b" ") + struct.pack("<I", len(corners)) + rows


def off(keyword: str = "OFF\n", after_vertex: str = "", after_face: str = "") -> str:
    lines = [f"{keyword}{len(POINTS)} {len(ROWS)} 0"]
    lines += [f"{x:g} {y:g} {z:g}{after_vertex}" for x, y, z in POINTS]
    lines += [f"{len(face)} {' '.join(map(str, face))}{after_face}" for face in ROWS]
    return "\n".join(lines) + "\n"
