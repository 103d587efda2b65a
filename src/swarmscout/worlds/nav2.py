"""Worlds from ROS nav2 maps: a YAML file beside an image.

Source: nav2_map_server (ROS 2), ``map_io.cpp`` and its description of the YAML keys and modes.
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import yaml
from numpy.typing import NDArray

from swarmscout.core.errors import WorldError, did_you_mean
from swarmscout.worlds.arrays import world_from_array
from swarmscout.worlds.images import UNKNOWN_GREY, read_image
from swarmscout.worlds.resampling import check_length, refined, turned
from swarmscout.worlds.world import World

__all__ = ["load_nav2"]

_KEYS = ("image", "resolution", "origin", "negate", "occupied_thresh", "free_thresh")
_MODES = ("trinary", "scale", "raw")
_NEGATE = {
    "0": False, "1": True, "false": False, "true": True, "no": False, "yes": True, "off": False,
    "on": True, "n": False, "y": True,
}  # fmt: skip
_NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?")
_RAW_HIGHEST = 100
_MOST_BRACKETS = 200
_LARGEST = 100_000
"""Bytes of a map's YAML file; real ones have a few hundred."""


def load_nav2(path: Path, resolution_m: float | None) -> World:
    """A world from a nav2 map: what the map calls free is free, unknown is not.

    A map that is turned (yaw) becomes a world whose axes are those of the map frame: exactly near
    multiples of 90°, by resampling otherwise.

    Args:
        path: the YAML file; the image is found relative to it.
        resolution_m: as for :func:`swarmscout.worlds.resampling.refined`; None keeps the map's
            own where that is at most 0.1 m.

    Raises:
        WorldError: a file is missing or damaged, a key is missing or impossible, or nothing is
            free.
    """
    keys = _read(path)
    cell_m = _number(path, keys, "resolution")
    check_length(f"map '{path}': resolution", cell_m)
    x_m, y_m, yaw_rad = _origin(path, keys)
    image = keys["image"]
    if not isinstance(image, str) or not image:
        raise WorldError(f"map '{path}': image = {_shown(image)}, expected a file name")
    pixels = read_image(path.parent / Path(image).expanduser())
    free = np.flipud(_free_pixels(path, keys, pixels.shade(path), pixels.opaque))
    if not free.any():
        raise WorldError(
            f"map '{path}': no pixel of '{image}' is free: check negate and free_thresh"
        )
    if resolution_m is not None:
        check_length("resolution_m", resolution_m)
    facts: dict[str, Any] = {"file": path.name, "cell_m": cell_m}
    raster, origin, exact = turned(free.astype(np.uint8), cell_m, (x_m, y_m), yaw_rad)
    if not exact:
        facts["notes"] = (
            f"the map is turned by {math.degrees(yaw_rad):.4g} degrees: it was resampled; cells "
            "that meet a wall are wall"
        )
    raster, edge = refined(raster, cell_m, resolution_m)
    return world_from_array(raster, edge, name=path.stem, origin_m=origin, source=facts)


def _read(path: Path) -> Mapping[str, Any]:
    """The keys with their texts, or lists of texts; YAML's own idea of numbers is not used.

    Nodes are looked at and never built, so that aliases of aliases cost nothing.
    """
    try:
        packed = path.read_bytes()
    except OSError as error:
        raise WorldError(f"cannot read the map '{path}': {error.strerror or error}") from None
    if len(packed) > _LARGEST:
        raise WorldError(f"map '{path}' has {len(packed):,} bytes: no nav2 map is so large")
    text = _text(packed)
    if (
        text.count("[") + text.count("{") > _MOST_BRACKETS
    ):  # The parser's time is quadratic in them.
        raise WorldError(f"map '{path}' is not YAML: too many nested brackets")
    try:
        root = next(yaml.compose_all(text, yaml.SafeLoader), None)
    except (yaml.YAMLError, ValueError) as error:
        why = " ".join(str(error).split()) or type(error).__name__
        raise WorldError(f"map '{path}' is not YAML: {why[:160]}") from None
    except RecursionError:
        raise WorldError(f"map '{path}' is not YAML: too many nested brackets") from None
    if not isinstance(root, yaml.MappingNode):
        raise WorldError(f"map '{path}' is not a nav2 map: expected keys {', '.join(_KEYS)}")
    keys: dict[str, Any] = {}
    for key, value in root.value:
        if not isinstance(key, yaml.ScalarNode):
            continue
        if key.value in keys:
            raise WorldError(f"map '{path}': key '{key.value[:40]}' is there twice")
        keys[key.value] = _plain(value)
    for key in _KEYS:
        if key not in keys:
            near = did_you_mean(key, [name for name in keys if name not in _KEYS])
            hint = f" ({near})" if near.startswith("did") else ""
            raise WorldError(f"map '{path}': key '{key}' is missing{hint}")
    return keys


