"""Breakdown as boulders: convex blocks on cells that the raster calls not free.

Each block is cut to fit: planes take away what would stand on free ground. Blocks overlap, as in a
real pile, and are sunk into the floor.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from swarmscout.core.streams import stream
from swarmscout.worlds.meshes.surfacing import Triangles
from swarmscout.worlds.meshes.tube_surface import breakdown_cells
from swarmscout.worlds.noise import as_floats
from swarmscout.worlds.tube import TubeFields
from swarmscout.worlds.tube_parameters import TubeParameters

__all__ = ["LEAST_SIZE_M", "breakdown_blocks"]

_BLOCKS = 11
LEAST_SIZE_M = 0.4
"""No block's footprint is shorter than this: boulders, not pebbles."""
_RADII_M = (0.4, 1.15)
_UPRIGHT_M = 0.32
"""A block's sides stand upright to this height above the ground, past every sensor."""
_SUNK_M = 0.3
_INTO_ROCK_M = 0.45
"""Blocks reach so far into the walls, in metres: they lean on them."""
_EDGE_M = 0.16
_SLANT_M = 0.15
_TRIES_PER_M2 = 40

Points = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class _Pile:
    """Cells that blocks should cover, seen from near by."""

    cells: NDArray[np.bool_]
    free_m: Points
    """Centres (x, y) [n, 2] of free cells round it, in metres."""
    kept_out_m: Points
    """Centres of free cells and of cells deep in the rock: no block reaches there."""
    holds: NDArray[np.bool_]
    """Cells where the middle of a block may lie."""
    corner_m: tuple[float, float]
    inward: tuple[NDArray[np.float64], NDArray[np.float64]]
    """Along x and y, from free ground into the pile."""


def breakdown_blocks(
    fields: TubeFields, base_m: NDArray[np.float64], parameters: TubeParameters
) -> list[Triangles]:
    """Boulders that cover a tube's breakdown and leave its free cells free.

    Args:
        fields: what the tube's rasters are made of.
        base_m: float64[rows, cols], the ground that blocks lie on.
        parameters: the tube's looks; its seed shapes the blocks.

    Returns:
        Convex blocks, each closed and facing outwards, in metres.
    """
    rng = stream(parameters.seed, "world", _BLOCKS)
    resolution = parameters.resolution_m
    labels, count = ndimage.label(breakdown_cells(fields), structure=np.ones((3, 3)))
    blocks: list[Triangles] = []
    for number, (rows, columns) in enumerate(ndimage.find_objects(labels, count), start=1):
        pile = _pile(fields, labels == number, (rows, columns), resolution)
        for outline in _outlines(rng, pile, resolution):
            block = _block(rng, outline, fields, base_m, resolution)
            if block is not None:
                blocks.append(block)
    return blocks


def _pile(
    fields: TubeFields,
    cells: NDArray[np.bool_],
    where: tuple[slice, slice],
    resolution: float,
) -> _Pile:
    margin = math.ceil(2.0 * _RADII_M[1] / resolution) + 1
    rows, columns = (slice(max(part.start - margin, 0), part.stop + margin) for part in where)
    free = fields.free[rows, columns] != 0
    rock = fields.depth_m[rows, columns] < -_INTO_ROCK_M
    corner = (columns.start * resolution, rows.start * resolution)
    away = ndimage.distance_transform_edt(~free)
    smooth = ndimage.gaussian_filter(np.minimum(away, 30.0), max(0.15 / resolution, 0.7))
    inward = np.gradient(smooth)
    free_m, kept_out_m = (
        (np.argwhere(marked)[:, ::-1] + 0.5) * resolution + corner for marked in (free, free | rock)
    )
    holds = ~free & (fields.depth_m[rows, columns] > -0.4 * _INTO_ROCK_M)
    return _Pile(cells[rows, columns], free_m, kept_out_m, holds, corner, (inward[1], inward[0]))


