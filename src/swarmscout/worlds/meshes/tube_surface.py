"""The lava tube as a field in space: positive in the open, negative in rock.

The field is made of the same depth, floor and rubble as the tube's rasters, so that both agree by
construction: the floor is the ground, the roof the ceiling, and at a sensor's height the wall
stands where the depth changes its sign. Above that height walls bulge into the rock and bend over
into the roof, with ledges such as flowing lava leaves.

Heights count from the ground below (the field's *base*). A floor that rises and falls is level in
these coordinates, so that a coarse grid meets it exactly.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from swarmscout.core.streams import stream
from swarmscout.worlds.meshes.skylights import Skylight, shaft
from swarmscout.worlds.noise import noise_field
from swarmscout.worlds.tube import (
    LOWEST_M,
    ROOF_SWELLS,
    STEEP_M,
    WALL_HEIGHT_M,
    TubeFields,
    roof_height_m,
)
from swarmscout.worlds.tube_parameters import TubeParameters

__all__ = ["TubeSurface", "breakdown_cells"]

_WALLS = 9
_SENSOR_CLEAR_M = 0.22
"""Up to this height above the ground walls stand upright, as the raster has them."""
_BULGE_M = 0.45
_FILLET_M = 0.14
"""How softly walls run out into the floor."""
_LEDGE_M, _LEDGE_EVERY_M = 0.055, 0.8
_MOUND_M = 0.25
"""Ground under breakdown rises at most so much above what is too steep; blocks stand on it."""
_NUDGE_M = 1e-3
"""No value lies nearer to 0, so that no vertex falls upon a corner of the grid."""
_REACH_M = 1.0
"""Values are cut off here: only their sign counts further away."""

Floats = NDArray[np.float32]


def breakdown_cells(fields: TubeFields) -> NDArray[np.bool_]:
    """Cells in a tube that breakdown keeps robots from: bool[rows, cols].

    Steep cells, and pockets behind them that no robot can get to.
    """
    inside = (fields.depth_m > 0.0) & (fields.free == 0)
    labels, count = ndimage.label(inside)
    steep = np.zeros(count + 1, dtype=np.bool_)
    steep[labels[inside & (fields.rubble_m > STEEP_M)]] = True
    steep[0] = False
    return np.asarray(steep[labels], dtype=np.bool_)


class TubeSurface:
    """The field on a grid of points, and where its points lie.

    Args:
        fields: what the tube's rasters are made of.
        parameters: the tube's looks.
        step_m: distance of points across, in metres.
        skylights: holes in the roof.

    Attributes:
        shape: rows and columns of points.
        levels_m: float64[levels], heights of points above the base; finer near the ground.
        base_m: float64[rows, cols] of the raster: the ground, with mounds under breakdown.
    """

    def __init__(
        self,
        fields: TubeFields,
        parameters: TubeParameters,
        step_m: float,
        skylights: list[Skylight],
    ) -> None:
        self.step_m = step_m
        self._parameters = parameters
        self._resolution_m = resolution = parameters.resolution_m
        rows, columns = fields.depth_m.shape
        self._ratio = step_m / resolution
        self.shape = (int((rows - 1) / self._ratio) + 1, int((columns - 1) / self._ratio) + 1)
        mound = np.minimum(fields.rubble_m, STEEP_M) + _MOUND_M * (
            1.0 - 1.0 / (1.0 + np.maximum(fields.rubble_m - STEEP_M, 0.0) / _MOUND_M)
        )
        self.base_m = fields.floor_m + mound
        self._depth = self._sampled(_depth_of_free(fields))
        into_rock = ndimage.distance_transform_edt(self._depth <= 0.0) * step_m
        # Noise may bring deep rock near to 0, where walls that bulge would meet each other.
        deep = into_rock >= 2.0 * step_m
        self._depth[deep] = np.minimum(self._depth[deep], -0.8 * into_rock[deep])
        hills = self._sampled(fields.hills)
        self._mound = self._sampled(mound)
        self._swell = 1.0 + ROOF_SWELLS * hills
        roof = roof_height_m(self._depth, hills, parameters) - self._mound
        self._roof = np.where(self._depth > 0.0, np.maximum(roof, LOWEST_M), 0.0)
        self._flatness = self._flat_roof()
        self._bulge_top = WALL_HEIGHT_M + 0.3 * (parameters.height_m - WALL_HEIGHT_M)
        rng = stream(parameters.seed, "world", _WALLS)
        place = (columns * resolution, rows * resolution)
        noise = [
            self._sampled(noise_field(rng, *place, wavelength, (rows, columns), resolution))
            for wavelength in (3.0, 1.3, 1.3)
        ]
        most = np.minimum(_BULGE_M, 0.4 * _thickness_m(into_rock, step_m))
        self._bulge = np.clip(0.5 + 0.7 * noise[0], 0.1, 1.0) * most
        self._ledges = noise[1], noise[2]
        self._skylights = skylights
        self._spare_m = 2.0 * step_m + 4.0 * _LEDGE_M
        self.levels_m = self._levels_m()

    def _levels_m(self) -> NDArray[np.float64]:
        """Heights of points, up to above the highest roof, or to the sky."""
        tallest = max(float(self._roof.max()), self._bulge_top * float(self._swell.max()))
        top = tallest + self._spare_m
        # The floor lies half way between two levels, close together: sharp where it meets a wall.
        near = np.array([-0.25, 0.25, 0.5, 1.0, 1.5, 2.0]) * self.step_m
        above = np.arange(3.0, max(top / self.step_m, 3.0) + 1.0) * self.step_m
        levels = np.concatenate((near, above))
        sky = max((skylight.top_m for skylight in self._skylights), default=0.0)
        more = np.arange(levels[-1] + self.step_m, sky + self.step_m, self.step_m)
        return np.concatenate((levels, more)) if self._skylights else levels

    def is_solid(self, rows: slice, columns: slice) -> bool:
        """Whether there is nothing but rock round these columns of points."""
        return float(self._depth[rows, columns].max()) < -(_BULGE_M + 4.0 * _LEDGE_M)

    def values(self, rows: slice, columns: slice) -> Floats:
        """The field, about the distance from the surface in metres, near it.

        Args:
            rows: rows of points.
            columns: columns of points.

        Returns:
            float32[rows, cols, levels], as many levels as are needed.
        """
        window = (rows, columns)
        near = [s for s in self._skylights if self._meets(s, rows, columns)]
        tallest = max(float(self._roof[window].max()), self._bulge_top * 1.3) + self._spare_m
        count = len(self.levels_m) if near else int(np.searchsorted(self.levels_m, tallest)) + 1
        level = self.levels_m[:count].astype(np.float32)
        depth, mound, swell, roof, flat, bulge, ledge, other_ledge = (
            field[window].astype(np.float32)[:, :, None]
            for field in (
                self._depth, self._mound, self._swell, self._roof, self._flatness, self._bulge,
                *self._ledges,
            )
        )  # fmt: skip
        up = (level + mound) / swell
        arch = self._parameters.height_m - WALL_HEIGHT_M
        rise = np.maximum((up - WALL_HEIGHT_M) / arch, 0.0)
        inside = 1.0 - np.sqrt(np.maximum(1.0 - rise * rise, 0.0))
        # Above the crown no depth is deep enough, the less the higher.
        lack = arch * np.maximum(rise - 1.0, 0.0)
        sideways = depth - 0.5 * self._parameters.width_m * inside - lack
        part = (level - _SENSOR_CLEAR_M) / (self._bulge_top - _SENSOR_CLEAR_M)
        part = np.clip(part, 0.0, 1.0)
        sideways += bulge * (16.0 * part * part * (1.0 - part) ** 2)
        overhead = roof - level
        # Where a line crosses one axis so far away and the other so far, it is so near.
        distance = sideways * overhead / np.sqrt(sideways**2 + overhead**2 + 1e-9)
        both = np.where(
            (sideways > 0.0) & (overhead > 0.0), distance, np.minimum(sideways, overhead)
        )
        # In the rock above a flat roof the wall may be near by in this measure, but is not.
        above = np.minimum(-distance, overhead * flat)
        both = np.where((sideways < 0.0) & (overhead < 0.0), above, both)
        blend = np.clip((up - self._bulge_top) / min(0.4, 0.25 * arch), 0.0, 1.0)
        value = sideways + (both - sideways) * blend
        turn = 2.0 * math.pi / _LEDGE_EVERY_M * level
        strong = np.clip((level - _SENSOR_CLEAR_M) / 0.3, 0.0, 1.0)
        value += _LEDGE_M * strong * (ledge * np.cos(turn) + other_ledge * np.sin(turn))
        value = _smooth_least(value, level, _FILLET_M)
        for skylight in near:
            x_m, y_m = self.places_m(rows, columns)
            open_above = shaft(skylight, x_m, y_m, level)
            value = -_smooth_least(-value, -open_above.astype(np.float32), 2.0 * _FILLET_M)
        value = np.clip(value, -_REACH_M, _REACH_M)
        nudged = np.where(value < 0.0, np.float32(-_NUDGE_M), np.float32(_NUDGE_M))
        return np.where(np.abs(value) < _NUDGE_M, nudged, value).astype(np.float32)

    def places_m(
        self, rows: slice, columns: slice
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """X of columns [cols] and y of rows [rows] of points, in metres."""
        half = self._resolution_m / 2.0
        y, x = (np.arange(part.start, part.stop) * self.step_m + half for part in (rows, columns))
        return x, y

    def vertices_m(self, at: NDArray[np.float64]) -> NDArray[np.float64]:
        """Places (x, y, z) [n, 3] in metres of points at (row, column, level) [n, 3]."""
        cells = at[:, :2].T * self._ratio
        base = ndimage.map_coordinates(self.base_m, cells, order=1, mode="nearest")
        above = np.interp(at[:, 2], np.arange(len(self.levels_m)), self.levels_m)
        half = self._resolution_m / 2.0
        x, y = at[:, 1] * self.step_m + half, at[:, 0] * self.step_m + half
        return np.column_stack((x, y, base + above))

    def _meets(self, skylight: Skylight, rows: slice, columns: slice) -> bool:
        x_m, y_m = self.places_m(rows, columns)
        reach = skylight.reach_m + self.step_m
        return bool(
            x_m[0] - reach < skylight.x_m < x_m[-1] + reach
            and y_m[0] - reach < skylight.y_m < y_m[-1] + reach
        )

    def _sampled(self, raster: NDArray[np.float64]) -> NDArray[np.float64]:
        """A raster's values at the grid's points; the first lies on the first cell's centre."""
        at = [np.arange(count) * self._ratio for count in self.shape]
        if self._ratio == round(self._ratio):
            every = round(self._ratio)
            return raster[::every, ::every][: self.shape[0], : self.shape[1]].copy()
        rows, columns = np.meshgrid(*at, indexing="ij")
        sampled: NDArray[np.float64] = ndimage.map_coordinates(
            raster, (rows, columns), order=1, mode="nearest"
        )
        return sampled

    def _flat_roof(self) -> NDArray[np.float64]:
        """0 … 1, the cosine of the roof's slope over each point; 1 where it is level."""
        half = 0.5 * self._parameters.width_m
        inside = np.clip(self._depth / half, 0.0, 1.0)
        steep = (self._parameters.height_m - WALL_HEIGHT_M) / half * (1.0 - inside)
        steep /= np.sqrt(inside * (2.0 - inside) + 1e-6)
        return np.asarray(1.0 / np.sqrt(1.0 + steep * steep), dtype=np.float64)


