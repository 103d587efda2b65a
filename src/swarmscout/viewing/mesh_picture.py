"""A world's mesh as a picture: the cave from outside, and from inside with a headlamp.

Triangles are drawn into a depth buffer with NumPy alone: every pixel keeps the nearest triangle,
and is shaded afterwards.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from PIL import Image
from scipy import ndimage

from swarmscout.core.errors import ViewError
from swarmscout.worlds.meshes.mesh import Mesh
from swarmscout.worlds.starts import start_of
from swarmscout.worlds.world import World

__all__ = ["mesh_picture"]

_EYE_M = 1.2
_NEAR_M = 0.12
_AT_ONCE = 2_000_000
"""Pixels of triangles handled together; bounds the memory."""
_SKY = np.array([0.80, 0.88, 0.97])
_PAPER = np.array([1.0, 1.0, 1.0])
_ROCK = np.array([0.60, 0.50, 0.42])
_COLOURS = 128
_SLIVER_M = 0.03
_SHARP = 0.8
"""An edge whose sides differ by more than this cosine is drawn as an edge."""

Floats = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class _Camera:
    """Where it stands, and its axes (right, up, back) as rows."""

    eye_m: Floats
    axes: Floats
    focal: float
    """Pixels per metre in 1 m distance, or, without perspective, at any."""
    perspective: bool


def mesh_picture(world: World, path: Path | str, *, width: int = 900) -> Path:
    """Draw a world's mesh from outside, and below that from inside.

    Args:
        world: a world with a mesh.
        path: the picture to write.
        width: pixels across.

    Returns:
        The picture's path.

    Raises:
        ViewError: the world has no mesh, or the picture cannot be written.

    Example:
        mesh_picture(load_world("worlds/mine"), "cave.png")
    """
    mesh = world.mesh
    if mesh is None or not len(mesh.triangles):
        raise ViewError(f"world '{world.name}' has no mesh to draw")
    outside = _drawn(mesh, _from_outside(mesh, width), (round(0.62 * width), width), _PAPER)
    inside = _drawn(mesh, _from_inside(world, width), (round(0.5 * width), width), _SKY)
    picture = Image.fromarray(np.concatenate((outside, inside)))
    # One colour, lit: a palette suffices, and the file is a third as large.
    picture = picture.quantize(_COLOURS, dither=Image.Dither.NONE)
    try:
        picture.save(path, optimize=True)
    except (OSError, ValueError) as error:
        raise ViewError(f"cannot write '{path}': {error}") from None
    return Path(path)


def _from_outside(mesh: Mesh, width: int) -> _Camera:
    """From the south and above, without perspective, so that all of it is seen."""
    low, high = mesh.bounds_m
    tilt = math.radians(52.0)
    back = np.array([0.0, -math.cos(tilt), math.sin(tilt)])
    axes = np.array([[1.0, 0.0, 0.0], np.cross(back, [1.0, 0.0, 0.0]), back])
    size = np.abs(axes[:2]) @ (high - low)
    focal = 0.95 * min(width / size[0], 0.62 * width / size[1])
    return _Camera((low + high) / 2.0 + 1000.0 * back, axes, focal, perspective=False)


def _from_inside(world: World, width: int) -> _Camera:
    """From the start, into the longest passage that can be seen from there."""
    x, y = start_of(world)
    walked = np.arange(0.0, 25.0, world.resolution_m)
    best, heading = 0, 0.0
    for angle in np.arange(0.0, 2.0 * math.pi, 0.05):
        at = np.column_stack((x + walked * math.cos(angle), y + walked * math.sin(angle)))
        cells = np.floor((at - world.origin_m) / world.resolution_m).astype(int)
        inside = np.all((cells >= 0) & (cells < world.free.shape[::-1]), axis=1)
        cells = np.where(np.reshape(inside, (-1, 1)), cells, 0)
        blocked = ~inside | (world.free[cells[:, 1], cells[:, 0]] == 0)
        free = int(np.argmax(blocked)) if np.any(blocked) else len(walked)
        if free > best:
            best, heading = free, float(angle)
    col, row = (
        (part - first) / world.resolution_m
        for part, first in zip((x, y), world.origin_m, strict=True)
    )
    ground = 0.0 if world.ground_m is None else float(world.ground_m[int(row), int(col)])
    pitch = math.radians(-6.0)
    ahead = np.array(
        [math.cos(heading) * math.cos(pitch), math.sin(heading) * math.cos(pitch), math.sin(pitch)]
    )
    right = np.array([math.sin(heading), -math.cos(heading), 0.0])
    axes = np.array([right, np.cross(right, ahead), -ahead])
    eye = np.array([x, y, ground + _EYE_M])
    return _Camera(eye, axes, 0.55 * width, perspective=True)


def _drawn(
    mesh: Mesh, camera: _Camera, size: tuple[int, int], background: Floats
) -> NDArray[np.uint8]:
    """uint8[rows, cols, 3]: what the camera sees."""
    vertices = mesh.vertices_m.astype(np.float64)
    seen, weights = _nearest_triangles(vertices, mesh.triangles, camera, size)
    picture = np.empty((*size, 3))
    picture[:] = background
    hit = seen >= 0
    triangles = mesh.triangles[seen[hit]]
    corners = vertices[triangles]
    weight = weights[hit][:, :, None]
    place = (corners * weight).sum(axis=1)
    flat, smooth = _normals(vertices, mesh.triangles)
    own = flat[seen[hit]][:, None, :]
    bent = smooth[triangles]
    keeps = (bent * own).sum(axis=2, keepdims=True) > _SHARP
    bent = np.where(keeps | _is_sliver(corners)[:, None, None], bent, own)
    normal = _unit((bent * weight).sum(axis=1))
    if camera.perspective:
        away = camera.eye_m + 0.35 * camera.axes[1] - place
        distance = np.sqrt((away * away).sum(axis=1))
        lamp = np.abs((normal * away).sum(axis=1)) / distance
        # Light from above finds its way in where the roof is open; elsewhere the lamp is all.
        light = 0.03 + 1.9 * lamp / (1.0 + 0.02 * distance**2)
        light = 1.15 * (1.0 - np.exp(-light))
    else:
        sun = _unit(np.array([[-0.5, -0.45, 0.75]]))[0]
        light = 0.35 + 0.75 * np.abs(normal @ sun)
        light *= 0.8 + 0.2 * np.abs(normal[:, 2])
    grain = 1.0 + 0.10 * np.clip(normal[:, 2:], -1.0, 1.0)
    picture[hit] = np.clip(_ROCK * grain * 1.35 * light[:, None], 0.0, 1.0)
    softened = ndimage.gaussian_filter(picture, (0.45, 0.45, 0.0))
    return (255.0 * softened).astype(np.uint8)


def _normals(vertices: Floats, triangles: NDArray[np.int32]) -> tuple[Floats, Floats]:
    """Unit normals of triangles [T, 3], and of vertices [V, 3], the mean of theirs."""
    one, two, three = (vertices[triangles[:, k]] for k in range(3))
    area = np.cross(two - one, three - one)
    smooth = np.zeros_like(vertices)
    for axis in range(3):
        for corner in range(3):
            smooth[:, axis] += np.bincount(
                triangles[:, corner], weights=area[:, axis], minlength=len(vertices)
            )
    return _unit(area), _unit(smooth)


def _is_sliver(corners: Floats) -> NDArray[np.bool_]:
    """Triangles [n, 3, 3] too thin to have a normal of their own that means anything."""
    sides = np.roll(corners, -1, axis=1) - corners
    longest = np.sqrt((sides * sides).sum(axis=2)).max(axis=1)
    area = np.cross(sides[:, 0], sides[:, 1])
    return np.asarray(np.sqrt((area * area).sum(axis=1)) < _SLIVER_M * longest, dtype=np.bool_)


def _unit(vectors: Floats) -> Floats:
    length = np.sqrt((vectors * vectors).sum(axis=-1, keepdims=True))
    return np.asarray(vectors / np.maximum(length, 1e-12), dtype=np.float64)


def _nearest_triangles(
    vertices: Floats, triangles: NDArray[np.int32], camera: _Camera, size: tuple[int, int]
) -> tuple[NDArray[np.int64], Floats]:
    """The triangle seen at each pixel [rows, cols], −1 for none, and its corners' weights."""
    rows, columns = size
    local = (vertices - camera.eye_m) @ camera.axes.T
    depth = -local[:, 2]
    with np.errstate(divide="ignore", invalid="ignore"):
        scale = camera.focal / (depth if camera.perspective else np.ones_like(depth))
        x, y = columns / 2 + local[:, 0] * scale, rows / 2 - local[:, 1] * scale
        # What is linear over the picture: one over the depth, or minus the depth.
        nearness = 1.0 / depth if camera.perspective else -depth
    ahead = np.flatnonzero((depth[triangles] > _NEAR_M).all(axis=1))
    tx, ty = x[triangles[ahead]], y[triangles[ahead]]
    left, right = np.ceil(tx.min(axis=1) - 0.5), np.floor(tx.max(axis=1) - 0.5)
    top, bottom = np.ceil(ty.min(axis=1) - 0.5), np.floor(ty.max(axis=1) - 0.5)
    left, right = np.maximum(left, 0), np.minimum(right, columns - 1)
    top, bottom = np.maximum(top, 0), np.minimum(bottom, rows - 1)
    wide = np.maximum(right - left + 1, 0).astype(np.int64)
    count = wide * np.maximum(bottom - top + 1, 0).astype(np.int64)
    nearest = np.full(rows * columns, -np.inf)
    seen = np.full(rows * columns, -1, dtype=np.int64)
    weights = np.zeros((rows * columns, 3))
    total = np.cumsum(count)
    first = 0
    while first < len(ahead):
        before = int(total[first - 1]) if first else 0
        last = max(int(np.searchsorted(total, before + _AT_ONCE)), first + 1)
        part = np.arange(first, last)
        first = last
        which = np.repeat(part, count[part])
        if not len(which):
            continue
        starts = np.repeat(total[part] - count[part], count[part])
        number = np.arange(before, before + len(which)) - starts
        col = (left[which] + number % wide[which]).astype(np.int64)
        row = (top[which] + number // wide[which]).astype(np.int64)
        share, inside = _shares(tx[which], ty[which], col + 0.5, row + 0.5)
        which, share = which[inside], share[inside]
        pixel = (row * columns + col)[inside]
        near = (share * nearness[triangles[ahead[which]]]).sum(axis=1)
        order = np.argsort(near, kind="stable")
        order = order[near[order] > nearest[pixel[order]]]
        # Of several triangles at a pixel the last that is written, the nearest, stays.
        nearest[pixel[order]] = near[order]
        seen[pixel[order]] = ahead[which[order]]
        weights[pixel[order]] = share[order]
    if camera.perspective:
        at = seen >= 0
        weights[at] *= nearness[triangles[seen[at]]]
        weights[at] /= weights[at].sum(axis=1, keepdims=True)
    return seen.reshape(size), weights.reshape((*size, 3))


def _shares(tx: Floats, ty: Floats, x: Floats, y: Floats) -> tuple[Floats, NDArray[np.bool_]]:
    """How much of each corner a point of the picture has [n, 3], and whether it lies inside."""
    area = (tx[:, 1] - tx[:, 0]) * (ty[:, 2] - ty[:, 0]) - (tx[:, 2] - tx[:, 0]) * (
        ty[:, 1] - ty[:, 0]
    )
    with np.errstate(divide="ignore", invalid="ignore"):
        two = (
            (x - tx[:, 0]) * (ty[:, 2] - ty[:, 0]) - (tx[:, 2] - tx[:, 0]) * (y - ty[:, 0])
        ) / area
        three = (
            (tx[:, 1] - tx[:, 0]) * (y - ty[:, 0]) - (x - tx[:, 0]) * (ty[:, 1] - ty[:, 0])
        ) / area
    share = np.column_stack((1.0 - two - three, two, three))
    return share, np.asarray((share >= -1e-9).all(axis=1), dtype=np.bool_)