def _outlines(rng: np.random.Generator, pile: _Pile, resolution: float) -> list[Points]:
    """Convex footprints [n, 2] that cover the pile's cells, its rim first."""
    rows, columns = np.nonzero(pile.cells)
    centres: Points = as_floats(
        (np.column_stack((columns, rows)) + 0.5) * resolution + pile.corner_m
    )
    away = _nearest_m(centres, pile.free_m)
    open_cells = np.ones(len(centres), dtype=np.bool_)
    outlines: list[Points] = []
    for _ in range(int(len(centres) * resolution**2 * _TRIES_PER_M2) + 5):
        left = np.flatnonzero(open_cells)
        if not len(left):
            break
        rim = left[away[left] < away[left].min() + 2.0 * resolution]
        chosen = int(rim[rng.integers(len(rim))])
        open_cells[chosen] = False  # A place where no block fits is not tried for ever.
        radius = float(rng.uniform(*_RADII_M))
        row, col = rows[chosen], columns[chosen]
        along = np.array([pile.inward[0][row, col], pile.inward[1][row, col]])
        length = float(np.sqrt((along * along).sum()))
        middle = centres[chosen]
        for part in (0.75, 0.45, 0.2):
            shift = max(part * radius - float(away[chosen]), 0.0)
            moved = centres[chosen] + along / max(length, 1e-9) * shift
            cell = np.floor((moved - pile.corner_m) / resolution).astype(int)
            if pile.holds[cell[1], cell[0]]:
                middle = moved
                break
        outline = _cut(_random_outline(rng, middle, radius), middle, pile.kept_out_m, resolution)
        outline = _plain(outline)
        if _size_m(outline) < LEAST_SIZE_M:
            continue
        outlines.append(outline)
        open_cells &= ~_contains(outline, centres, -0.3 * resolution)
    return outlines


def _random_outline(rng: np.random.Generator, middle: Points, radius: float) -> Points:
    """An uneven convex polygon [n, 2], counter-clockwise."""
    from scipy.spatial import ConvexHull

    count = int(rng.integers(5, 9))
    angles = (np.arange(count) + rng.uniform(-0.3, 0.3, size=count)) * (2.0 * math.pi / count)
    angles += rng.uniform(0.0, 2.0 * math.pi)
    reach = radius * rng.uniform(0.8, 1.15, size=count)
    points = middle + reach[:, None] * np.column_stack((np.cos(angles), np.sin(angles)))
    return np.asarray(points[ConvexHull(points).vertices], dtype=np.float64)


def _cut(outline: Points, middle: Points, kept_out_m: Points, resolution: float) -> Points:
    """Cut a convex polygon until no cell that is kept out reaches far into it."""
    away = kept_out_m - middle
    distance = np.sqrt((away * away).sum(axis=1))
    reach = float(np.sqrt(((outline - middle) ** 2).sum(axis=1)).max())
    near = np.flatnonzero(distance < reach + resolution)
    # The polygon only shrinks: what lies outside now need not be looked at again.
    near = near[_contains(outline, kept_out_m[near], -0.4 * resolution)]
    for index in near[np.argsort(distance[near], kind="stable")]:
        if not len(outline):
            break
        if not _contains(outline, kept_out_m[index : index + 1], -0.4 * resolution)[0]:
            continue
        normal = away[index] / max(float(distance[index]), 1e-9)
        outline = _clipped(outline, normal, float(normal @ kept_out_m[index]) - 0.5 * resolution)
    return outline


def _clipped(outline: Points, normal: Points, offset: float) -> Points:
    """The part of a convex polygon where ``normal · p <= offset``."""
    height = outline @ normal - offset
    after = np.roll(height, -1)
    crossing = (height > 0.0) != (after > 0.0)
    parts = []
    following = np.roll(outline, -1, axis=0)
    for index in range(len(outline)):
        if height[index] <= 0.0:
            parts.append(outline[index])
        if crossing[index]:
            share = height[index] / (height[index] - after[index])
            parts.append(outline[index] + share * (following[index] - outline[index]))
    return np.array(parts).reshape(-1, 2)


def _plain(outline: Points) -> Points:
    """Take out corners whose edges are too short to be seen: the polygon shrinks a little."""
    while len(outline) > 4:
        length = np.sqrt(((np.roll(outline, -1, axis=0) - outline) ** 2).sum(axis=1))
        shortest = int(np.argmin(length))
        if length[shortest] > _EDGE_M:
            break
        # Of the edge's two ends the one goes that takes less away.
        ends = (shortest, (shortest + 1) % len(outline))
        losses = []
        for end in ends:
            before, after = outline[end - 1], outline[(end + 1) % len(outline)]
            one, two = outline[end] - before, after - before
            losses.append(abs(float(one[0] * two[1] - one[1] * two[0])))
        outline = np.delete(outline, ends[int(np.argmin(losses))], axis=0)
    return outline


