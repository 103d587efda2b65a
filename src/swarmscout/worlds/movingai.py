"""Worlds from MovingAI benchmark grids (``.map``).

Source: Sturtevant, "Benchmarks for grid-based pathfinding", 2012; format page at movingai.com.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from swarmscout.core.errors import WorldError
from swarmscout.worlds.arrays import world_from_array
from swarmscout.worlds.resampling import check_length, check_size, refined
from swarmscout.worlds.world import World

__all__ = ["load_movingai"]

_PASSABLE, _BLOCKED = b".GS", b"@OTW"
_MOST_DIGITS = 12
_HEADER = ("type octile", "height", "width", "map")


def load_movingai(path: Path, cell_m: float | None, resolution_m: float | None) -> World:
    """A world from a grid of characters: ``.``, ``G`` and ``S`` are free, ``@ O T W`` are not.

    Args:
        path: the file; its first row is the top.
        cell_m: edge of a grid cell, in metres; None for 0.5 (the format has no metric size).
        resolution_m: as for :func:`swarmscout.worlds.resampling.refined`.

    Raises:
        WorldError: the file is missing or not of this form, or nothing is free.
    """
    cell = 0.5 if cell_m is None else cell_m
    check_length("cell_m", cell)
    try:
        lines = path.read_bytes().splitlines()
    except OSError as error:
        raise WorldError(f"cannot read the map '{path}': {error.strerror or error}") from None
    if lines:
        lines[0] = lines[0].removeprefix(b"\xef\xbb\xbf")
    height, width = _size(path, [line.decode("ascii", "replace") for line in lines[:4]])
    check_size((height, width), f"map '{path}'")
    rows = lines[4:]
    while rows and not rows[-1].strip():
        rows.pop()
    if len(rows) != height:
        raise WorldError(f"map '{path}': height says {height} rows, but there are {len(rows)}")
    for number, row in enumerate(rows, start=5):
        if len(row) != width:
            raise WorldError(
                f"map '{path}', line {number}: {len(row)} characters, but width says {width}"
            )
    cells = np.frombuffer(b"".join(rows), dtype=np.uint8).reshape(height, width)
    known = np.isin(cells, np.frombuffer(_PASSABLE + _BLOCKED, dtype=np.uint8))
    if not known.all():
        row, col = np.argwhere(~known)[0]
        raise WorldError(
            f"map '{path}', line {row + 5}, column {col + 1}: unknown terrain "
            f"{chr(cells[row, col])!r}: known are '. G S' (free) and '@ O T W' (not)"
        )
    free = np.isin(cells, np.frombuffer(_PASSABLE, dtype=np.uint8))
    if not free.any():
        raise WorldError(f"map '{path}': nothing is free: no '.', 'G' or 'S' in it")
    raster, edge = refined(np.flipud(free).astype(np.uint8), cell, resolution_m)
    facts = {"file": path.name, "cell_m": cell}
    return world_from_array(raster, edge, name=path.stem, source=facts)


def _size(path: Path, header: list[str]) -> tuple[int, int]:
    """Height and width out of the four lines of the header."""
    sizes = []
    for number, expected in enumerate(_HEADER):
        line = header[number].strip() if number < len(header) else ""
        words = line.split()
        if expected in ("height", "width"):
            digits = words[1] if len(words) == 2 and words[0] == expected else ""
            if digits.isdecimal() and len(digits) <= _MOST_DIGITS and int(digits):
                sizes.append(int(words[1]))
                continue
            expected = f"{expected} NUMBER"
        elif " ".join(words) == expected:
            continue
        raise WorldError(f"map '{path}', line {number + 1}: '{line[:40]}', expected '{expected}'")
    return sizes[0], sizes[1]
