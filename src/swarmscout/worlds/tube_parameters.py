"""What a generated lava tube looks like: every choice, with a unit and a sound default."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Literal

from swarmscout.core.errors import WorldError, did_you_mean

__all__ = ["TubeParameters"]

_LIMITS: dict[str, tuple[float, float]] = {
    "seed": (0, 2**63),
    "size_m": (30.0, 1000.0),
    "length_m": (20.0, 5000.0),
    "width_m": (2.0, 30.0),
    "narrowest_m": (1.5, 30.0),
    "widest_m": (2.0, 40.0),
    "width_variation": (0.0, 1.0),
    "winding": (0.0, 2.0),
    "braids": (0, 200),
    "branches": (0, 500),
    "branch_length_m": (8.0, 500.0),
    "pillars": (0, 2000),
    "piles": (0, 2000),
    "roughness_m": (0.0, 1.5),
    "undulation_m": (0.0, 1.0),
    "height_m": (1.0, 30.0),
    "resolution_m": (0.02, 0.5),
}


@dataclass(frozen=True)
class TubeParameters:
    """A lava tube (or a maze of small tubes), ready to be generated.

    Attributes:
        seed: which of all tubes that look like this.
        layout: ``"tube"``: a trunk with braids and branches; ``"maze"``: a net of small tubes.
        size_m: the centre lines stay in a square with this side, in metres.
        length_m: length of the trunk, in metres; it ends earlier where it would run into itself.
            A maze takes as much as its square holds.
        width_m: mean width of the trunk, in metres.
        narrowest_m: no tube is planned narrower, in metres.
        widest_m: no tube is planned wider, in metres.
        width_variation: how much the width varies along a tube, 0 … 1.
        winding: how strongly tubes wind, 0 (straight) … 2.
        braids: arms that leave the trunk and rejoin it; fewer where there is no room.
        branches: blind side tubes; fewer where there is no room.
        branch_length_m: mean length of a branch, in metres.
        pillars: rock left standing in wide places; fewer where none is wide enough.
        piles: breakdown: blocks fallen from the ceiling, too steep to drive over.
        roughness_m: how far walls stray from a smooth outline, in metres.
        undulation_m: how far the ground strays from its mean slope, in metres.
        height_m: height of the ceiling in the middle of the trunk, in metres.
        resolution_m: edge of a raster cell, in metres.

    Raises:
        WorldError: a value is out of its range.

    Example:
        >>> TubeParameters(seed=7, branches=3).layout
        'tube'
    """

    seed: int = 0
    layout: Literal["tube", "maze"] = "tube"
    size_m: float = 108.0
    length_m: float = 230.0
    width_m: float = 6.5
    narrowest_m: float = 3.2
    widest_m: float = 12.0
    width_variation: float = 0.45
    winding: float = 1.0
    braids: int = 2
    branches: int = 9
    branch_length_m: float = 26.0
    pillars: int = 10
    piles: int = 16
    roughness_m: float = 0.6
    undulation_m: float = 0.35
    height_m: float = 3.5
    resolution_m: float = 0.1

    def __post_init__(self) -> None:
        for field in dataclasses.fields(self):
            value = getattr(self, field.name)
            if field.name == "layout":
                if value not in ("tube", "maze"):
                    near = did_you_mean(str(value), ("tube", "maze"))
                    raise WorldError(f"unknown layout '{value}': {near}")
                continue
            low, high = _LIMITS[field.name]
            whole = isinstance(field.default, int)
            right = int if whole else (int, float)
            if isinstance(value, bool) or not isinstance(value, right):
                kind = "a whole number" if whole else "a number"
                raise WorldError(f"{field.name} = {value!r}: expected {kind}")
            if not math.isfinite(value) or not low <= value <= high:
                raise WorldError(f"{field.name} = {value}: expected {low:g} to {high:g}")
        if not self.narrowest_m <= self.width_m <= self.widest_m:
            raise WorldError(
                f"width_m = {self.width_m:g}: expected narrowest_m = {self.narrowest_m:g} to "
                f"widest_m = {self.widest_m:g}"
            )

    @classmethod
    def of(cls, source: Mapping[str, Any]) -> TubeParameters:
        """The parameters of a generated world, out of what it says of its source.

        Raises:
            WorldError: a value is out of its range.
        """
        names = [field.name for field in dataclasses.fields(cls)]
        return cls(**{name: source[name] for name in names if name in source})
