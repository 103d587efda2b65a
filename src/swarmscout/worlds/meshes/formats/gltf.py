"""glTF 2.0 and GLB: the triangles of its scene.

Source: Khronos, "glTF 2.0 specification" (ISO/IEC 12113:2022), KHR_mesh_quantization and
KHR_draco_mesh_compression.
"""

from __future__ import annotations

import base64
import binascii
import json
from pathlib import Path
from typing import Any
from urllib.parse import unquote

import numpy as np
from numpy.typing import NDArray

from swarmscout.core.errors import WorldError
from swarmscout.worlds.meshes.polygons import Polygons, from_strip, placed

__all__ = ["read_gltf"]

_COMPONENTS = {5120: "<i1", 5121: "<u1", 5122: "<i2", 5123: "<u2", 5125: "<u4", 5126: "<f4"}
_WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4}
_DRACO = "KHR_draco_mesh_compression"
_LOOKS = (
    "KHR_materials_", "KHR_texture_", "EXT_texture_", "MSFT_texture_", "KHR_lights_", "EXT_lights_",
    "KHR_xmp", "KHR_mesh_quantization",
)  # fmt: skip
"""Extensions that leave the geometry as it is, by the beginning of their names."""
_INSTANCING = "EXT_mesh_gpu_instancing"
_MOST = 500_000_000


def read_gltf(packed: bytes, folder: Path, kind: str = "GLTF") -> Polygons:
    """Read the triangles of a glTF or GLB file, each instance of a part in its own place.

    Args:
        packed: the file; its first bytes say which of the two.
        folder: where the buffers of a glTF file lie.
        kind: ``"GLTF"`` or ``"GLB"``, as errors call it.

    Raises:
        WorldError: it is cut off, a buffer is missing, or it needs an extension that is not
            supported.
    """
    text, chunk = _glb(packed) if packed[:4] == b"glTF" else (packed, None)
    try:
        tree = json.loads(text.decode("utf-8-sig"))
    except (ValueError, RecursionError) as error:
        why = str(error)[:80] or "too many nested brackets"
        raise WorldError(f"damaged, cut off, or no {kind} file ({why})") from None
    version = str(tree.get("asset", {}).get("version", "")) if isinstance(tree, dict) else ""
    if not version.startswith("2"):
        raise WorldError(f"not a glTF 2.0 file: asset.version = '{version[:20]}'")
    required = [str(name) for name in tree.get("extensionsRequired", [])]
    for name in required:
        if name != _DRACO and not name.startswith(_LOOKS):
            raise WorldError(
                f"it requires the extension {name[:60]}, which is not supported: export it without"
            )
    try:
        return _Tree(tree, folder, chunk, _DRACO in required).polygons()
    except (KeyError, IndexError, TypeError, ValueError, AttributeError, OverflowError) as error:
        why = f"{type(error).__name__}: {str(error)[:80]}"
        raise WorldError(f"damaged, cut off, or no {kind} file ({why})") from None


def _glb(packed: bytes) -> tuple[bytes, bytes | None]:
    """The chunks of a GLB file: JSON, and binary if there is one."""
    version, length = (int.from_bytes(packed[at : at + 4], "little") for at in (4, 8))
    if version != 2:
        raise WorldError(f"GLB of version {version}, expected 2")
    if length > len(packed):
        raise WorldError(f"cut off: it announces {length:,} bytes and holds {len(packed):,}")
    chunks: dict[bytes, bytes] = {}
    at = 12
    while at + 8 <= length:
        size, kind = int.from_bytes(packed[at : at + 4], "little"), packed[at + 4 : at + 8]
        if at + 8 + size > length:
            raise WorldError(f"cut off: a chunk announces {size:,} bytes")
        chunks.setdefault(kind, packed[at + 8 : at + 8 + size])
        at += 8 + size
    return chunks.get(b"JSON", b""), chunks.get(b"BIN\0")


