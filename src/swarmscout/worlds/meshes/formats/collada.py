"""COLLADA (``.dae``): the geometry of its scene; materials are ignored.

Source: Khronos, "COLLADA digital asset schema release 1.4.1", 2008.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Any
from xml.etree import ElementTree

import numpy as np
from numpy.typing import NDArray

from swarmscout.core.errors import WorldError
from swarmscout.worlds.meshes.formats.text import numbers
from swarmscout.worlds.meshes.polygons import Polygons, from_strip, joined, placed

__all__ = ["read_collada"]

Element = ElementTree.Element
_SKIPPED = {"lines", "linestrips", "extra", "source", "vertices"}
_DEEPEST = 200
_MOST_NODES = 100_000


def read_collada(packed: bytes) -> tuple[Polygons, str | None, float | None]:
    """Read the polygons of a COLLADA file, each instance of a part in its own place.

    Args:
        packed: the file.

    Returns:
        The polygons, the file's up axis (``"x"``, ``"y"`` or ``"z"``) and its unit in metres, both
        None where it does not name them.

    Raises:
        WorldError: it is malformed, a part is missing, or it has surfaces other than polygons.
    """
    if b"<!ENTITY" in packed or b"<!DOCTYPE" in packed:
        raise WorldError("it declares a document type, which a COLLADA file has no use for")
    try:
        root = ElementTree.fromstring(packed)
    except (ElementTree.ParseError, ValueError, LookupError, RecursionError) as error:
        raise WorldError(f"damaged, cut off, or no DAE file ({error})") from None
    for element in root.iter():
        if isinstance(element.tag, str):
            element.tag = element.tag.rpartition("}")[2]
    if root.tag != "COLLADA":
        raise WorldError(f"no DAE file: its root is <{root.tag}>, expected <COLLADA>")
    up = root.findtext("asset/up_axis", "").strip().removesuffix("_UP").lower()
    unit = root.find("asset/unit")
    return _Scene(root).polygons(), up or None, _unit_m(unit)


def _unit_m(unit: Element | None) -> float | None:
    try:
        metres = float(unit.get("meter", "")) if unit is not None else 0.0
    except ValueError:
        return None
    return metres if 0.0 < metres < 1e9 else None


class _Scene:
    """The nodes and parts of a file by their names."""

    def __init__(self, root: Element) -> None:
        self.root = root
        self.named: dict[str, Element] = {}
        for element in root.iter():
            name = element.get("id")
            if name:
                self.named.setdefault(name, element)
        self.parts: dict[str, list[Polygons]] = {}

    def polygons(self) -> Polygons:
        instance = self.root.find("scene/instance_visual_scene")
        if instance is not None:
            scenes = [self.target(instance, "visual_scene")]
        else:
            scenes = self.root.findall("library_visual_scenes/visual_scene")
            if len(scenes) != 1:
                raise WorldError(
                    f"it has {len(scenes)} visual scenes and does not say which one counts"
                )
        found: list[tuple[Polygons, NDArray[np.float64]]] = []
        waiting = [(node, np.eye(4), 0) for node in scenes[0].findall("node")]
        visited = 0
        while waiting:
            node, outer, depth = waiting.pop()
            visited += 1
            if depth > _DEEPEST or visited > _MOST_NODES:
                raise WorldError("its nodes are nested too deeply, or contain each other")
            matrix = outer @ _transform(node)
            for child in node:
                if child.tag == "node":
                    waiting.append((child, matrix, depth + 1))
                elif child.tag == "instance_node":
                    waiting.append((self.target(child, "node"), matrix, depth + 1))
                elif child.tag == "instance_geometry":
                    found += [(part, matrix) for part in self.part(child)]
                elif child.tag == "instance_controller":
                    raise WorldError(
                        "it has a skinned or morphed part (instance_controller): apply the "
                        "deformation and export it as a plain mesh"
                    )
        return placed(found)

    def target(self, element: Element, kind: str) -> Element:
        """The element that another one's ``url`` or ``source`` names."""
        url = element.get("url") or element.get("source") or ""
        found = self.named.get(url.removeprefix("#")) if url.startswith("#") else None
        if found is None or found.tag != kind:
            raise WorldError(f"<{element.tag}> names the {kind} '{url[:60]}', which is missing")
        return found

    def part(self, instance: Element) -> list[Polygons]:
        geometry = self.target(instance, "geometry")
        name = geometry.get("id", "")
        if name not in self.parts:
            mesh = geometry.find("mesh")
            if mesh is None:
                kinds = ", ".join(child.tag for child in geometry) or "nothing"
                raise WorldError(f"geometry '{name}' is not a mesh of polygons but {kinds}")
            self.parts[name] = []
            for primitive in mesh:
                if primitive.tag in _SKIPPED:
                    continue
                if primitive.tag not in _PRIMITIVES:
                    raise WorldError(
                        f"geometry '{name}' has <{primitive.tag}>, which is not supported"
                    )
                self.parts[name].append(
                    self._primitive(primitive, _PRIMITIVES[primitive.tag], name)
                )
        return self.parts[name]

    def _primitive(
        self, primitive: Element, read: Callable[[Element, int, int], _Rows], name: str
    ) -> Polygons:
        inputs = primitive.findall("input")
        vertex = next((each for each in inputs if each.get("semantic") == "VERTEX"), None)
        count = _whole(primitive.get("count"), f"count of a <{primitive.tag}>")
        if vertex is None:
            if count == 0:
                return joined([])
            raise WorldError(f"geometry '{name}': <{primitive.tag}> has no input VERTEX")
        stride = 1 + max(_whole(each.get("offset", "0"), "offset") for each in inputs)
        rows, counts, found = read(primitive, stride, _whole(vertex.get("offset", "0"), "offset"))
        if found != count:
            raise WorldError(
                f"geometry '{name}': <{primitive.tag}> announces {count:,} and holds {found:,}: "
                "damaged or cut off"
            )
        return Polygons(self._positions(self.target(vertex, "vertices")), rows, counts).check()

    def _positions(self, vertices: Element) -> NDArray[np.float64]:
        inputs = vertices.findall("input")
        position = next((each for each in inputs if each.get("semantic") == "POSITION"), None)
        if position is None:
            raise WorldError("vertices have no input POSITION")
        source = self.target(position, "source")
        accessor = source.find("technique_common/accessor")
        if accessor is None:
            raise WorldError(f"source '{source.get('id')}' has no accessor")
        values = _floats(self.target(accessor, "float_array"))
        count = _whole(accessor.get("count"), "count of an accessor")
        stride = _whole(accessor.get("stride", "1"), "stride")
        offset = _whole(accessor.get("offset", "0"), "offset")
        names = [(param.get("name") or "").upper() for param in accessor.findall("param")]
        columns = [names.index(axis) if axis in names else -1 for axis in "XYZ"]
        if names == [""] * 3:
            columns = [0, 1, 2]
        if -1 in columns or max(columns) >= stride:
            raise WorldError(
                f"source '{source.get('id')}' has coordinates {names}, expected X, Y, Z"
            )
        if len(values) < offset + count * stride:
            raise WorldError(
                f"source '{source.get('id')}' announces {count:,} points and holds "
                f"{max(len(values) - offset, 0) // stride:,}: damaged or cut off"
            )
        return values[offset : offset + count * stride].reshape(count, stride)[:, columns]