def _contains(outline: Points, points: Points, slack_m: float) -> NDArray[np.bool_]:
    """Points [n] inside a convex polygon, or nearer to it than ``-slack_m``."""
    if len(outline) < 3:
        return np.zeros(len(points), dtype=np.bool_)
    along = np.roll(outline, -1, axis=0) - outline
    length = np.maximum(np.sqrt((along * along).sum(axis=1)), 1e-12)
    normals = np.column_stack((along[:, 1], -along[:, 0])) / length[:, None]
    height = points @ normals.T - (normals * outline).sum(axis=1)
    return np.asarray((height < -slack_m).all(axis=1), dtype=np.bool_)


def _size_m(outline: Points) -> float:
    """The polygon's least width, in metres."""
    if len(outline) < 3:
        return 0.0
    along = np.roll(outline, -1, axis=0) - outline
    length = np.sqrt((along * along).sum(axis=1))
    sides = along[length > 1e-6] / length[length > 1e-6, None]
    normals = np.column_stack((sides[:, 1], -sides[:, 0]))
    reach = outline @ normals.T
    return float((reach.max(axis=0) - reach.min(axis=0)).min()) if len(normals) else 0.0


def _block(
    rng: np.random.Generator,
    outline: Points,
    fields: TubeFields,
    base_m: NDArray[np.float64],
    resolution: float,
) -> Triangles | None:
    """A boulder on a footprint: upright past a sensor's height, then narrower, and slanted."""
    rows, columns = base_m.shape
    col = np.clip((outline[:, 0] / resolution).astype(int), 0, columns - 1)
    row = np.clip((outline[:, 1] / resolution).astype(int), 0, rows - 1)
    ground = base_m[row, col]
    middle = outline.mean(axis=0)
    at = int(middle[1] / resolution), int(middle[0] / resolution)
    rise = max(float(fields.rubble_m[at]), 0.35) + float(rng.uniform(0.1, 0.5))
    least = float(ground.max()) + _UPRIGHT_M
    top = max(float(fields.floor_m[at]) + rise, least + 0.05)
    if fields.depth_m[at] > 0.0:
        top = max(min(top, float(fields.ceiling_m[at]) - 0.1), least + 0.05)
    shrink = float(rng.uniform(0.45, 0.8))
    slant = rng.uniform(-0.45, 0.45, size=2)
    aside = 0.2 * rng.uniform(-1.0, 1.0, size=2) * float(np.ptp(outline, axis=0).min())
    crown = middle + shrink * (outline - middle) + aside
    # The crown stays over the footprint, so that nothing hangs over free ground.
    over = _contains(outline, crown, 0.0)[:, None]
    crown = np.where(over, crown, middle + 0.5 * (outline - middle))
    tops = np.clip(top + (crown - middle) @ slant, least + 0.02, top + _SLANT_M)
    free_play = max(0.6 * (top - least), 0.05)
    shoulders = np.minimum(ground + _UPRIGHT_M, top)
    shoulders = shoulders + free_play * rng.uniform(0.0, 1.0, size=len(outline)) ** 2
    feet = np.full(len(outline), float(ground.min()) - _SUNK_M)
    points = np.concatenate(
        [
            np.column_stack((part, heights))
            for part, heights in ((outline, feet), (outline, shoulders), (crown, tops))
        ]
    )
    return _hull(np.round(points, 4))


def _hull(points: Points) -> Triangles | None:
    """The convex hull of points [n, 3], facing outwards."""
    from scipy.spatial import ConvexHull, QhullError

    try:
        hull = ConvexHull(points)
    except QhullError:
        return None
    triangles = hull.simplices.astype(np.int64)
    one, two, three = (points[triangles[:, k]] for k in range(3))
    facing = (np.cross(two - one, three - one) * hull.equations[:, :3]).sum(axis=1)
    triangles[facing < 0.0] = triangles[facing < 0.0][:, [0, 2, 1]]
    used, numbers = np.unique(triangles, return_inverse=True)
    return points[used], numbers.reshape(-1, 3)


def _nearest_m(points: Points, others: Points) -> NDArray[np.float64]:
    """Distance of each point [n] from the nearest of others, in metres."""
    from scipy.spatial import cKDTree

    if not len(others):
        return np.full(len(points), 10.0)
    distance, _ = cKDTree(others).query(points)
    return np.asarray(distance, dtype=np.float64)