class _Tree:
    """A file's JSON with its buffers."""

    def __init__(
        self, tree: dict[str, Any], folder: Path, chunk: bytes | None, draco: bool
    ) -> None:
        self.tree = tree
        self.folder = folder
        self.chunk = chunk
        self.draco = draco
        self.buffers: dict[int, bytes] = {}
        self.parts: dict[int, list[Polygons]] = {}

    def polygons(self) -> Polygons:
        nodes = self.tree.get("nodes", [])
        scenes = self.tree.get("scenes", [])
        if scenes:
            roots = scenes[self.tree.get("scene", 0)].get("nodes", [])
        else:
            inner = {child for node in nodes for child in node.get("children", [])}
            roots = [number for number in range(len(nodes)) if number not in inner]
        found: list[tuple[Polygons, NDArray[np.float64]]] = []
        waiting = [(number, np.eye(4)) for number in roots]
        visited = 0
        while waiting:
            number, outer = waiting.pop()
            visited += 1
            if visited > len(nodes):  # Each node has one place in the scene.
                raise WorldError("its nodes contain each other, or have several parents")
            node = _item(nodes, number, "node")
            if _INSTANCING in node.get("extensions", {}):
                raise WorldError(
                    f"it uses {_INSTANCING}, which is not supported: export without it"
                )
            matrix = outer @ _transform(node)
            if "mesh" in node:
                if "skin" in node:
                    raise WorldError("it has a skinned mesh: apply the pose before the export")
                found += [(part, matrix) for part in self.part(node["mesh"])]
            waiting += [(child, matrix) for child in node.get("children", [])]
        return placed(found)

    def part(self, number: int) -> list[Polygons]:
        if number not in self.parts:
            mesh = _item(self.tree.get("meshes", []), number, "mesh")
            if any(mesh.get("weights", ())):
                raise WorldError("it has a morphed mesh: apply its weights before the export")
            read = (self.primitive(primitive) for primitive in mesh["primitives"])
            self.parts[number] = [part for part in read if part is not None]
        return self.parts[number]

    def primitive(self, primitive: dict[str, Any]) -> Polygons | None:
        mode = primitive.get("mode", 4)
        if mode in (0, 1, 2, 3):  # Points and lines.
            return None
        if mode not in (4, 5, 6):
            raise WorldError(f"a primitive has mode {mode}, expected 4, 5 or 6 (triangles)")
        compressed = primitive.get("extensions", {}).get(_DRACO)
        position = _item(self.tree["accessors"], primitive["attributes"]["POSITION"], "accessor")
        if compressed is not None and (self.draco or "bufferView" not in position):
            return self._decompressed(compressed)
        vertices = self.accessor(primitive["attributes"]["POSITION"], "VEC3").astype(np.float64)
        if "indices" in primitive:
            rows = self.accessor(primitive["indices"], "SCALAR")[:, 0].astype(np.int64)
        else:
            rows = np.arange(len(vertices), dtype=np.int64)
        if mode == 4:
            if len(rows) % 3:
                raise WorldError(f"{len(rows):,} corners of triangles are not a multiple of three")
            triangles = rows.reshape(-1, 3)
        elif mode == 5:
            triangles = from_strip(rows)
        else:
            hub = np.full(max(len(rows) - 2, 0), rows[0] if len(rows) else 0)
            triangles = np.stack((hub, rows[1:-1], rows[2:]), axis=1)
        return Polygons.of_triangles(vertices, triangles).check()

    def _decompressed(self, draco: dict[str, Any]) -> Polygons:
        try:
            import DracoPy
        except ImportError:
            raise WorldError(
                "it is compressed with Draco: decompress it, or pip install DracoPy"
            ) from None
        view, _ = self.view(draco["bufferView"])
        try:
            mesh = DracoPy.decode(view)
        except Exception as error:
            raise WorldError(
                f"it is compressed with Draco, and damaged ({str(error)[:80]}): decompress it"
            ) from None
        vertices = np.asarray(mesh.points, dtype=np.float64).reshape(-1, 3)
        return Polygons.of_triangles(vertices, np.asarray(mesh.faces, dtype=np.int64)).check()

    def accessor(self, number: int, kind: str) -> NDArray[Any]:
        """[count, width] of an accessor's numbers, sparse and normalized ones resolved."""
        accessor = _item(self.tree["accessors"], number, "accessor")
        count = accessor["count"]
        if accessor["type"] != kind or not isinstance(count, int) or not 0 <= count <= _MOST:
            raise WorldError(f"accessor {number} is {accessor['type']} × {count}, expected {kind}")
        dtype = np.dtype(_COMPONENTS[accessor["componentType"]])
        width = _WIDTHS[kind]
        if "bufferView" in accessor:
            numbers = self._numbers(accessor, dtype, count, width)
        elif "sparse" in accessor:
            numbers = np.zeros((count, width), dtype=dtype)
        else:
            raise WorldError(f"accessor {number} has no data: {_unused(self.tree)}")
        if "sparse" in accessor:
            sparse = accessor["sparse"]
            kind_of = np.dtype(_COMPONENTS[sparse["indices"]["componentType"]])
            at = self._numbers(sparse["indices"], kind_of, sparse["count"], 1)[:, 0]
            numbers = numbers.copy()
            numbers[at] = self._numbers(sparse["values"], dtype, sparse["count"], width)
        if accessor.get("normalized") and dtype.kind != "f":
            return np.maximum(numbers / float(np.iinfo(dtype).max), -1.0)
        return numbers

    def _numbers(
        self, at: dict[str, Any], dtype: np.dtype[Any], count: int, width: int
    ) -> NDArray[Any]:
        view, stride = self.view(at["bufferView"])
        step = stride or dtype.itemsize * width
        first = at.get("byteOffset", 0)
        needed = first + (count - 1) * step + dtype.itemsize * width if count else 0
        if needed > len(view) or first < 0 or step < dtype.itemsize * width:
            raise WorldError(f"cut off: {count:,} values need {needed:,} bytes of {len(view):,}")
        return np.ndarray((count, width), dtype, view, first, (step, dtype.itemsize))

    def view(self, number: int) -> tuple[bytes, int | None]:
        view = _item(self.tree.get("bufferViews", []), number, "bufferView")
        for name in view.get("extensions", {}):
            if "meshopt" in name and "uri" not in self.tree["buffers"][view["buffer"]]:
                raise WorldError(f"it is compressed with {name}: export it without")
        buffer = self.buffer(view["buffer"])
        first, length = view.get("byteOffset", 0), view["byteLength"]
        if first < 0 or first + length > len(buffer):
            raise WorldError(f"cut off: a view ends at byte {first + length:,} of {len(buffer):,}")
        return buffer[first : first + length], view.get("byteStride")

    def buffer(self, number: int) -> bytes:
        if number not in self.buffers:
            entry = _item(self.tree.get("buffers", []), number, "buffer")
            uri = entry.get("uri")
            if uri is None:
                if self.chunk is None or number:
                    raise WorldError(f"buffer {number} has no data")
                data = self.chunk
            else:
                data = _fetched(str(uri), self.folder)
            if len(data) < entry["byteLength"]:
                raise WorldError(
                    f"cut off: buffer {number} announces {entry['byteLength']:,} bytes and holds "
                    f"{len(data):,}"
                )
            self.buffers[number] = data
        return self.buffers[number]