def _thickness_m(into_rock_m: NDArray[np.float64], step_m: float) -> NDArray[np.float64]:
    """Half of how thick the rock behind walls is: thin walls get no windows, pillars stay whole."""
    reach = 2 * math.ceil(0.7 / step_m) + 1
    near = ndimage.maximum_filter(into_rock_m, size=reach)
    smooth: NDArray[np.float64] = ndimage.gaussian_filter(near, 0.4 / step_m, truncate=3.0)
    return smooth


def _depth_of_free(fields: TubeFields) -> NDArray[np.float64]:
    """The depth, corrected where the world differs: pockets are rock, specks of rock are open."""
    depth = fields.depth_m.copy()
    pockets = (depth > 0.0) & (fields.free == 0) & ~breakdown_cells(fields)
    depth[pockets] = -np.maximum(depth[pockets], 0.05)
    specks = (depth <= 0.0) & (fields.free != 0)
    depth[specks] = np.maximum(-depth[specks], 0.05)
    return depth


def _smooth_least(one: Floats, other: Floats, round_m: float) -> Floats:
    """The lesser of two, with a rounded corner where they meet."""
    blend = np.maximum(round_m - np.abs(one - other), 0.0)
    least: Floats = np.minimum(one, other) - blend * blend / (4.0 * round_m)
    return least
