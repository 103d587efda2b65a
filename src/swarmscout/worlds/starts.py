"""The start of a mission in a world that has none.

A generated tube starts at its mouth, which is a wide place. In any other world the start is a
roomy place of the largest region that a robot can stand in.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from swarmscout.core.errors import WorldError
from swarmscout.worlds.morphology import fits, parts
from swarmscout.worlds.world import World

__all__ = ["start_of"]

_ROOMY_M = 4.0
"""More distance to the walls than this makes a start no better."""
_COARSE_M = 0.2
"""Room is measured on cells of about this edge: that is fine enough, and quick on large maps."""


def start_of(world: World, radius_m: float = 0.15) -> tuple[float, float]:
    """The world's start, or one that is found: a roomy place in the largest connected region.

    Args:
        world: a world.
        radius_m: the robots' radius, in metres.

    Returns:
        ``(x, y)`` in metres.

    Raises:
        WorldError: no robot fits anywhere.
    """
    if world.start_m is not None:
        return world.start_m
    return world.once(("start", radius_m), lambda: _roomy_place(world, radius_m))


def _roomy_place(world: World, radius_m: float) -> tuple[float, float]:
    """Of the largest region, the place farthest from walls (up to a limit), first by rows."""
    place = fits(world.free, world.resolution_m, radius_m)
    labels = parts(place)
    if not place.any():
        raise WorldError(
            f"world '{world.name}': no robot of {2 * radius_m:g} m fits anywhere: "
            f"only {int(np.count_nonzero(world.free))} of {world.free.size} cells are free "
            f"(at {world.resolution_m:g} m per cell)"
        )
    sizes = np.bincount(labels.ravel())
    sizes[0] = 0
    largest: NDArray[np.bool_] = np.asarray(labels == int(np.argmax(sizes)))
    step = max(1, math.floor(_COARSE_M / world.resolution_m + 1e-6))
    coarse = _all_of_blocks(largest, step)
    if not coarse.any():
        step, coarse = 1, largest
    room = ndimage.distance_transform_edt(np.pad(coarse, 1))[1:-1, 1:-1]
    room = np.minimum(np.round(room * step * world.resolution_m, 6), _ROOMY_M)
    row, col = np.unravel_index(int(np.argmax(room)), room.shape)
    # The middle of a block of raster cells; itself a cell's centre, so that a body fits exactly.
    return world.frame.centre_of(int(row) * step + step // 2, int(col) * step + step // 2)


def _all_of_blocks(cells: NDArray[np.bool_], step: int) -> NDArray[np.bool_]:
    """Blocks of ``step`` × ``step`` cells that are marked altogether; a rest at the end is not."""
    rows, columns = cells.shape[0] // step, cells.shape[1] // step
    blocks = cells[: rows * step, : columns * step].reshape(rows, step, columns, step)
    marked: NDArray[np.bool_] = np.logical_and.reduce(blocks, axis=(1, 3))
    return marked
