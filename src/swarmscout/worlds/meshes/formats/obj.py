"""Wavefront OBJ: vertices and polygonal faces.

Source: Wavefront Advanced Visualizer manual, appendix B1 (object files).
"""

from __future__ import annotations

import re
from typing import Any

import numpy as np
from numpy.typing import NDArray

from swarmscout.core.errors import WorldError
from swarmscout.worlds.meshes.formats.text import numbers
from swarmscout.worlds.meshes.polygons import Polygons

__all__ = ["read_obj"]

_CURVED = (b"surf", b"curv", b"curv2", b"sp", b"con", b"bzp", b"bsp", b"cdp", b"cdc", b"res")
"""Statements of free-form surfaces, and of their superseded forms."""


def read_obj(packed: bytes) -> Polygons:
    """Read the faces of an OBJ file; lines and points are left out.

    Args:
        packed: the file. Texts in it may have any encoding.

    Raises:
        WorldError: a statement is malformed, or surfaces are not made of polygons.
    """
    vertices: list[bytes] = []
    vertex_lines: list[int] = []
    faces: list[list[bytes]] = []
    known: list[int] = []
    face_lines: list[int] = []
    for number, line in enumerate(_lines(packed), start=1):
        words = line.split()
        if not words:
            continue
        if words[0] == b"v":
            if len(words) < 4:
                raise WorldError(f"line {number:,}: vertex '{_shown(line)}', expected 'v X Y Z'")
            vertices += words[1:4]
            vertex_lines.append(number)
        elif words[0] in (b"f", b"fo"):
            if len(words) < 4:
                raise WorldError(
                    f"line {number:,}: face '{_shown(line)}' has {len(words) - 1} corners, "
                    "expected 3 or more"
                )
            faces.append(words[1:])
            known.append(len(vertex_lines))
            face_lines.append(number)
        elif words[0] in _CURVED:
            raise WorldError(
                f"line {number:,}: '{words[0].decode()}': free-form curves and surfaces are not "
                "supported: export the mesh as polygons"
            )
    places = _numbers(vertices, np.float64, vertex_lines, 3).reshape(-1, 3)
    counts = np.fromiter(map(len, faces), dtype=np.int64, count=len(faces))
    owners = np.repeat(np.arange(len(faces)), counts)
    # Of a corner v/vt/vn only the vertex counts.
    corners = [word.partition(b"/")[0] for face in faces for word in face]
    rows = _numbers(corners, np.int64, face_lines, 0, owners)
    if (rows == 0).any():
        number = face_lines[owners[int(np.argmax(rows == 0))]]
        raise WorldError(f"line {number:,}: a face names vertex 0: OBJ counts vertices from 1")
    # Relative indices count back from the last vertex before the face.
    before = np.asarray(known, dtype=np.int64)[owners]
    rows = np.where(rows > 0, rows - 1, before + rows)
    missing = (rows < 0) | (rows >= len(places))
    if missing.any():
        number = face_lines[owners[int(np.argmax(missing))]]
        raise WorldError(
            f"line {number:,}: a face names a vertex that is missing: the file has "
            f"{len(places):,} vertices"
        )
    return Polygons(places, rows, counts)


def _lines(packed: bytes) -> list[bytes]:
    """Statements without comments; a backslash continues one on the next line."""
    if packed.startswith((b"\xff\xfe", b"\xfe\xff")):
        packed = packed.decode("utf-16", "replace").encode()
    if b"\\\n" in packed or b"\\\r" in packed:
        packed = re.sub(rb"\\\r?\n", b" ", packed)
    packed = packed.removeprefix(b"\xef\xbb\xbf")
    # Not by splitlines(), which takes other bytes for line ends as well.
    lines = packed.replace(b"\r\n", b"\n").replace(b"\r", b"\n").split(b"\n")
    return [line.partition(b"#")[0] for line in lines] if b"#" in packed else lines


def _numbers(
    words: list[bytes],
    dtype: type,
    lines: list[int],
    each: int,
    owners: NDArray[np.int64] | None = None,
) -> NDArray[Any]:
    """Words as numbers; one that is not a number is reported with its line.

    Args:
        words: of these lines, in their order.
        dtype: of the numbers.
        lines: numbers of lines.
        each: how many words a line has; 0 where ``owners`` says it.
        owners: for each word, the index of its line.
    """
    try:
        return numbers(b" ".join(words), dtype, len(words))
    except ValueError:
        for place, word in enumerate(words):
            try:
                numbers(word, dtype, 1)
            except ValueError:
                line = lines[place // each if owners is None else owners[place]]
                raise WorldError(f"line {line:,}: '{_shown(word)}' is not a number") from None
        raise WorldError("a number is malformed") from None


def _shown(text: bytes) -> str:
    return text.strip()[:40].decode("ascii", "replace")
