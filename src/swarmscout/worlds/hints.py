"""Hints about worlds that were read from maps, arrays or images and may be misread."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from swarmscout.worlds.morphology import covered_by, fits, parts
from swarmscout.worlds.reachability import reachable
from swarmscout.worlds.starts import start_of
from swarmscout.worlds.world import World

__all__ = ["Hint", "inside_hint", "inverted_hint"]

_RADIUS_M = 0.15
_LEAST_M2, _LEAST_SHARE = 4.0, 0.02
"""A region that is smaller, absolutely or against the one that was chosen, is not reported."""
_THIN_M = 0.8
"""Free space that is hardly anywhere wider than this looks like walls."""
_ROOMIER = 2.5
_MOST_EDGE = 0.8


@dataclass(frozen=True)
class Hint:
    """A reading of a file that may be wrong.

    Attributes:
        text: one line.
        start_m: a start ``(x, y)`` that it proposes, in metres, or None.
    """

    text: str
    start_m: tuple[float, float] | None = None


def inside_hint(world: World) -> Hint | None:
    """Whether missions would start outside a building: a start inside is proposed.

    Args:
        world: a world whose start was not given by hand.
    """
    reach = reachable(world) != 0
    if not _on_edge(reach).any():
        return None
    largest, area_m2 = _enclosed(world.free != 0, world.resolution_m)
    reach_m2 = float(np.count_nonzero(reach)) * world.resolution_m**2
    if largest is None or area_m2 < max(_LEAST_M2, _LEAST_SHARE * reach_m2):
        return None
    inside = dataclasses.replace(world, free=(largest & (world.free != 0)), start_m=None)
    x, y = start_of(inside)
    return Hint(
        f"the largest region ({reach_m2:,.0f} m²) touches the edge of the map and may lie outside; "
        f"{area_m2:,.0f} m² lie inside: --start {x:.2f},{y:.2f} starts there",
        (x, y),
    )


def inverted_hint(world: World) -> Hint | None:
    """Whether what is free looks like walls: the file may have the other meaning.

    Args:
        world: a world; only arrays and images whose meaning was assumed are looked at.
    """
    meaning = world.source.get("meaning")
    if meaning is None:
        return None
    free = world.free != 0
    cell_m2 = world.resolution_m**2
    other, area_m2 = _enclosed(~free, world.resolution_m)
    if other is None or area_m2 < _LEAST_M2:
        return None
    free_m, other_m = (_usual_width_m(cells, world.resolution_m) for cells in (free, other))
    thin = free_m < _THIN_M and other_m > _ROOMIER * free_m
    around = bool(_on_edge(free).mean() > _MOST_EDGE)
    if not (thin or around):
        return None
    all_m2 = float(np.count_nonzero(~free)) * cell_m2
    looks = "is thin as walls are" if thin else "surrounds all else"
    option = "--free 0" if meaning == "1 is free" else "--free 0..100"
    return Hint(
        f"what is free ({np.count_nonzero(free) * cell_m2:,.1f} m²) {looks}: here {meaning}; if it "
        f"is the other way round, {option} gives {all_m2:,.1f} m²"
    )


def _enclosed(
    cells: NDArray[np.bool_], resolution_m: float
) -> tuple[NDArray[np.bool_] | None, float]:
    """The largest region with room for a robot that does not touch the edge, and its area in m²."""
    labels = parts(fits(cells.astype(np.uint8), resolution_m, _RADIUS_M))
    sizes = np.bincount(labels.ravel())
    # A body that touches the edge stands with its centre in this row, or nearer.
    margin = int(np.ceil(_RADIUS_M / resolution_m - 0.5 - 1e-9)) + 1
    sizes[np.unique(_on_edge(labels, margin))] = 0
    sizes[0] = 0
    if not sizes.any():
        return None, 0.0
    region = covered_by(labels == int(np.argmax(sizes)), resolution_m, _RADIUS_M) & cells
    return region, float(np.count_nonzero(region)) * resolution_m**2


def _on_edge(raster: NDArray[np.generic], margin: int = 1) -> NDArray[np.generic]:
    """The values at the edge of a raster, in one row."""
    sides = (raster[:margin], raster[-margin:], raster[:, :margin], raster[:, -margin:])
    return np.concatenate([side.ravel() for side in sides])


def _usual_width_m(cells: NDArray[np.bool_], resolution_m: float) -> float:
    """Twice the distance to the border of a region that 95 % of its cells do not exceed."""
    if not cells.any():
        return 0.0
    room = ndimage.distance_transform_edt(np.pad(cells, 1))[1:-1, 1:-1]
    return float(2.0 * np.quantile(room[cells], 0.95) - 1.0) * resolution_m
