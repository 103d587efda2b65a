"""The cave in 3D as a picture, without any graphics library.

A relief has one height at each point. Seen from above at a slant, a column of the picture is a
walk away from the viewer: a pixel shows the first point on the walk that rises above the line of
sight through it. A running maximum and a binary search per column find all of them at once, so
nothing is sorted and hidden parts cost nothing.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter, map_coordinates

from swarmscout.core.grid import GridFrame
from swarmscout.viewing.map_image import Window
from swarmscout.viewing.palette import DARK, Palette, rgb
from swarmscout.viewing.relief import RIM_M, Relief

__all__ = ["Overview"]

COOL = np.array([0.96, 1.0, 1.05], dtype=np.float32)
"""What is not mapped yet is a little bluish."""
_TILT_RAD = 0.95
_SUN = np.array([-0.45, 0.35, 0.82]) / np.linalg.norm([-0.45, 0.35, 0.82])
_FINE = 4
"""Known cells are smoothed on a grid finer than the map by this factor."""


UNSEEN = 0.34, 0.66
"""Brightness of what is not mapped yet, on a dark and on a light background."""


class Overview:
    """A view of a relief from the south, so that north is up as on the map.

    Args:
        relief: the world to draw.
        window: the part to show.
        width: of the pictures, in pixels.
        height: of the pictures, in pixels.
        frame: the map's frame.
        palette: colours of ground and rock.
        background: colour where the relief has nothing to show; None for the palette's.

    Attributes:
        size: ``(width, height)`` of the pictures, in pixels.
    """

    def __init__(
        self,
        relief: Relief,
        window: Window,
        width: int,
        height: int,
        frame: GridFrame,
        palette: Palette = DARK,
        background: str | None = None,
    ) -> None:
        self.size = (width, height)
        self._relief = relief
        self._frame = frame
        left, right, bottom, top = window
        across, away = right - left, top - bottom
        sine = math.sin(_TILT_RAD)
        room = relief.wall_m + float(np.ptp(relief.ground_m[relief.shown]))
        self.scale = min(width / across, height / (away * sine + room * math.cos(_TILT_RAD)))
        self._middle = np.array([(left + right) / 2, (bottom + top) / 2])
        self._level = float(relief.ground_at(self._middle[None])[0])
        lit, dark, x_m, y_m = self._render(palette, background or palette.background)
        self._base = dark
        self._gain = lit.astype(np.int16) - dark
        fine = self._fine_index(x_m, y_m)
        self._seen = np.flatnonzero(fine >= 0)
        self._fine = fine[self._seen]
        self._seen_gain = self._gain.reshape(-1, 3)[self._seen]

    def picture(self, known: NDArray[np.bool_]) -> NDArray[np.uint8]:
        """uint8[height, width, 3]: the cave with known cells lit.

        Args:
            known: bool[rows, cols] of the map.
        """
        weight = _between(known)
        share = weight[self._fine]
        bright = np.flatnonzero(share)
        picture = self._base.copy()
        flat = picture.reshape(-1, 3)
        gain = self._seen_gain[bright].astype(np.int32) * share[bright, None]
        flat[self._seen[bright]] += (gain >> 8).astype(np.uint8)
        return picture

    def pixels_of(
        self, points_m: NDArray[np.floating], rise_m: float = 0.15
    ) -> NDArray[np.float64]:
        """Pixels ``(x, y)`` [n, 2], y downward, of points on the floor ``(x, y)`` [n, 2]."""
        points = np.asarray(points_m, dtype=np.float64).reshape(-1, 2)
        return self._pixels(points, self._relief.ground_at(points) + rise_m)

    @property
    def flattening(self) -> float:
        """Height of a level circle as seen, divided by its width."""
        return math.sin(_TILT_RAD)

    def _pixels(self, points: NDArray[np.float64], z_m: NDArray[np.float64]) -> NDArray[np.float64]:
        width, height = self.size
        right = (points[:, 0] - self._middle[0]) * self.scale + width / 2
        up = (points[:, 1] - self._middle[1]) * math.sin(_TILT_RAD)
        up = (up + (z_m - self._level) * math.cos(_TILT_RAD)) * self.scale
        return np.column_stack([right, height / 2 - up])

    def _render(
        self, palette: Palette, background: str
    ) -> tuple[NDArray[np.uint8], NDArray[np.uint8], NDArray[np.float64], NDArray[np.float64]]:
        """Lit and dark pictures, and the point seen at each pixel (NaN: none)."""
        width, height = self.size
        sine, cosine = math.sin(_TILT_RAD), math.cos(_TILT_RAD)
        fine = 2  # Each pixel is the mean of 2 × 2.
        frame = self._relief.frame
        across = (np.arange(width * fine) + 0.5 - width * fine / 2) / (self.scale * fine)
        reach = height / (2 * self.scale * sine) + 4.0
        stride_m = 1.0 / self.scale
        away = np.arange(-reach, reach, stride_m)
        fields = _fields_of(self._relief)
        x, y = across[None, :] + self._middle[0], away[:, None] + self._middle[1]

        def sample(
            field: NDArray[np.float32], x: NDArray[Any], y: NDArray[Any], out: float = 0.0
        ) -> NDArray[np.float32]:
            at = np.stack(
                np.broadcast_arrays(
                    np.float32((y - frame.origin_y_m) / frame.cell_m - 0.5),
                    np.float32((x - frame.origin_x_m) / frame.cell_m - 0.5),
                )
            )
            found = map_coordinates(field, at, order=1, mode="constant", cval=out)
            return np.asarray(found, dtype=np.float32)

        z = sample(fields[0], x, y, out=float(fields[0].min()))
        up = ((y - self._middle[1]) * sine + (z - self._level) * cosine) * self.scale * fine
        horizon = np.maximum.accumulate(up, axis=0)
        lines = (height * fine / 2) - (np.arange(height * fine) + 0.5)
        hit = np.empty((height * fine, width * fine), dtype=np.int64)
        for column in range(width * fine):
            hit[:, column] = np.searchsorted(horizon[:, column], lines)
        sky = hit >= len(away)
        hit[sky] = 0
        columns = np.arange(width * fine)[None, :]

        to_y, to_x = np.gradient(z, stride_m, stride_m / fine)
        length = np.sqrt(to_x**2 + to_y**2 + 1.0)
        sun = np.clip((-to_x * _SUN[0] - to_y * _SUN[1] + _SUN[2]) / length, 0.0, 1.0)
        x, y = np.broadcast_to(x, hit.shape), away[hit] + self._middle[1]
        share, light, level, near = (sample(field, x, y) for field in fields[1:])
        sky |= near <= 0.0
        pictures = []
        back = np.array(rgb(background), dtype=np.float32) / 255.0
        for colours in _shade(palette, back, (share, light, level, near), sun[hit, columns]):
            colours[sky] = back
            mean = colours.reshape(height, fine, width, fine, 3).mean(axis=(1, 3))
            pictures.append(np.rint(255.0 * np.clip(mean, 0.0, 1.0)).astype(np.uint8))
        pictures[0] = np.maximum(pictures[0], pictures[1])
        places = [np.where(sky, np.nan, part)[::fine, ::fine] for part in (x, y)]
        return pictures[0], pictures[1], places[0], places[1]

    def _fine_index(self, x_m: NDArray[np.float64], y_m: NDArray[np.float64]) -> NDArray[np.int64]:
        """int64[pixels]: the fine map cell seen at each pixel, or -1."""
        frame = self._frame
        gone = np.isnan(x_m)
        col = np.floor((np.where(gone, 0.0, x_m) - frame.origin_x_m) / frame.cell_m * _FINE)
        row = np.floor((np.where(gone, 0.0, y_m) - frame.origin_y_m) / frame.cell_m * _FINE)
        rows, columns = frame.rows * _FINE, frame.columns * _FINE
        inside = ~gone & (row >= 0) & (col >= 0) & (row < rows) & (col < columns)
        return np.where(inside, row * columns + col, -1).astype(np.int64).ravel()


def _between(known: NDArray[np.bool_]) -> NDArray[np.int16]:
    """int16[fine cells]: 0 … 256, with soft edges between known and unknown cells."""
    steps = (np.arange(_FINE) + 0.5) / _FINE - 0.5  # from the cell's centre, in cells
    lines = known.astype(np.float32)
    for axis in (0, 1):
        near = np.pad(lines, [(1, 1) if a == axis else (0, 0) for a in (0, 1)], mode="edge")
        before, after = (np.take(near, range(k, k + lines.shape[axis]), axis) for k in (0, 2))
        parts = [
            lines * (1 - abs(step)) + (before if step < 0 else after) * abs(step) for step in steps
        ]
        lines = np.stack(parts, axis=axis + 1).reshape(
            *(size * (_FINE if a == axis else 1) for a, size in enumerate(lines.shape))
        )
    weights = np.clip(1.6 * lines - 0.3, 0.0, 1.0) * 256.0
    return np.asarray(weights, dtype=np.int16).ravel()


def _fields_of(relief: Relief) -> tuple[NDArray[np.float32], ...]:
    """Height, open share, light from above, height as a share, nearness to the floor."""
    from scipy.ndimage import distance_transform_edt

    height = relief.height_m()
    share = relief.open_share
    light = np.clip(1.15 * gaussian_filter(share, 0.7 / relief.frame.cell_m), 0.0, 1.0)
    floor = relief.ground_m[share > 0.8]
    low, high = (float(floor.min()), float(floor.max())) if floor.size else (0.0, 0.0)
    flat = high <= low + 0.05
    level = (
        np.full_like(share, 0.8)
        if flat
        else np.clip((relief.ground_m - low) / max(high - low, 1e-6), 0.0, 1.0)
    )
    away = distance_transform_edt(share <= 0.3) * relief.frame.cell_m
    near = np.where(relief.shown, np.clip(1.0 - away / RIM_M, 0.0, 1.0), 0.0)
    base = float(height[relief.shown].min())
    height = np.where(relief.shown, height, base).astype(np.float32)
    return height, share, light, level, near.astype(np.float32)


def _shade(
    palette: Palette,
    back: NDArray[np.float32],
    fields: tuple[NDArray[np.float32], ...],
    sun: NDArray[np.float64],
) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """Colours [..., 3] of explored and of unexplored points."""
    share, light, level, near = fields

    def ramp(low: float, high: float, value: NDArray[np.float32]) -> NDArray[np.float32]:
        t = np.clip((value - low) / (high - low), 0.0, 1.0)
        return np.asarray(t * t * (3.0 - 2.0 * t), dtype=np.float32)[..., None]

    rock = 1.0 - ramp(0.2, 0.8, share)
    top = ramp(0.9, 1.0, rock[..., 0])
    bright = sun.astype(np.float32)[..., None]
    hollow = light[..., None]
    low, high, stone_wall, cut = (
        np.array(rgb(colour), dtype=np.float32) / 255.0
        for colour in (palette.ground_low, palette.ground_high, palette.rock, palette.cut)
    )
    unseen = UNSEEN[int(back.mean() > 0.5)]
    floor = low + (high - low) * level[..., None]
    stone = floor * (1.0 - 0.85 * rock) + stone_wall * 0.85 * rock
    lit = stone * (0.42 + 0.72 * bright) * (0.62 + 0.38 * hollow)
    gray = stone.mean(axis=-1, keepdims=True) * (0.55 + 0.45 * bright) * (0.7 + 0.3 * hollow)
    dark = gray * unseen * COOL
    edge = ramp(0.0, 0.75, near)
    shaded = []
    for colours in (lit, dark):
        solid = colours * (1.0 - top) + cut * top
        shaded.append((back * (1.0 - edge) + solid * edge).astype(np.float32))
    return shaded[0], shaded[1]