_Rows = tuple[NDArray[np.int64], NDArray[np.int64], int]
"""Rows of vertices, corners of each polygon, and how many of what is announced were found."""


def _triangles(element: Element, stride: int, offset: int) -> _Rows:
    index = _indices(element, stride)[:, offset]
    if len(index) % 3:
        raise WorldError(
            "the corners of <triangles> are not a multiple of three: damaged or cut off"
        )
    return index, np.full(len(index) // 3, 3, dtype=np.int64), len(index) // 3


def _strips(element: Element, stride: int, offset: int) -> _Rows:
    strips = [_index_of(p, stride)[:, offset] for p in element.findall("p")]
    triangles = [from_strip(strip) for strip in strips if len(strip) >= 3]
    joint = np.concatenate([np.empty((0, 3), dtype=np.int64), *triangles])
    return joint.ravel(), np.full(len(joint), 3, dtype=np.int64), len(strips)


def _fans(element: Element, stride: int, offset: int) -> _Rows:
    fans = [_index_of(p, stride)[:, offset] for p in element.findall("p")]
    corners = [np.empty((0, 3), dtype=np.int64)]
    for fan in fans:
        if len(fan) >= 3:
            hub = np.full(len(fan) - 2, fan[0])
            corners.append(np.stack((hub, fan[1:-1], fan[2:]), axis=1))
    joint = np.concatenate(corners)
    return joint.ravel(), np.full(len(joint), 3, dtype=np.int64), len(fans)


def _polylist(element: Element, stride: int, offset: int) -> _Rows:
    index = _indices(element, stride)[:, offset]
    counts = _ints(element.find("vcount"))
    if (counts < 0).any() or int(counts.sum()) != len(index):
        raise WorldError(
            f"<polylist> announces {int(counts.sum()):,} corners and holds {len(index):,}: damaged "
            "or cut off"
        )
    rows, left = _with_surface(index, counts)
    return rows, left, len(counts)


def _polygons(element: Element, stride: int, offset: int) -> _Rows:
    if element.find("ph") is not None:
        raise WorldError("it has polygons with holes (<ph>): triangulate them before the export")
    each = [_index_of(p, stride)[:, offset] for p in element.findall("p")]
    index = np.concatenate([np.empty(0, dtype=np.int64), *each])
    rows, counts = _with_surface(index, np.array([len(row) for row in each], dtype=np.int64))
    return rows, counts, len(each)


_PRIMITIVES: Mapping[str, Callable[[Element, int, int], _Rows]] = {
    "triangles": _triangles, "tristrips": _strips, "trifans": _fans, "polylist": _polylist,
    "polygons": _polygons,
}  # fmt: skip


def _with_surface(
    index: NDArray[np.int64], counts: NDArray[np.int64]
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Polygons without those of fewer than three corners."""
    whole = counts >= 3
    return index[np.repeat(whole, counts)], counts[whole]


def _indices(element: Element, stride: int) -> NDArray[np.int64]:
    parts = [_index_of(p, stride) for p in element.findall("p")]
    return np.concatenate([np.empty((0, stride), dtype=np.int64), *parts])


def _index_of(element: Element, stride: int) -> NDArray[np.int64]:
    index = _ints(element)
    if len(index) % stride:
        raise WorldError(f"a list of {len(index):,} indices is not a multiple of {stride}: cut off")
    return index.reshape(-1, stride)


def _ints(element: Element | None) -> NDArray[np.int64]:
    try:
        return numbers((element.text or "") if element is not None else "", np.int64)
    except ValueError:
        raise WorldError("an index is not a whole number") from None


def _floats(element: Element) -> NDArray[np.float64]:
    try:
        return numbers(element.text or "", np.float64)
    except ValueError:
        raise WorldError(f"<{element.tag}> holds something that is not a number") from None


def _whole(text: str | None, what: str) -> int:
    try:
        number = int(text or "")
    except ValueError:
        number = -1
    if not 0 <= number < 2**40:
        raise WorldError(f"{what} = '{(text or '')[:40]}', expected a whole number")
    return number


def _transform(node: Element) -> NDArray[np.float64]:
    """A node's own transformations, applied in the order in which they stand."""
    matrix = np.eye(4)
    for child in node:
        make = _TRANSFORMS.get(child.tag)
        if make is None:
            continue
        count, step = make
        numbers = _floats(child)
        if len(numbers) != count:
            raise WorldError(f"<{child.tag}> has {len(numbers)} numbers, expected {count}")
        matrix = matrix @ step(numbers)
    return matrix


def _translate(numbers: NDArray[np.float64]) -> NDArray[np.float64]:
    step = np.eye(4)
    step[:3, 3] = numbers
    return step


def _rotate(numbers: NDArray[np.float64]) -> NDArray[np.float64]:
    """About an axis, by an angle in degrees (Rodrigues)."""
    length = float(np.linalg.norm(numbers[:3]))
    if length == 0.0:
        return np.eye(4)
    x, y, z = numbers[:3] / length
    across = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    angle = math.radians(float(numbers[3]))
    step = np.eye(4)
    step[:3, :3] += math.sin(angle) * across + (1.0 - math.cos(angle)) * across @ across
    return step


def _unsupported(_: NDArray[np.float64]) -> NDArray[np.float64]:
    raise WorldError("a node has a transformation <lookat> or <skew>, which is not supported")


_TRANSFORMS: Mapping[str, tuple[int, Any]] = {
    "matrix": (16, lambda numbers: numbers.reshape(4, 4)),
    "translate": (3, _translate),
    "rotate": (4, _rotate),
    "scale": (3, lambda numbers: np.diag([*numbers, 1.0])),
    "lookat": (9, _unsupported),
    "skew": (7, _unsupported),
}