def _unused(tree: dict[str, Any]) -> str:
    names = ", ".join(str(name)[:40] for name in tree.get("extensionsUsed", []))
    return f"the file uses {names}" if names else "it is damaged"


def _item(items: Any, number: Any, kind: str) -> Any:
    if not isinstance(number, int) or not 0 <= number < len(items):
        raise WorldError(f"{kind} {str(number)[:20]} is missing")
    return items[number]


def _fetched(uri: str, folder: Path) -> bytes:
    """A buffer's bytes, from within the text or from a file beside it."""
    if uri.startswith("data:"):
        head, _, body = uri.partition(",")
        try:
            return base64.b64decode(body) if head.endswith(";base64") else unquote(body).encode()
        except binascii.Error as error:
            raise WorldError(f"damaged: a buffer is not base64 ({error})") from None
    if "://" in uri:
        raise WorldError(f"a buffer lies at '{uri[:60]}': save it beside the file")
    # URIs are percent-encoded; some exporters write the plain name.
    names = dict.fromkeys((unquote(uri), uri))
    for name in names:
        try:
            return (folder / name).read_bytes()
        except (OSError, ValueError):
            continue
    raise WorldError(f"a file that it needs is missing: '{next(iter(names))[:80]}'")


def _transform(node: dict[str, Any]) -> NDArray[np.float64]:
    """A node's matrix, or its scale, rotation (a quaternion x, y, z, w) and translation."""
    if "matrix" in node:
        return np.array(node["matrix"], dtype=np.float64).reshape(4, 4).T
    matrix = np.eye(4)
    x, y, z, w = np.array(node.get("rotation", (0, 0, 0, 1)), dtype=np.float64)
    length = x * x + y * y + z * z + w * w
    if length > 0.0:
        s = 2.0 / length
        matrix[:3, :3] = [
            [1 - s * (y * y + z * z), s * (x * y - z * w), s * (x * z + y * w)],
            [s * (x * y + z * w), 1 - s * (x * x + z * z), s * (y * z - x * w)],
            [s * (x * z - y * w), s * (y * z + x * w), 1 - s * (x * x + y * y)],
        ]
    matrix[:3, :3] *= np.array(node.get("scale", (1, 1, 1)), dtype=np.float64)
    matrix[:3, 3] = node.get("translation", (0, 0, 0))
    return matrix
