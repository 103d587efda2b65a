"""OFF in text form, with normals, colours or texture coordinates.

Source: Geomview manual, "OFF files".
"""

from __future__ import annotations

import re

import numpy as np

from swarmscout.core.errors import WorldError
from swarmscout.worlds.meshes.formats.text import numbers
from swarmscout.worlds.meshes.polygons import Polygons

__all__ = ["read_off"]

_KEYWORD = re.compile(rb"(ST)?(C)?(N)?(4)?(n)?OFF$")


def read_off(packed: bytes) -> Polygons:
    """Read the faces of an OFF file.

    Args:
        packed: the file.

    Raises:
        WorldError: it is binary, has coordinates of another dimension, is cut off or malformed.
    """
    packed = packed.removeprefix(b"\xef\xbb\xbf")
    rows = [line.partition(b"#")[0].split() for line in packed.splitlines()]
    rows = [row for row in rows if row]
    keyword = _KEYWORD.match(rows[0][0]) if rows else None
    if keyword:
        if b"BINARY" in rows[0]:
            raise WorldError("binary OFF is not supported: export it as text, or as PLY")
        if keyword[4] or keyword[5]:
            raise WorldError(f"'{rows[0][0].decode()}' has coordinates that are not x, y, z")
        rows[0] = rows[0][1:]
        if not rows[0]:
            rows.pop(0)
    try:
        if not keyword:  # The word is optional; what follows then must be the counts.
            int(rows[0][0])
        count, faces = int(rows[0][0]), int(rows[0][1])
    except (IndexError, ValueError):
        raise WorldError("damaged, cut off, or no OFF file") from None
    held = max(len(rows) - 1 - count, 0)
    if count < 0 or faces < 0 or held < faces:
        raise WorldError(
            f"damaged or cut off: it announces {min(count, 10**18):,} vertices and "
            f"{min(faces, 10**18):,} faces and holds {held:,} faces"
        )
    if held > faces:
        raise WorldError(f"damaged: it announces {faces:,} faces and holds {held:,}")
    try:
        places = numbers(
            b" ".join(word for row in rows[1 : 1 + count] for word in row[:3]),
            np.float64,
            3 * count,
        ).reshape(count, 3)
        counts = numbers(b" ".join(row[0] for row in rows[1 + count :]), np.int64, faces)
        wanted = counts.tolist()
        corners = [row[1 : 1 + n] for row, n in zip(rows[1 + count :], wanted, strict=True)]
        if [len(row) for row in corners] != wanted:
            raise ValueError("a face has fewer corners than it announces")
        flat = numbers(b" ".join(word for row in corners for word in row), np.int64, sum(wanted))
    except ValueError as error:
        raise WorldError(f"damaged, cut off, or no OFF file ({error})") from None
    whole = counts >= 3
    return Polygons(places, flat[np.repeat(whole, counts)], counts[whole])
