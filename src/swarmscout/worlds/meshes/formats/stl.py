"""STL, text and binary.

Source: 3D Systems, "StereoLithography interface specification", 1989.
"""

from __future__ import annotations

import re

import numpy as np

from swarmscout.core.errors import WorldError
from swarmscout.worlds.meshes.formats.text import numbers
from swarmscout.worlds.meshes.polygons import Polygons

__all__ = ["read_stl"]

_HEADER, _ROW = 84, 50
_WORD = re.compile(rb"^[ \t]*(facet|vertex|endfacet|endsolid)\b", re.IGNORECASE | re.MULTILINE)
_VERTEX = re.compile(
    rb"^[ \t]*vertex[ \t]+(\S+)[ \t]+(\S+)[ \t]+(\S+)", re.IGNORECASE | re.MULTILINE
)


def read_stl(packed: bytes) -> Polygons:
    """Read the triangles of an STL file.

    Args:
        packed: the file; which of the two forms it has is seen from its length and first word.

    Raises:
        WorldError: it is cut off or malformed.
    """
    announced = int.from_bytes(packed[80:_HEADER], "little") if len(packed) >= _HEADER else -1
    held = (len(packed) - _HEADER) // _ROW
    starts_as_text = packed.lstrip(b"\xef\xbb\xbf \t\r\n")[:5].lower() == b"solid"
    if announced >= 0 and announced == held:
        return _binary(packed, announced)
    if starts_as_text and re.search(rb"\bfacet\b", packed, re.IGNORECASE):
        return _text(packed)
    if announced < 0 or starts_as_text:
        raise WorldError("damaged, cut off, or no STL file")
    raise WorldError(
        f"damaged, cut off, or no STL file: it announces {announced:,} triangles and holds {held:,}"
    )


def _binary(packed: bytes, count: int) -> Polygons:
    row = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
    corners = np.frombuffer(packed, dtype=row, count=count, offset=_HEADER)["corners"]
    vertices = corners.reshape(-1, 3).astype(np.float64)
    return Polygons.of_triangles(vertices, np.arange(3 * count, dtype=np.int64).reshape(-1, 3))


def _text(packed: bytes) -> Polygons:
    packed = packed.replace(b"\r", b"\n")
    corners = _VERTEX.findall(packed)
    facets: list[int] = []
    ended = ends = 0
    for word in _WORD.findall(packed):
        kind = word.lower()
        if kind == b"facet":
            facets.append(0)
        elif kind == b"vertex" and facets:
            facets[-1] += 1
        elif kind == b"endfacet":
            ended += 1
        elif kind == b"endsolid":
            ends += 1
    if ended != len(facets) or sum(facets) != len(corners) or not ends:
        raise WorldError(
            f"damaged or cut off: {len(facets):,} facets begin, {ended:,} end, and "
            f"{'the solid does not end' if not ends else f'{len(corners):,} vertices are whole'}"
        )
    try:
        text = b" ".join(word for corner in corners for word in corner)
        vertices = numbers(text, np.float64, 3 * len(corners)).reshape(-1, 3)
    except ValueError as error:
        raise WorldError(f"damaged: a coordinate is not a number ({error})") from None
    counts = np.array(facets, dtype=np.int64)
    return Polygons(vertices, np.arange(len(vertices), dtype=np.int64), counts)
