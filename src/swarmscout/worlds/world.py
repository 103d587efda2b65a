"""A world: the ground truth, read by sensors, motion and judging only.

Rasters are aligned and index ``[row, col]`` with row 0 at the lowest y. What lies outside the
rasters is wall.
"""

from __future__ import annotations

import hashlib
import reprlib
from collections.abc import Callable, Hashable, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from swarmscout.core.errors import WorldError
from swarmscout.core.grid import GridFrame
from swarmscout.worlds.meshes.mesh import Mesh

__all__ = ["World", "raster_digest", "shown"]

T = TypeVar("T")


@dataclass(frozen=True, eq=False)
class World:
    """An unknown place.

    Attributes:
        name: for people.
        free: uint8[rows, cols], C-contiguous: 1 where a robot may be, 0 for wall or unknown.
        resolution_m: edge of a raster cell, in metres.
        origin_m: ``(x, y)`` of the lower left corner of the raster, in metres.
        start_m: ``(x, y)`` of the point round which a mission starts, in metres.
        stations_m: float64[k, 2], charging stations set by hand, or None: derived for a
            number of robots by :func:`swarmscout.worlds.placement.place_stations`.
        ground_m: float32[rows, cols] height of the ground, or None for a flat floor at 0.
        ceiling_m: float32[rows, cols] height of the ceiling, or None for open sky.
        mesh: the cave's surface in 3D, for exact sensing, or None.
        source: where it came from: generator and parameters, or file, and the ``digest`` of the
            raster then. ``notes`` says what a reader decided that a user should know.
    """

    name: str
    free: NDArray[np.uint8] = field(repr=False)
    resolution_m: float
    origin_m: tuple[float, float] = (0.0, 0.0)
    start_m: tuple[float, float] | None = None
    stations_m: NDArray[np.float64] | None = None
    ground_m: NDArray[np.float32] | None = field(default=None, repr=False)
    ceiling_m: NDArray[np.float32] | None = field(default=None, repr=False)
    mesh: Mesh | None = field(default=None, repr=False)
    source: Mapping[str, Any] = field(default_factory=dict)
    _memo: dict[Any, Any] = field(default_factory=dict, init=False, repr=False)

    def __post_init__(self) -> None:
        """Freeze the raster and take places as floats: a world does not change.

        What else may be wrong with a world made by hand, ``check_world`` says.

        Raises:
            WorldError: a place or the resolution is not a number.
        """
        free = np.asarray(self.free)
        if free.dtype == np.uint8 or free.dtype == np.bool_:
            frozen = np.array(
                free, dtype=np.uint8, order="C", copy=None if _is_frozen(free) else True
            )
            frozen.setflags(write=False)
            object.__setattr__(self, "free", frozen)
        for name in ("origin_m", "start_m"):
            place = getattr(self, name)
            if place is not None:
                object.__setattr__(self, name, self._numbers(name, place, 2))
        (resolution_m,) = self._numbers("resolution_m", (self.resolution_m,), 1)
        object.__setattr__(self, "resolution_m", resolution_m)

    def _numbers(self, name: str, given: Any, count: int) -> tuple[float, ...]:
        try:
            numbers = tuple(float(part) for part in given)
        except (TypeError, ValueError, OverflowError):
            numbers = ()
        if len(numbers) != count:
            expected, value = ("x, y in metres", given) if count == 2 else ("metres", *given)
            raise WorldError(f"world '{self.name}': {name} = {shown(value)}: expected {expected}")
        return numbers

    def __getstate__(self) -> dict[str, Any]:
        """What a copy in another process needs: not what can be computed again."""
        return {**self.__dict__, "_memo": {}}

    def once(self, key: Hashable, compute: Callable[[], T]) -> T:
        """A value that depends on this world alone, computed on first use and kept with it.

        Args:
            key: names the value and the parameters that it depends on.
            compute: returns the value; it is not called again for the same key.
        """
        if key not in self._memo:
            self._memo[key] = compute()
        value: T = self._memo[key]
        return value

    @property
    def frame(self) -> GridFrame:
        """Where the raster lies."""
        rows, columns = self.free.shape
        return GridFrame(*self.origin_m, self.resolution_m, rows, columns)

    @property
    def extent(self) -> tuple[float, float, float, float]:
        """``(left, right, bottom, top)`` in metres."""
        return self.frame.extent

    @cached_property
    def digest(self) -> str:
        """SHA-256 (hexadecimal) of the free raster and where it lies."""
        return raster_digest(self.free, self.resolution_m, self.origin_m)


def shown(value: object) -> str:
    """A value in an error message, cut short where it is long."""
    try:
        return reprlib.repr(value)
    except ValueError:  # Python converts no more than 4,300 digits.
        return "a number of thousands of digits"


def raster_digest(
    free: NDArray[np.uint8], resolution_m: float, origin_m: tuple[float, float]
) -> str:
    """SHA-256 (hexadecimal) of a free raster and where it lies.

    Args:
        free: uint8[rows, cols].
        resolution_m: edge of a cell, in metres.
        origin_m: ``(x, y)`` of the lower left corner, in metres.
    """
    place = f"{free.shape} {resolution_m!r} {origin_m[0]!r} {origin_m[1]!r}"
    packed = np.packbits(np.ascontiguousarray(free) != 0)
    return hashlib.sha256(place.encode() + packed.tobytes()).hexdigest()


def _is_frozen(array: NDArray[Any]) -> bool:
    """Whether an array cannot be written to, so that it need not be copied."""
    return not array.flags.writeable and array.flags.owndata
