"""PLY, text and binary, read by the package plyfile.

Source: Turk, "The PLY polygon file format", 1994.
"""

from __future__ import annotations

import io
import re
from typing import Any

import numpy as np
from numpy.typing import NDArray

from swarmscout.core.errors import WorldError
from swarmscout.worlds.meshes.formats.text import numbers
from swarmscout.worlds.meshes.polygons import Polygons, from_strip, joined

__all__ = ["read_ply"]

_CORNERS = ("vertex_indices", "vertex_index")
_MOST = 500_000_000
_WIDEST = 1000
_END = re.compile(rb"^end_header[ \t]*(\r\n|\n|\r)", re.MULTILINE)
Columns = dict[str, NDArray[Any]]
"""Values by property: one for each row of an element, or a list of them."""


def read_ply(packed: bytes) -> Polygons:
    """Read the faces of a PLY file, or its triangle strips.

    Args:
        packed: the file.

    Raises:
        WorldError: it is cut off or malformed, or lacks coordinates.
    """
    import plyfile

    packed = _plain_header(packed)
    first = _END.search(packed).end()  # type: ignore[union-attr]
    try:
        header = plyfile.PlyData._parse_header(io.BytesIO(packed))
        _check_counts(header)
        try:
            elements = _tables(plyfile, header, packed, first)
        except ValueError:
            elements = _any_lists(plyfile, header, packed, first)
    except plyfile.PlyElementParseError as error:
        name = error.element.name if error.element is not None else "element"
        if error.row is not None and str(error.message).startswith("early"):
            raise WorldError(
                f"cut off: it announces {error.element.count:,} of '{name}' and holds "
                f"{error.row:,} whole ones"
            ) from None
        raise WorldError(f"damaged in '{name}', row {error.row}: {error.message}") from None
    except plyfile.PlyHeaderParseError as error:
        raise WorldError(f"damaged header, or no PLY file: {error}") from None
    if "vertex" not in elements:
        raise WorldError("it has no element 'vertex'")
    vertices = _vertices(elements["vertex"])
    parts = [_faces(vertices, elements[name]) for name in ("face", "faces") if name in elements]
    if "tristrips" in elements:
        parts.append(_strips(vertices, elements["tristrips"]))
    if not parts:
        return Polygons.of_triangles(vertices, np.empty((0, 3), dtype=np.int64))
    return joined(parts)


def _plain_header(packed: bytes) -> bytes:
    """The file with a header in ASCII: comments may be in any encoding."""
    packed = packed.removeprefix(b"\xef\xbb\xbf")
    end = _END.search(packed, 0, 1_000_000)
    if not packed.startswith(b"ply") or end is None:
        raise WorldError("damaged, cut off, or no PLY file: it has no PLY header")
    header = bytes(byte if byte < 128 else 63 for byte in packed[: end.end()])
    # Trailing blanks mean nothing, and plyfile stumbles over them.
    header = re.sub(rb"[ \t]+(?=\r|\n)", b"", header)
    return header + packed[end.end() :]


def _check_counts(header: Any) -> None:
    for element in header.elements:
        if not 0 <= element.count <= _MOST:
            raise WorldError(
                f"damaged header: it announces {min(element.count, 10**18):,} of '{element.name}'"
            )


def _tables(plyfile: Any, header: Any, packed: bytes, first: int) -> dict[str, Columns]:
    """The columns of each element, whose lists have one length; the usual case, read fast.

    Raises:
        ValueError: lists differ in length, or the file is damaged.
    """
    order = {"<": "<", ">": ">", "=": "<"}[header.byte_order]
    lines = packed[first:].replace(b"\r", b"\n").split(b"\n") if header.text else []
    lines = [line for line in lines if line and not line.isspace()]
    tables: dict[str, Columns] = {}
    row = 0
    for element in header.elements:
        lists = [isinstance(prop, plyfile.PlyListProperty) for prop in element.properties]
        if header.text:
            mine = lines[row : row + element.count]
            row += element.count
            words = numbers(b" ".join(mine), np.float64)
            if len(mine) < element.count or len(words) % max(element.count, 1):
                raise ValueError("rows differ in length")
            width = len(words) // max(element.count, 1)
            if any(len(line.split()) != width for line in mine):
                raise ValueError("rows differ in length")
            tables[element.name.lower()] = _split(element, lists, words.reshape(-1, width))
            continue
        tables[element.name.lower()], first = _unpacked(element, lists, packed, first, order)
    if row < len(lines) or (not header.text and packed[first:].strip(b"\0 \t\r\n")):
        raise ValueError("more data than announced")
    return tables


