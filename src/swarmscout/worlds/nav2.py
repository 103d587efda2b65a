"""Worlds from ROS nav2 maps: a YAML file beside an image.

Source: nav2_map_server (ROS 2), its description of the YAML keys and of the three modes.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import yaml
from numpy.typing import NDArray

from swarmscout.core.errors import WorldError, did_you_mean
from swarmscout.worlds.arrays import world_from_array
from swarmscout.worlds.images import read_image
from swarmscout.worlds.resampling import check_length, refined
from swarmscout.worlds.world import World

__all__ = ["load_nav2"]

_KEYS = ("image", "resolution", "origin", "negate", "occupied_thresh", "free_thresh")
_MODES = ("trinary", "scale", "raw")
_UNKNOWN_GREY = 205
_RAW_HIGHEST = 100


def load_nav2(path: Path, resolution_m: float | None) -> World:
    """A world from a nav2 map: what the map calls free is free, unknown is not.

    Args:
        path: the YAML file; the image is found relative to it.
        resolution_m: as for :func:`swarmscout.worlds.resampling.refined`; None keeps the map's
            own where that is at most 0.1 m.

    Raises:
        WorldError: a file is missing or broken, a key is missing or impossible, the map is turned
            (yaw), or nothing is free.
    """
    keys = _read(path)
    cell_m = _number(path, keys, "resolution")
    check_length(f"map '{path}': resolution", cell_m)
    origin = _origin(path, keys)
    image = keys["image"]
    if not isinstance(image, str) or not image:
        raise WorldError(f"map '{path}': image = {image!r}, expected a file name")
    free = np.flipud(_free_pixels(path, keys, *read_image(path.parent / image)))
    if not free.any():
        raise WorldError(
            f"map '{path}': no pixel of '{image}' is free: check negate and free_thresh"
        )
    if resolution_m is not None:
        check_length("resolution_m", resolution_m)
    raster, edge = refined(free.astype(np.uint8), cell_m, resolution_m)
    facts = {"file": path.name, "cell_m": cell_m}
    return world_from_array(raster, edge, name=path.stem, origin_m=origin, source=facts)


def _read(path: Path) -> Mapping[str, Any]:
    try:
        keys = yaml.safe_load(path.read_bytes())
    except OSError as error:
        raise WorldError(f"cannot read the map '{path}': {error.strerror or error}") from None
    except (yaml.YAMLError, ValueError, RecursionError) as error:
        why = " ".join(str(error).split()) or type(error).__name__
        if isinstance(error, RecursionError):
            why = "too many nested brackets"
        raise WorldError(f"map '{path}' is no YAML: {why[:160]}") from None
    if not isinstance(keys, dict):
        raise WorldError(f"map '{path}' is no nav2 map: expected keys {', '.join(_KEYS)}")
    for key in _KEYS:
        if key not in keys:
            near = did_you_mean(key, [str(name) for name in keys if name not in _KEYS])
            hint = f" ({near})" if near.startswith("did") else ""
            raise WorldError(f"map '{path}': key '{key}' is missing{hint}")
    return keys


def _number(path: Path, keys: Mapping[str, Any], key: str) -> float:
    value = _as_number(keys[key])
    if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
        raise WorldError(f"map '{path}': {key} = {value!r}, expected a finite number")
    return float(value)


def _as_number(value: Any) -> Any:
    """A number that YAML 1.1 takes for a text, as ``1e-2`` without a dot; anything else stays."""
    try:
        return float(value) if isinstance(value, str) else value
    except ValueError:
        return value


def _origin(path: Path, keys: Mapping[str, Any]) -> tuple[float, float]:
    given = keys["origin"]
    if isinstance(given, list):
        given = [_as_number(part) for part in given]
    numbers = isinstance(given, list) and all(
        isinstance(part, int | float) and not isinstance(part, bool) and math.isfinite(part)
        for part in given
    )
    if not numbers or len(given) not in (2, 3):
        raise WorldError(f"map '{path}': origin = {given!r}, expected [x, y, yaw] with numbers")
    if len(given) == 3 and given[2] != 0:
        raise WorldError(
            f"map '{path}': origin has yaw = {given[2]:g} rad, only 0 is supported: "
            "turn the image and set yaw to 0"
        )
    return float(given[0]), float(given[1])


def _free_pixels(
    path: Path,
    keys: Mapping[str, Any],
    colours: NDArray[np.float64],
    opaque: NDArray[np.bool_],
) -> NDArray[np.bool_]:
    """bool[rows, cols], row 0 at the top: what nav2 would call free, but for unknown.

    ``raw`` takes the grey value itself for the occupancy in percent (above 100: unknown), whatever
    ``negate`` says, as nav2 does.
    """
    mode = keys.get("mode", "trinary")
    if mode not in _MODES:
        raise WorldError(f"map '{path}': unknown mode {mode!r}: {did_you_mean(str(mode), _MODES)}")
    negate = keys["negate"]
    if negate not in (0, 1):
        raise WorldError(f"map '{path}': negate = {negate!r}, expected 0 or 1")
    free_below = _number(path, keys, "free_thresh")
    occupied_above = _number(path, keys, "occupied_thresh")
    if not 0.0 <= free_below <= occupied_above <= 1.0:
        raise WorldError(
            f"map '{path}': free_thresh = {free_below:g}, occupied_thresh = {occupied_above:g}, "
            "expected 0 <= free_thresh <= occupied_thresh <= 1"
        )
    shade = colours.mean(axis=2)
    if mode == "raw":
        percent = np.rint(shade * 255.0)
        raw: NDArray[np.bool_] = (percent <= _RAW_HIGHEST) & (percent < free_below * 100.0)
        return raw
    # What shows through is unknown; nav2 averages opacity in with the colours in mode trinary,
    # which makes a half transparent white pixel unknown as well.
    occupancy = np.round(shade if negate else 1.0 - shade, 9)
    free: NDArray[np.bool_] = (occupancy < free_below) & opaque
    if mode == "trinary":
        # Map savers paint unknown in this grey, and many then write a free_thresh (0.25) that
        # calls it free. Unknown is not free.
        free &= np.rint(shade * 255.0) != _UNKNOWN_GREY
    return free
