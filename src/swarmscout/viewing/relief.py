"""A world as a relief: a cave with its roof cut away.

The floor keeps its height. Rock rises beside it up to a cut a little above the floor and extends
a few metres; beyond that nothing is shown. Player, figures and films all show this relief.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import distance_transform_edt, gaussian_filter

from swarmscout.core.grid import GridFrame
from swarmscout.worlds.world import World

__all__ = ["Relief", "relief_of"]

MOST_CELLS = 110_000
"""Most cells of a relief; larger worlds are shown coarser. Without a graphics card a browser draws
a few million triangles per second."""

FINEST_M = 0.2
WALL_M = 1.3
"""Height of the cut above the floor."""
RIM_M = 2.2
"""Width of the rock shown round the floor."""


@dataclass(frozen=True)
class Relief:
    """Heights of floor and rock.

    Attributes:
        frame: of the cells; heights are at cell centres.
        ground_m: float32[rows, cols], height of the floor; under rock that of the nearest floor.
        open_share: float32[rows, cols], the share of the cell that is inside, not rock: 0 … 1.
        shown: bool[rows, cols], False where nothing is shown.
        wall_m: height of the rock above the ground.
    """

    frame: GridFrame
    ground_m: NDArray[np.float32]
    open_share: NDArray[np.float32]
    shown: NDArray[np.bool_]
    wall_m: float = WALL_M

    def height_m(self) -> NDArray[np.float32]:
        """float32[rows, cols]: height of floor and rock, which rises smoothly beside the floor."""
        share = np.clip((self.open_share - 0.2) / 0.6, 0.0, 1.0)
        rock = 1.0 - share * share * (3.0 - 2.0 * share)
        return np.asarray(self.ground_m + self.wall_m * rock, dtype=np.float32)

    def ground_at(self, points_m: NDArray[np.floating]) -> NDArray[np.float64]:
        """Floor heights [...] in metres at points ``(x, y)`` [..., 2]."""
        cells = self.frame.cells_of(points_m)
        row = np.clip(cells[..., 0], 0, self.frame.rows - 1)
        col = np.clip(cells[..., 1], 0, self.frame.columns - 1)
        heights: NDArray[np.float64] = self.ground_m[row, col].astype(np.float64)
        return heights


def relief_of(world: World, most_cells: int = MOST_CELLS) -> Relief:
    """Make the relief of a world.

    Args:
        world: a world; without heights its floor lies at 0.
        most_cells: most cells of the relief.
    """
    left, right, bottom, top = world.extent
    cell_m = max(FINEST_M, math.sqrt((right - left) * (top - bottom) / most_cells))
    block = max(1, math.ceil(cell_m / world.resolution_m - 1e-9))
    inside = world.free != 0
    heights = world.ground_m
    if heights is not None and world.ceiling_m is not None:
        # Breakdown counts as inside: rubble on the floor, with room above it.
        inside = inside | (world.ceiling_m > heights + 0.3)
    pad = math.ceil(RIM_M / (block * world.resolution_m))
    share = _padded(_block_mean(inside.astype(np.float32), block), pad)
    frame = GridFrame(
        left - pad * block * world.resolution_m,
        bottom - pad * block * world.resolution_m,
        block * world.resolution_m,
        *share.shape,
    )
    rock = share < 0.5
    if rock.all():
        rock = share <= 0.0
    away, nearest = distance_transform_edt(rock, return_indices=True)
    if heights is None:
        ground = np.zeros(share.shape, dtype=np.float32)
    else:
        sums = _padded(_block_mean(np.where(inside, heights, 0.0).astype(np.float32), block), pad)
        floor = sums / np.maximum(share, 1e-6)
        spread = floor[nearest[0], nearest[1]]
        smooth = gaussian_filter(spread, 0.8 / frame.cell_m)
        ground = np.where(rock, smooth, floor).astype(np.float32)
    return Relief(frame, ground, share, away * frame.cell_m <= RIM_M)


def _block_mean(raster: NDArray[np.float32], block: int) -> NDArray[np.float32]:
    """Means over blocks; missing cells at the upper and right edge count as 0."""
    rows, columns = (-(-size // block) for size in raster.shape)
    whole = np.zeros((rows * block, columns * block), dtype=np.float32)
    whole[: raster.shape[0], : raster.shape[1]] = raster
    blocks = whole.reshape(rows, block, columns, block)
    return np.asarray(blocks.mean(axis=(1, 3)), dtype=np.float32)


def _padded(raster: NDArray[np.float32], cells: int) -> NDArray[np.float32]:
    wider: NDArray[np.float32] = np.pad(raster, cells)
    return wider