def _split(element: Any, lists: list[bool], words: NDArray[np.float64]) -> Columns:
    """Rows of text as columns."""
    columns: Columns = {}
    at = 0
    for prop, is_list in zip(element.properties, lists, strict=True):
        width = 1
        if is_list and len(words):
            width = int(words[0, at])
            if (words[:, at] != width).any():
                raise ValueError("lists differ in length")
            at += 1
        columns[prop.name] = words[:, at : at + width] if is_list else words[:, at]
        at += width
    if len(words) and at != words.shape[1]:
        raise ValueError("rows have another length than announced")
    return columns


def _unpacked(
    element: Any, lists: list[bool], packed: bytes, first: int, order: str
) -> tuple[Columns, int]:
    """Rows of a binary file as columns, and where the next element begins."""
    fields: list[tuple[Any, ...]] = []
    sizes = 0
    for prop, is_list in zip(element.properties, lists, strict=True):
        kind = order + np.dtype(prop.val_dtype).str[1:]
        if not is_list:
            fields.append((prop.name, kind))
            sizes += np.dtype(kind).itemsize
            continue
        length = order + np.dtype(prop.len_dtype).str[1:]
        at = first + sizes
        width = int(np.frombuffer(packed, length, 1, at)[0]) if element.count else 0
        if not 0 <= width < _WIDEST:
            raise ValueError("a list is long")
        fields += [(f"length of {prop.name}", length), (prop.name, kind, (width,))]
        sizes += np.dtype(length).itemsize + width * np.dtype(kind).itemsize
    rows = np.frombuffer(packed, np.dtype(fields), element.count, first)
    for name in rows.dtype.names or ():
        if name.startswith("length of ") and len(rows) and (rows[name] != rows[name][0]).any():
            raise ValueError("lists differ in length")
    names = [name for name in rows.dtype.names or () if not name.startswith("length of ")]
    return {name: rows[name] for name in names}, first + rows.nbytes


def _any_lists(plyfile: Any, header: Any, packed: bytes, first: int) -> dict[str, Columns]:
    """The columns of each element, with lists of any length: read row by row."""
    if header.text:
        rows = packed[first:].replace(b"\r", b"\n").split(b"\n")
        announced = sum(element.count for element in header.elements)
        held = sum(not row.isspace() for row in rows if row)
        if held > announced:
            raise WorldError(f"damaged: it announces {announced:,} rows and holds {held:,}")
    stream = io.BytesIO(packed)
    data = plyfile.PlyData.read(stream, mmap=False)
    if not header.text:
        rest = packed[stream.tell() :]
        if rest.strip(b"\0 \t\r\n"):
            raise WorldError(f"damaged: {len(rest):,} bytes follow what its header announces")
    return {
        element.name.lower(): {name: element.data[name] for name in element.data.dtype.names or ()}
        for element in data.elements
    }


def _vertices(columns: Columns) -> NDArray[np.float64]:
    names = {name.lower(): name for name in columns}
    missing = [axis for axis in "xyz" if axis not in names]
    if missing:
        found = ", ".join(names) or "none"
        raise WorldError(f"vertices have no property {missing[0]!r}: there are {found}")
    return np.stack([np.asarray(columns[names[axis]], dtype=np.float64) for axis in "xyz"], axis=1)


def _faces(vertices: NDArray[np.float64], columns: Columns) -> Polygons:
    names = {name.lower(): name for name in columns}
    name = next((names[name] for name in _CORNERS if name in names), None)
    if name is None:
        found = ", ".join(names) or "none"
        raise WorldError(f"faces have no property 'vertex_indices': there are {found}")
    lists = columns[name]
    if lists.ndim == 2:  # All of one length.
        counts = np.full(len(lists), lists.shape[1], dtype=np.int64)
        corners = lists.astype(np.int64).ravel()
    else:
        counts = np.fromiter(map(len, lists), dtype=np.int64, count=len(lists))
        corners = np.concatenate([counts[:0], *(np.asarray(each, np.int64) for each in lists)])
    # Edges and points among the faces have no surface.
    whole = counts >= 3
    return Polygons(vertices, corners[np.repeat(whole, counts)], counts[whole])


def _strips(vertices: NDArray[np.float64], columns: Columns) -> Polygons:
    """Triangle strips; −1 begins another strip within a list."""
    triangles = [np.empty((0, 3), dtype=np.int64)]
    for each in next(iter(columns.values()), ()):
        strip = np.asarray(each, dtype=np.int64)
        for part in np.split(strip, np.flatnonzero(strip < 0)):
            part = part[part >= 0]
            if len(part) >= 3:
                triangles.append(from_strip(part))
    return Polygons.of_triangles(vertices, np.concatenate(triangles))