def _text(packed: bytes) -> str:
    """The file as text; comments may be in any encoding, and tabs count as blanks."""
    if packed.startswith((b"\xff\xfe", b"\xfe\xff")):
        text = packed.decode("utf-16", "replace")
    else:
        try:
            text = packed.decode("utf-8-sig")
        except UnicodeDecodeError:
            text = packed.decode("latin-1")
    return text.replace("\t", " ")


def _plain(node: yaml.Node) -> str | list[str] | None:
    """A scalar's text, or those of a flat list; None for anything else."""
    if isinstance(node, yaml.ScalarNode):
        return str(node.value)
    if isinstance(node, yaml.SequenceNode) and all(
        isinstance(part, yaml.ScalarNode) for part in node.value
    ):
        return [str(part.value) for part in node.value]
    return None


def _number(path: Path, keys: Mapping[str, Any], key: str) -> float:
    value = _as_number(keys[key])
    if value is None:
        raise WorldError(f"map '{path}': {key} = {_shown(keys[key])}, expected a finite number")
    return value


def _as_number(text: Any) -> float | None:
    if not isinstance(text, str) or not _NUMBER.fullmatch(text.strip()):
        return None
    number = float(text)
    return number if math.isfinite(number) else None


def _shown(value: Any) -> str:
    if value is None:
        return "something nested"
    text = value if isinstance(value, str) else f"[{', '.join(value)}]"
    return f"'{text[:40]}…'" if len(text) > 40 else f"'{text}'"


def _origin(path: Path, keys: Mapping[str, Any]) -> tuple[float, float, float]:
    given = keys["origin"]
    parts = [_as_number(part) for part in given] if isinstance(given, list) else []
    numbers = [part for part in parts if part is not None]
    if len(numbers) != len(parts) or len(numbers) not in (2, 3):
        raise WorldError(
            f"map '{path}': origin = {_shown(given)}, expected [x, y, yaw] with numbers"
        )
    x, y, yaw = (*numbers, 0.0)[:3]
    return x, y, yaw


def _free_pixels(
    path: Path,
    keys: Mapping[str, Any],
    shade: NDArray[np.float64],
    opaque: NDArray[np.bool_],
) -> NDArray[np.bool_]:
    """bool[rows, cols], row 0 at the top: what nav2 calls free, except unknown.

    ``raw`` takes the grey level itself for the occupancy in percent (above 100: unknown) and
    ignores ``negate``, as nav2 does.
    """
    given = keys.get("mode", "trinary")
    mode = given.strip().lower() if isinstance(given, str) else ""
    if mode not in _MODES:
        near = did_you_mean(mode[:40], _MODES)
        raise WorldError(f"map '{path}': unknown mode {_shown(given)}: {near}")
    negate = keys["negate"].strip().lower() if isinstance(keys["negate"], str) else ""
    if negate not in _NEGATE:
        raise WorldError(f"map '{path}': negate = {_shown(keys['negate'])}, expected 0 or 1")
    free_below = _number(path, keys, "free_thresh")
    occupied_above = _number(path, keys, "occupied_thresh")
    if not 0.0 <= free_below <= occupied_above <= 1.0:
        raise WorldError(
            f"map '{path}': free_thresh = {free_below:g}, occupied_thresh = {occupied_above:g}, "
            "expected 0 <= free_thresh <= occupied_thresh <= 1"
        )
    if mode == "raw":
        percent = np.rint(shade * 255.0)
        raw: NDArray[np.bool_] = (percent <= _RAW_HIGHEST) & (percent <= free_below * 100.0 + 1e-9)
        return raw
    # What shows through is unknown; nav2 averages opacity in with the colours in mode trinary,
    # which makes a half transparent white pixel unknown as well.
    occupancy = np.round(shade if _NEGATE[negate] else 1.0 - shade, 9)
    free: NDArray[np.bool_] = (occupancy <= free_below) & opaque
    if mode == "trinary":
        # Map savers paint unknown in this grey, and many then write a free_thresh (0.25) that
        # calls it free. Unknown is not free.
        free &= np.rint(shade * 255.0) != UNKNOWN_GREY
    return free
