"""Which part of a flooded floor can be driven, and why the rest cannot."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from swarmscout.core.errors import WorldError
from swarmscout.core.grid import GridFrame
from swarmscout.worlds.arrays import world_from_array
from swarmscout.worlds.meshes.flood_fill import FloodedFloor
from swarmscout.worlds.meshes.ground import flanks, ground_under
from swarmscout.worlds.meshes.report import passage_widths_m
from swarmscout.worlds.meshes.span_heightfield import Spans
from swarmscout.worlds.morphology import fits, parts
from swarmscout.worlds.starts import start_of

__all__ = ["Drivable", "check_not_inside_walls", "drivable"]

_SKYLIGHT_M2 = 100.0
"""A hole in a roof is a skylight up to here; what is larger is the land outside."""
_NEAR_M = 1.0
_WALL_M = 1.2
"""Floor in nothing but passages narrower than this may be the inside of hollow walls."""


@dataclass(frozen=True, eq=False)
class Drivable:
    """Floor that can be driven from a start.

    Attributes:
        free: bool[rows, cols].
        ground_m: float32[rows, cols], the ground, and about it where it is not known.
        ceiling_m: float32[rows, cols], on the ground where there is rock; None without a roof.
        start_m: ``(x, y)``.
        left_out_m2: why floor that was reached is not free → its area.
    """

    free: NDArray[np.bool_]
    ground_m: NDArray[np.float32]
    ceiling_m: NDArray[np.float32] | None
    start_m: tuple[float, float]
    left_out_m2: dict[str, float]


def drivable(
    reached: FloodedFloor, roof: bool, start_m: tuple[float, ...] | None, radius_m: float = 0.15
) -> Drivable:
    """Take out what stands out of the ground, is steep or cut off.

    Args:
        reached: a flooded floor.
        roof: whether floor under open sky is left out (skylights are not).
        start_m: ``(x, y, …)``, or None: a roomy place of the largest region is found.
        radius_m: of a robot, for which that region has room.

    Raises:
        WorldError: a robot fits nowhere, or the start is not on floor that can be driven.
    """
    frame, floor = reached.frame, reached.floor_m
    known = ~np.isnan(floor)
    outside = _outside(reached, frame.cell_m) if roof else np.zeros_like(known)
    whys = {"under open sky": outside, "at ledges and thin walls": reached.brink & ~outside}
    # The flanks of boulders go first: smoothing would spread their slope over the ground about.
    flank = flanks(floor, frame.cell_m) & ~outside & ~reached.brink
    rough = _part(known & ~outside & ~reached.brink & ~flank, frame, start_m)
    ground = ground_under(np.where(rough, floor, np.float32(np.nan)), frame.cell_m)
    whys |= {"too steep": flank | ground.steep, "standing out of the ground": ground.obstacle}
    open_cells = rough & ~ground.obstacle & ~ground.steep
    if start_m is None:
        start = _found_start(open_cells, frame, known, radius_m)
    else:
        start = _given_start(open_cells, frame, (start_m[0], start_m[1]), whys, radius_m)
    free = _part(open_cells, frame, start)

    cell_m2 = frame.cell_m**2
    left_out = {why: float(np.count_nonzero(of)) * cell_m2 for why, of in whys.items()}
    rest = known & ~free & ~np.logical_or.reduce(list(whys.values()))
    left_out["cut off by these"] = float(np.count_nonzero(rest)) * cell_m2
    height = ground.height_m
    height = np.where(np.isnan(height), np.float32(np.median(height[free])), height)
    ceiling = None
    if roof:
        sky = np.isinf(reached.ceiling_m)
        roofs = reached.ceiling_m[rough & ~sky]
        highest = roofs.max() if len(roofs) else np.float32(height.max() + 3.0)
        ceiling = np.where(rough, np.where(sky, highest, reached.ceiling_m), height)
    return Drivable(free, height, ceiling, start, left_out)


def check_not_inside_walls(spans: Spans, frame: GridFrame, floor: Drivable) -> None:
    """Refuse floor that is only inside (or on top of) walls round a place without a floor.

    Args:
        spans: room over all floors.
        frame: the raster that they lie in.
        floor: what was taken for the floor.

    Raises:
        WorldError: the floor is narrow throughout and encloses more than itself without any
            surface, as the walls of a building do that stands on the ground of a simulator.
    """
    width = passage_widths_m(floor.free, frame.cell_m)[2]
    if width >= _WALL_M:
        return
    surface = np.zeros(frame.rows * frame.columns, dtype=np.bool_)
    surface[spans.cell] = True
    raster = surface.reshape(frame.rows, frame.columns)
    enclosed = np.count_nonzero(ndimage.binary_fill_holes(raster) & ~raster)
    if enclosed > np.count_nonzero(floor.free):
        cell_m2 = frame.cell_m**2
        raise WorldError(
            f"it has no floor but inside its walls: {np.count_nonzero(floor.free) * cell_m2:,.0f} "
            f"m² in passages of at most {width:.1f} m, round {enclosed * cell_m2:,.0f} m² without "
            "any surface; add the ground that it stands on (--ground-plane, or --ground Z), or say "
            "that these passages are meant (--roof or --no-roof)"
        )


def _outside(reached: FloodedFloor, cell_m: float) -> NDArray[np.bool_]:
    """Floor under open sky that is larger than a skylight."""
    labels = parts(np.isinf(reached.ceiling_m))
    large = np.flatnonzero(np.bincount(labels.ravel()) * cell_m**2 > _SKYLIGHT_M2)
    outside: NDArray[np.bool_] = np.isin(labels, large[large > 0])
    return outside


def _part(
    cells: NDArray[np.bool_], frame: GridFrame, start_m: tuple[float, ...] | None
) -> NDArray[np.bool_]:
    """The connected part nearest to a start, or the largest; nothing where nothing is marked."""
    labels = parts(cells)
    if start_m is not None:
        nearest = _nearest(cells, frame, start_m)
        return cells & (labels == labels[nearest]) if nearest else np.zeros_like(cells)
    sizes = np.bincount(labels.ravel())
    sizes[0] = 0
    largest: NDArray[np.bool_] = cells & (labels == int(np.argmax(sizes)))
    return largest


def _nearest(
    cells: NDArray[np.bool_], frame: GridFrame, start_m: tuple[float, ...]
) -> tuple[int, int] | None:
    """The marked cell nearest to a point, if one is near."""
    row, col = frame.cell_of(start_m[0], start_m[1])
    about = math.ceil(_NEAR_M / frame.cell_m) + 1
    top, left = max(row - about, 0), max(col - about, 0)
    near = np.argwhere(cells[top : max(row + about + 1, 0), left : max(col + about + 1, 0)])
    if not len(near):
        return None
    near += (top, left)
    away = np.hypot(*(frame.centres_of(near) - start_m[:2]).T)
    best = int(np.argmin(np.round(away, 6)))
    return (int(near[best, 0]), int(near[best, 1])) if away[best] <= _NEAR_M else None


def _found_start(
    open_cells: NDArray[np.bool_], frame: GridFrame, known: NDArray[np.bool_], radius_m: float
) -> tuple[float, float]:
    try:
        world = world_from_array(
            open_cells, frame.cell_m, origin_m=(frame.origin_x_m, frame.origin_y_m)
        )
        return start_of(world, radius_m)
    except WorldError:
        area = float(np.count_nonzero(known)) * frame.cell_m**2
        left = float(np.count_nonzero(open_cells)) * frame.cell_m**2
        raise WorldError(
            f"no floor that can be driven: the largest floor has {area:,.1f} m², without steep "
            f"places and obstacles {left:,.1f} m², and no robot of {2 * radius_m:g} m fits anywhere"
        ) from None


def _given_start(
    open_cells: NDArray[np.bool_],
    frame: GridFrame,
    start_m: tuple[float, float],
    whys: dict[str, NDArray[np.bool_]],
    radius_m: float,
) -> tuple[float, float]:
    """The start, or the centre of the nearest cell with room for a robot where its own has none."""
    row, col = frame.cell_of(*start_m)
    room = fits(open_cells.astype(np.uint8), frame.cell_m, radius_m)
    if frame.contains(row, col) and room[row, col]:
        return start_m
    nearest = _nearest(room, frame, start_m)
    if nearest is None:
        why = next(
            (why for why, of in whys.items() if frame.contains(row, col) and of[row, col]),
            "too narrow for a robot, or cut off",
        )
        raise WorldError(
            f"no floor that can be driven is within {_NEAR_M:g} m of the start ({start_m[0]:g}, "
            f"{start_m[1]:g}) m: the floor there is {why}"
        )
    return frame.centre_of(*nearest)
