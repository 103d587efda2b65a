"""Packets: the format in which the player's page receives numbers.

A packet is plain data for JSON and named arrays of whole numbers or floats behind it:

    "SWP1" · uint32 bytes of JSON · uint32 bytes of arrays · JSON · arrays

all little-endian and padded to multiples of 8, so packets can follow each other in one stream. JSON
key ``arrays`` says of each array its type (as NumPy writes it), length and place. A table of
numbers over steps and robots is stored as its first row and the differences from row to row, in the
smallest type that holds them: robots move a little or not at all, so gzip shrinks it to a tenth.
``page/packets.js`` reads what this module writes.
"""

from __future__ import annotations

import json
import struct
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

__all__ = ["MAGIC", "differences", "pack", "smallest", "with_differences"]

MAGIC = b"SWP1"

_TYPES = ("i1", "i2", "i4")


def pack(facts: Mapping[str, Any], arrays: Mapping[str, NDArray[Any]]) -> bytes:
    """One packet.

    Args:
        facts: plain data for JSON.
        arrays: arrays of any shape of types that JavaScript has: i1, u1, i2, u2, i4, u4, f4, f8.
    """
    table: dict[str, Any] = {}
    pieces: list[bytes] = []
    at = 0
    for name, array in arrays.items():
        data = np.ascontiguousarray(array)
        kind = data.dtype.str[1:]
        raw = data.astype(f"<{kind}", copy=False).tobytes()
        table[name] = {"type": kind, "length": data.size, "at": at}
        padding = -len(raw) % 8
        pieces += [raw, bytes(padding)]
        at += len(raw) + padding
    text = json.dumps({**facts, "arrays": table}, separators=(",", ":"), allow_nan=False).encode()
    text += b" " * ((-len(text) - 12) % 8)
    return b"".join([MAGIC, struct.pack("<II", len(text), at), text, *pieces])


def with_differences(name: str, table: NDArray[np.integer[Any]]) -> dict[str, NDArray[Any]]:
    """A table [rows, columns] as ``name.first`` (int32) and ``name.rest``, differences of rows."""
    wide = table.astype(np.int64, copy=False)
    first = wide[:1].astype(np.int32)
    return {f"{name}.first": first, f"{name}.rest": smallest(np.diff(wide, axis=0))}


def differences(numbers: NDArray[np.integer[Any]]) -> NDArray[np.int64]:
    """Differences between neighbours of a row, the first as it stands."""
    wide = numbers.astype(np.int64).ravel()
    wide[1:] -= wide[:-1].copy()
    return wide


def smallest(array: NDArray[np.int64]) -> NDArray[Any]:
    """Whole numbers in the smallest signed type that holds them.

    Raises:
        OverflowError: one does not fit into 32 bits.
    """
    low, high = (int(array.min()), int(array.max())) if array.size else (0, 0)
    for kind in _TYPES:
        limits = np.iinfo(kind)
        if limits.min <= low and high <= limits.max:
            return array.astype(kind)
    raise OverflowError(f"{low} … {high} do not fit into 32 bits")
