"""Lava tubes: from a plan of passages to a world with ground and ceiling.

A raster holds, for each point, how deep it lies inside a tube: the largest of half width minus
distance to the centre line over all passages. Noise roughens that depth; it is positive in the
tube. Noise never closes the core along each centre line, so tubes do not pinch off.
"""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from swarmscout.core.streams import stream
from swarmscout.worlds.breakdown import fallen_blocks, pillars
from swarmscout.worlds.noise import Lattice, as_floats, noise_field
from swarmscout.worlds.passages import Passage
from swarmscout.worlds.tube_depth import depth_and_core
from swarmscout.worlds.tube_maze import plan_maze
from swarmscout.worlds.tube_parameters import TubeParameters
from swarmscout.worlds.tube_plan import plan_tube
from swarmscout.worlds.world import World, raster_digest

__all__ = [
    "LOWEST_M",
    "ROOF_SWELLS",
    "RULES",
    "STEEP_M",
    "WALL_HEIGHT_M",
    "TubeFields",
    "generate_tube",
    "roof_height_m",
    "tube_fields",
]

RULES = 1
"""Goes up when the same parameters give another world."""

_NOISE, _HEIGHTS = 7, 8
_STEP_M = 0.5
_BORDER_M = 2.5
_MOUTH_AT = 4
"""Points (metres) from the end of the first passage to the start, in the middle of the mouth."""
_SPECK_M2 = 0.25
LOWEST_M = 0.6
WALL_HEIGHT_M = 0.9
"""How high the roof's arch springs from the walls."""
ROOF_SWELLS = 0.12
"""How much higher the roof is where the floor's swelling is 1."""
STEEP_M = 0.2
"""Blocks higher than this above the ground are not driven over."""


@dataclass(frozen=True, eq=False)
class TubeFields:
    """What a tube's rasters are made of, at the centres of their cells.

    Attributes:
        passages: the plan, in the world's frame; the first point of the first one is the mouth.
        depth_m: float64[rows, cols], how deep inside a tube; negative in rock.
        rubble_m: float64[rows, cols], height of breakdown above the floor.
        floor_m: float64[rows, cols], height of the floor without breakdown, in rock too.
        hills: float64[rows, cols], the floor's swelling, about −1 … 1; the roof swells with it.
        free: uint8[rows, cols], 1 where a robot may be.
        ground_m: float32[rows, cols], height of the ground.
        ceiling_m: float32[rows, cols], height of the ceiling; in rock it lies on the ground.
        start_m: ``(x, y)`` in the middle of the mouth.
    """

    passages: list[Passage]
    depth_m: NDArray[np.float64]
    rubble_m: NDArray[np.float64]
    floor_m: NDArray[np.float64]
    hills: NDArray[np.float64]
    free: NDArray[np.uint8]
    ground_m: NDArray[np.float32]
    ceiling_m: NDArray[np.float32]
    start_m: tuple[float, float]


def generate_tube(parameters: TubeParameters, name: str = "tube") -> World:
    """Generate a lava tube.

    Args:
        parameters: its looks and its seed; the same parameters give the same world, bit for bit.
        name: what to call it.

    Returns:
        A world with ground and ceiling, whose start is the mouth and whose lower left corner is
        (0, 0). All that is free is connected.
    """
    fields = tube_fields(parameters)
    for raster in (fields.free, fields.ground_m, fields.ceiling_m):
        raster.setflags(write=False)
    origin_m = (0.0, 0.0)
    digest = raster_digest(fields.free, parameters.resolution_m, origin_m)
    return World(
        name=name,
        free=fields.free,
        resolution_m=parameters.resolution_m,
        origin_m=origin_m,
        start_m=fields.start_m,
        ground_m=fields.ground_m,
        ceiling_m=fields.ceiling_m,
        source={
            "generator": "lava-tube", "rules": RULES, **dataclasses.asdict(parameters),
            "digest": digest,
        },
    )  # fmt: skip


def tube_fields(parameters: TubeParameters) -> TubeFields:
    """The fields that a tube's rasters, and its mesh, are made of.

    Args:
        parameters: its looks and its seed.

    Returns:
        The fields; the lower left corner of their rasters is (0, 0).
    """
    passages = plan_maze(parameters) if parameters.layout == "maze" else plan_tube(parameters)
    passages, width_m, height_m = _moved_to_corner(passages)
    resolution = parameters.resolution_m
    shape = (round(height_m / resolution), round(width_m / resolution))
    lattice = Lattice(width_m, height_m, _STEP_M)
    depth, core = depth_and_core(lattice, passages)
    rng = stream(parameters.seed, "world", _NOISE)
    start = passages[0].points_m[_MOUTH_AT]

    depth = np.minimum(depth, pillars(lattice, passages, parameters))
    rough = parameters.roughness_m
    for share, wavelength in ((0.9, 7.0), (0.55, 3.0)):
        swell = noise_field(rng, width_m, height_m, wavelength, *_lattice_cells(lattice))
        depth = depth + share * rough * swell
    blocks = fallen_blocks(lattice, passages, parameters)
    coarse = np.maximum(depth, core)
    fine = lattice.at_cells(coarse, shape, resolution)
    for share, wavelength in ((0.3, 1.3), (0.14, 0.5)):
        fine += share * rough * noise_field(rng, width_m, height_m, wavelength, shape, resolution)
    fine = np.round(fine, 6)

    heights = _Heights(parameters, width_m, height_m, shape)
    rubble = heights.rubble(lattice.at_cells(blocks, shape, resolution, smooth=True))
    free = _connected((fine > 0.0) & (rubble <= STEEP_M), start, resolution)
    floor = heights.floor()
    ground, ceiling = heights.ground_and_ceiling(free, fine, rubble, floor)
    return TubeFields(
        passages=passages,
        depth_m=fine,
        rubble_m=rubble,
        floor_m=floor,
        hills=heights.hills,
        free=free,
        ground_m=ground,
        ceiling_m=ceiling,
        start_m=(float(start[0]), float(start[1])),
    )


