"""What a robot's body can reach, and how far it is along the ground."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from swarmscout.core.errors import WorldError
from swarmscout.worlds.morphology import covered_by, fits, parts
from swarmscout.worlds.starts import start_of
from swarmscout.worlds.world import World

__all__ = ["distance_along_ground", "reachable", "standing_places", "start_cell"]

_START_SLACK_M = 1.0
"""A start too near to a wall is replaced by the nearest place within this distance."""


def reachable(world: World, radius_m: float = 0.15) -> NDArray[np.uint8]:
    """What a robot's body can cover when it sets out from the world's start.

    Args:
        world: a world; the start is derived where it has none.
        radius_m: the body's radius, in metres.

    Returns:
        uint8[rows, cols], read-only: 1 where a cell is free and its centre is within ``radius_m``
        of a place where the body can stand and that is connected with the start.

    Raises:
        WorldError: no robot can stand at the start.
    """
    return world.once(("reachable", radius_m), lambda: _find_reachable(world, radius_m))


def _find_reachable(world: World, radius_m: float) -> NDArray[np.uint8]:
    place = standing_places(world, radius_m)
    window = _window_of(world.free, margin=1)
    body = covered_by(place[window], world.resolution_m, radius_m)
    raster = np.zeros(world.free.shape, dtype=np.uint8)
    raster[window] = body & (world.free[window] != 0)
    raster.setflags(write=False)
    return raster


def standing_places(world: World, radius_m: float = 0.15) -> NDArray[np.bool_]:
    """Cells at whose centre a robot can stand and that it can reach from the start.

    Cells count as connected through their edges: a body that would have to squeeze diagonally
    between two corners does not pass.

    Args:
        world: a world; the start is derived where it has none.
        radius_m: the body's radius, in metres.

    Returns:
        bool[rows, cols], read-only.

    Raises:
        WorldError: no robot can stand at the start.
    """
    return _standing(world, radius_m)[0]


def distance_along_ground(
    open_cells: NDArray[np.bool_],
    sources: Iterable[tuple[int, int]],
    farthest: int | None = None,
) -> NDArray[np.int32]:
    """Steps from the nearest source, through open cells.

    Waves alternate between 4 and 8 neighbours, so that equal distances form octagons: 11 % less to
    6 % more than the true length, in whole numbers that are equal on every machine.

    Args:
        open_cells: bool[rows, cols], where one can go; what matters is connected through edges.
        sources: cells ``(row, col)``, each open.
        farthest: number of steps to stop after; None for no limit.

    Returns:
        int32[rows, cols]: steps of about one cell, −1 where no way leads (or it is too long).
    """
    rows, columns = open_cells.shape
    wide = columns + 2
    closed_border = np.zeros((rows + 2, wide), dtype=np.bool_)
    closed_border[1:-1, 1:-1] = open_cells
    to_visit = closed_border.ravel()
    distance = np.full(to_visit.size, -1, dtype=np.int32)
    order = np.empty(to_visit.size, dtype=np.int32)
    edges = np.array([-wide, -1, 1, wide])
    corners = np.array([-wide - 1, -wide + 1, wide - 1, wide + 1])
    both = np.concatenate((edges, corners))
    wave = np.unique([(row + 1) * wide + col + 1 for row, col in sources]).astype(np.int64)
    steps = 0
    while wave.size and (farthest is None or steps <= farthest):
        to_visit[wave] = False
        distance[wave] = steps
        steps += 1
        ahead = (wave[:, None] + (both if steps % 2 == 0 else edges)).ravel()
        ahead = ahead[to_visit[ahead]]
        # Each cell once: of the entries that name it, the one that wrote its number last.
        number = np.arange(ahead.size, dtype=np.int32)
        order[ahead] = number
        wave = ahead[order[ahead] == number]
    return distance.reshape(rows + 2, wide)[1:-1, 1:-1]


def _standing(world: World, radius_m: float) -> tuple[NDArray[np.bool_], tuple[int, int]]:
    """Places connected with the start, and the start's own cell ``(row, col)``."""
    return world.once(("standing", radius_m), lambda: _find_standing(world, radius_m))


def _find_standing(world: World, radius_m: float) -> tuple[NDArray[np.bool_], tuple[int, int]]:
    start = start_of(world, radius_m)
    window = _window_of(world.free, margin=1)
    place = np.zeros(world.free.shape, dtype=np.bool_)
    labels = parts(fits(world.free[window], world.resolution_m, radius_m))
    cell = _nearest_part(world, start, labels, (window[0].start, window[1].start))
    if cell is None:
        raise WorldError(
            f"world '{world.name}': no robot of {2 * radius_m:g} m fits within "
            f"{_START_SLACK_M:g} m of the start ({start[0]:.2f}, {start[1]:.2f}) m: "
            "set a start in open space, or leave it out and one is found"
        )
    row, col = cell
    here = labels[row - window[0].start, col - window[1].start]
    np.equal(labels, here, out=place[window])
    place.setflags(write=False)
    return place, cell


def start_cell(world: World, radius_m: float = 0.15) -> tuple[int, int]:
    """The cell ``(row, col)`` nearest to the start at whose centre a robot can stand."""
    return _standing(world, radius_m)[1]


def _window_of(free: NDArray[np.uint8], margin: int) -> tuple[slice, slice]:
    """The part of a raster in which there is anything free, with a border of wall."""
    rows, columns = np.flatnonzero(free.any(axis=1)), np.flatnonzero(free.any(axis=0))
    if not rows.size:
        return slice(0, free.shape[0]), slice(0, free.shape[1])
    return (
        slice(max(int(rows[0]) - margin, 0), int(rows[-1]) + margin + 1),
        slice(max(int(columns[0]) - margin, 0), int(columns[-1]) + margin + 1),
    )


def _nearest_part(
    world: World,
    start: tuple[float, float],
    labels: NDArray[np.int32],
    corner: tuple[int, int],
) -> tuple[int, int] | None:
    """The open cell nearest to the start, if one is within the slack."""
    frame = world.frame
    row, col = frame.cell_of(*start)
    about = int(np.ceil(_START_SLACK_M / world.resolution_m)) + 1
    top, left = max(row - corner[0] - about, 0), max(col - corner[1] - about, 0)
    bottom, right = max(row - corner[0] + about + 1, 0), max(col - corner[1] + about + 1, 0)
    cells = np.argwhere(labels[top:bottom, left:right] > 0)
    cells += np.array([top + corner[0], left + corner[1]])
    if not len(cells):
        return None
    far = np.hypot(*(frame.centres_of(cells) - start).T)
    best = int(np.argmin(np.round(far, 6)))
    if far[best] > max(_START_SLACK_M, world.resolution_m):
        return None
    return int(cells[best, 0]), int(cells[best, 1])
