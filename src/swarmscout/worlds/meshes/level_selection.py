"""Selection of the floor of a mesh, and of whether it lies under a roof."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from swarmscout.core.errors import WorldError
from swarmscout.core.grid import GridFrame
from swarmscout.worlds.meshes.span_graph import SpanGraph, connected_spans
from swarmscout.worlds.meshes.span_heightfield import FACES_AIR, FACES_ROCK, Spans

__all__ = ["SelectedLevel", "select_level"]

_LEVEL = math.tan(math.radians(30.0))
_MANY = 50
_SOME = 0.1
_HALF = 0.5
_HIGH_M = 1.2
"""Room in which nothing says whether it is a cave or the inside of a slab: lower, it is a slab."""
_LARGE_M2 = 20.0
_ROOMY_M = 4.0
_NEAR_M = 1.0


@dataclass(frozen=True, eq=False)
class SelectedLevel:
    """A floor: connected spans.

    Attributes:
        members: bool[n], its spans.
        start: the span to flood it from.
        roof: whether only floor under a ceiling counts.
        roof_because: why.
    """

    members: NDArray[np.bool_]
    start: int
    roof: bool
    roof_because: str


@dataclass(frozen=True, eq=False)
class _Part:
    """Connected spans, in numbers."""

    label: int
    level: int
    """How many of them are level ground."""
    roofed: float
    """The share that has a ceiling."""
    airy: bool
    """Most of them are wound like a room, and not like the inside of rock."""
    headroom_m: float
    cells: NDArray[np.int32]
    """Where they are."""


def select_level(
    spans: Spans,
    links: SpanGraph,
    frame: GridFrame,
    roof: bool | None,
    start_m: tuple[float, ...] | None,
) -> SelectedLevel:
    """Select a floor: the one at the start, or the largest one that looks like a cave's.

    Args:
        spans: room over floors, at least one.
        links: between them.
        frame: the raster.
        roof: whether floors need a ceiling; None: that is found out.
        start_m: ``(x, y)`` or ``(x, y, z)`` in metres, or None.

    Raises:
        WorldError: no floor is near the start, or none is under a ceiling.
    """
    labels = connected_spans(links)
    parts = _largest(spans, links, labels, frame.cell_m)
    if start_m is None:
        part, because = _proposed(parts, roof, frame.cell_m)
        members = labels == part.label
        meant = part.roofed > _HALF if roof is None else roof
        under = members & np.isfinite(spans.ceiling_m) if meant else members
        start = _roomy(spans, links, frame, under if under.any() else members)
    else:
        likely = [part.label for part in _ordered(parts, roof, frame.cell_m)]
        start = _at(spans, frame, start_m, labels, likely)
        members = labels == labels[start]
        share = float(np.isfinite(spans.ceiling_m[members]).mean())
        part = _Part(int(labels[start]), 0, share, True, 0.0, spans.cell[:0])
        because = f"{100.0 * share:.0f} % of the floor at the start is under a ceiling"
    if roof is not None:
        return SelectedLevel(members, start, roof, "as given")
    return SelectedLevel(members, start, part.roofed > _HALF, because)


def _largest(
    spans: Spans, links: SpanGraph, labels: NDArray[np.int32], cell_m: float
) -> list[_Part]:
    """The parts with the most level ground, largest first."""
    to = (np.where(end >= 0, end, np.arange(len(end))) for end in (links.east, links.north))
    rises = [spans.floor_m[end] - spans.floor_m for end in to]
    inside = (links.east >= 0) & (links.north >= 0)
    level = inside & (np.hypot(*rises) <= _LEVEL * cell_m)
    counts = np.bincount(labels[level], minlength=int(labels.max()) + 1)
    found: list[_Part] = []
    for label in np.argsort(-counts, kind="stable")[:_MANY].tolist():
        if found and counts[label] < 0.01 * found[0].level:
            break
        of = np.flatnonzero(labels == label)
        roofed = np.isfinite(spans.ceiling_m[of])
        under = of[roofed]
        room = spans.ceiling_m[under] - spans.floor_m[under]
        facing = spans.facing[under]
        airy = np.count_nonzero(facing == FACES_AIR) >= np.count_nonzero(facing == FACES_ROCK)
        headroom = float(np.median(room)) if len(room) else math.inf
        found.append(
            _Part(
                label,
                int(counts[label]),
                float(roofed.mean()),
                bool(airy),
                headroom,
                spans.cell[of],
            )
        )
    return found


def _ordered(parts: list[_Part], roof: bool | None, cell_m: float) -> list[_Part]:
    """Parts, the most plausible floor first."""
    most = parts[0].level
    under = [part for part in parts if _is_under(part, roof, cell_m)]
    if roof:  # A cave may open into land that is larger: what is under a roof counts.
        under.sort(key=lambda part: -part.level * part.roofed)
    if roof is False:
        # Any floor will do, but of two that are alike the one under the sky.
        return sorted(parts, key=lambda part: -part.level * (1.0 if part.roofed > _HALF else 1.1))
    # The winding of surfaces is a hint: rooms are wound like caves in rock, bodies the other way.
    rooms = [part for part in under if part.airy and _is_cave(part, parts, cell_m)]
    # A closed shell that is wound like a body: high enough it is a cave, else a slab.
    high = [part for part in under if part.headroom_m >= _HIGH_M]
    shells = high if sum(part.level for part in high) >= _HALF * most else []
    first = rooms + [part for part in (under if roof else shells) if part not in rooms]
    if not first:
        first = [part for part in parts if part.roofed <= _HALF]
    return first + [part for part in parts if part not in first]


def _is_under(part: _Part, roof: bool | None, cell_m: float) -> bool:
    """Whether a part lies under a ceiling, or, where a roof is required, enough of it does."""
    return part.roofed > _HALF or (
        roof is True and part.level * part.roofed * cell_m**2 >= _LARGE_M2
    )


def _is_cave(room: _Part, parts: list[_Part], cell_m: float) -> bool:
    """Whether a room is large against all floors but those that lie over and under it.

    The block of rock that holds a cave may be of any size, and so may be the land above.
    """
    large = room.level * cell_m**2 >= _LARGE_M2 and room.level >= 0.02 * parts[0].level
    for other in parts:
        if _SOME * other.level <= room.level:
            return True
        if not large or np.isin(room.cells, other.cells).mean() < _HALF:
            return False
    return True


def _proposed(parts: list[_Part], roof: bool | None, cell_m: float) -> tuple[_Part, str]:
    best = _ordered(parts, roof, cell_m)[0]
    if roof and not _is_under(best, roof, cell_m):
        raise WorldError(
            "no floor of the mesh lies under a ceiling: it has no roof (--no-roof), or another up "
            "axis (--up)"
        )
    share = f"{100.0 * best.roofed:.0f} % of the largest floor"
    if best.roofed > _HALF:
        return best, f"{share} is under a ceiling"
    return (
        best,
        f"only {share} is under a ceiling" if best.roofed else "no ceiling is above the floor",
    )


def _roomy(spans: Spans, links: SpanGraph, frame: GridFrame, members: NDArray[np.bool_]) -> int:
    """A span far from the edges of its floor: of cells at every second row and column."""
    of = np.flatnonzero(members & (links.east >= 0) & (links.north >= 0))
    if not len(of):
        return int(np.flatnonzero(members)[0])
    row, col = np.divmod(spans.cell[of], frame.columns)
    even = (row % 2 == 0) & (col % 2 == 0)
    if even.any():
        of, row, col = of[even], row[even] // 2, col[even] // 2
    top, left = int(row.min()) - 1, int(col.min()) - 1
    floor = np.zeros((int(row.max()) - top + 2, int(col.max()) - left + 2), dtype=np.bool_)
    floor[row - top, col - left] = True
    room = ndimage.distance_transform_edt(floor)[row - top, col - left]
    return int(of[np.argmax(np.minimum(room, _ROOMY_M / (2.0 * frame.cell_m)))])


def _at(
    spans: Spans,
    frame: GridFrame,
    start_m: tuple[float, ...],
    labels: NDArray[np.int32],
    order: list[int],
) -> int:
    """The span at a start: nearest in height if that is given, or of the most plausible part."""
    x, y = start_m[:2]
    row, col = np.divmod(spans.cell, frame.columns)
    away = np.hypot(
        frame.origin_x_m + (col + 0.5) * frame.cell_m - x,
        frame.origin_y_m + (row + 0.5) * frame.cell_m - y,
    )
    near = np.flatnonzero(away <= _NEAR_M)
    if not len(near):
        text = ", ".join(f"{part:g}" for part in start_m)
        left, right, bottom, top = frame.extent
        raise WorldError(
            f"no floor of the mesh is within {_NEAR_M:g} m of the start ({text}) m: the nearest "
            f"is {float(away.min()):,.1f} m away; x goes from {left:,.1f} to {right:,.1f} m and y "
            f"from {bottom:,.1f} to {top:,.1f} m"
        )
    if len(start_m) == 3:
        high = np.abs(spans.floor_m[near] - start_m[2])
        good = near[high <= _NEAR_M]
        if not len(good):
            here = near[away[near] <= away[near].min() + 1e-9]
            heights = np.unique(np.round(spans.floor_m[here].astype(np.float64), 1)).tolist()
            floors = ", ".join(f"{height:g}" for height in heights)
            raise WorldError(
                f"no floor within {_NEAR_M:g} m of z = {start_m[2]:g} m at the start ({x:g}, "
                f"{y:g}) m: floors there are at {floors} m"
            )
        cost = np.hypot(away[good], 2.0 * (spans.floor_m[good] - start_m[2]))
        return int(good[np.argmin(cost)])
    for label in order:
        of = near[labels[near] == label]
        if len(of):
            return int(of[np.argmin(away[of])])
    return int(near[np.argmin(away[near])])