def roof_height_m(
    depth_m: NDArray[np.float64], hills: NDArray[np.float64], parameters: TubeParameters
) -> NDArray[np.float64]:
    """Height of the roof above the floor: an arch over the depth; 0 in rock.

    Args:
        depth_m: how deep inside the tube, of any shape.
        hills: the floor's swelling at the same places.
        parameters: the tube's looks.
    """
    inside = np.clip(depth_m / (0.5 * parameters.width_m), 0.0, 1.0)
    arch = np.sqrt(inside * (2.0 - inside))
    least = WALL_HEIGHT_M
    height = np.where(depth_m > 0.0, least + (parameters.height_m - least) * arch, 0.0)
    return as_floats(height * (1.0 + ROOF_SWELLS * hills))


def _moved_to_corner(passages: list[Passage]) -> tuple[list[Passage], float, float]:
    """Shift the plan so that the raster begins at (0, 0); its width and height in metres."""
    outer = np.concatenate([passage.half_widths_m for passage in passages])[:, None] + _BORDER_M
    points = np.concatenate([passage.points_m for passage in passages])
    low, high = np.floor((points - outer).min(axis=0)), np.ceil((points + outer).max(axis=0))
    moved = [
        dataclasses.replace(passage, points_m=np.round(passage.points_m - low, 6))
        for passage in passages
    ]
    return moved, float(high[0] - low[0]), float(high[1] - low[1])


def _lattice_cells(lattice: Lattice) -> tuple[tuple[int, int], float]:
    return lattice.shape, lattice.step_m


def _connected(
    open_cells: NDArray[np.bool_], start: NDArray[np.float64], resolution_m: float
) -> NDArray[np.uint8]:
    """What is connected with the start; specks of rock too small to matter are taken out."""
    rocks, count = ndimage.label(~open_cells)
    sizes = np.bincount(rocks.ravel(), minlength=count + 1)
    sizes[0] = 0
    specks = (sizes > 0) & (sizes * resolution_m**2 < _SPECK_M2)
    labels, _ = ndimage.label(open_cells | specks[rocks])
    own = labels[int(start[1] / resolution_m), int(start[0] / resolution_m)]
    free: NDArray[np.uint8] = (labels == own).astype(np.uint8)
    return free


class _Heights:
    """Ground and ceiling of one tube."""

    def __init__(
        self, parameters: TubeParameters, width_m: float, height_m: float, shape: tuple[int, int]
    ) -> None:
        self.parameters = parameters
        rng = stream(parameters.seed, "world", _HEIGHTS)
        place = (width_m, height_m)
        resolution = parameters.resolution_m
        self.slope = rng.uniform(-0.02, 0.02, size=2)
        self.hills = 0.7 * noise_field(rng, *place, 14.0, shape, resolution)
        self.hills += 0.25 * noise_field(rng, *place, 5.0, shape, resolution)
        self.grain = noise_field(rng, *place, 0.7, shape, resolution)

    def rubble(self, blocks: NDArray[np.float64]) -> NDArray[np.float64]:
        """Height of breakdown above the ground, in metres, with its ragged surface."""
        ragged = blocks + 0.35 * self.grain * np.minimum(blocks, 0.5)
        return as_floats(np.round(np.maximum(ragged, 0.0), 6))

    def floor(self) -> NDArray[np.float64]:
        """float64[rows, cols], height of the floor without breakdown, in metres."""
        rows, columns = self.hills.shape
        resolution = self.parameters.resolution_m
        x = (np.arange(columns) + 0.5)[None, :] * resolution
        y = (np.arange(rows) + 0.5)[:, None] * resolution
        floor = self.slope[0] * x + self.slope[1] * y
        return as_floats(floor + self.parameters.undulation_m * (self.hills + 0.06 * self.grain))

    def ground_and_ceiling(
        self,
        free: NDArray[np.uint8],
        depth: NDArray[np.float64],
        rubble: NDArray[np.float64],
        floor: NDArray[np.float64],
    ) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
        """float32[rows, cols] each; in rock the ceiling lies on the ground."""
        height = roof_height_m(depth, self.hills, self.parameters)
        ground = floor + rubble * (depth > 0.0)
        # Where specks of rock were taken out, a robot must pass below the ceiling all the same.
        ceiling = np.maximum(floor + height, ground + LOWEST_M * free)
        return np.round(ground, 4).astype(np.float32), np.round(ceiling, 4).astype(np.float32)
