"""Worlds from plain images: bright pixels are free."""

from __future__ import annotations

import warnings
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from swarmscout.core.errors import WorldError
from swarmscout.worlds.arrays import first_line, world_from_array
from swarmscout.worlds.resampling import check_length, check_size, refined
from swarmscout.worlds.values import free_by_value
from swarmscout.worlds.world import World

if TYPE_CHECKING:
    from PIL import Image

__all__ = ["IMAGE_SUFFIXES", "UNKNOWN_GREY", "Pixels", "load_image", "read_image"]

IMAGE_SUFFIXES = frozenset(
    {".png", ".pgm", ".pbm", ".ppm", ".jpg", ".jpeg", ".bmp", ".tif", ".tiff"}
)
UNKNOWN_GREY = 205
"""Map savers of ROS paint unknown in this grey, of 255."""
_BRIGHT = 0.6
"""Free from here: between the mid grey that maps use for "unknown" and the light grey of floors."""
_PLAIN = 10
"""A grey is a map's own where it is more frequent by this factor than its two neighbours."""


@dataclass(frozen=True, eq=False)
class Pixels:
    """The pixels of an image, row 0 at the top.

    Attributes:
        levels: [rows, cols] values as the file has them, the mean of the colours: 0 to 255 with 8
            bits, 0 to 65,535 with 16, anything with floating-point numbers.
        white: the level of white.
        opaque: bool[rows, cols], where a pixel is fully opaque.
    """

    levels: NDArray[np.float64]
    white: float
    opaque: NDArray[np.bool_]

    def shade(self, path: Path) -> NDArray[np.float64]:
        """float64[rows, cols], from 0 (black) to 1 (white).

        Raises:
            WorldError: a level lies outside.
        """
        low, high = float(np.nanmin(self.levels)), float(np.nanmax(self.levels))
        if not (low >= 0.0 and high <= self.white) or not np.isfinite(self.levels).all():
            raise WorldError(
                f"image '{path}' holds values from {low:g} to {high:g}, expected brightness from 0 "
                f"to {self.white:g}; say which values are free, for example with --free 0..49"
            )
        return self.levels / self.white


def load_image(
    path: Path,
    cell_m: float | None,
    resolution_m: float | None,
    free: str | None = None,
    occupied: str | None = None,
) -> World:
    """A world from an image: pixels of at least 60 % brightness are free, transparent ones are not.

    The grey 205 of map savers is unknown and not free.

    Args:
        path: the image; its top row is the highest.
        cell_m: edge of a pixel, in metres; None for 0.1.
        resolution_m: as for :func:`swarmscout.worlds.resampling.refined`.
        free: levels that are free instead, as for
            :func:`swarmscout.worlds.values.free_by_value`.
        occupied: levels that are not free.

    Raises:
        WorldError: the image is missing or damaged, or no pixel is free.
    """
    cell = 0.1 if cell_m is None else cell_m
    check_length("cell_m", cell)
    pixels = read_image(path)
    facts: dict[str, Any] = {"file": path.name, "cell_m": cell}
    if free is not None or occupied is not None:
        open_pixels = free_by_value(pixels.levels, free, occupied) & pixels.opaque
        facts |= {"free": free, "occupied": occupied}
    else:
        open_pixels, notes = _bright(path, pixels)
        facts["meaning"] = "bright is free"
        yaml = next(
            (path.with_suffix(s) for s in (".yaml", ".yml") if path.with_suffix(s).exists()), None
        )
        if yaml is not None:
            notes.append(f"'{yaml.name}' beside it describes a map: load that for its scale")
        if notes:
            facts["notes"] = "; ".join(notes)
    raster, edge = refined(np.flipud(open_pixels).astype(np.uint8), cell, resolution_m)
    return world_from_array(raster, edge, name=path.stem, source=facts)


def _bright(path: Path, pixels: Pixels) -> tuple[NDArray[np.bool_], list[str]]:
    shade = pixels.shade(path)
    bright = (shade >= _BRIGHT - 1e-9) & pixels.opaque
    notes = []
    grey = np.rint(shade * 255.0).astype(np.int64)
    counts = np.bincount(grey.ravel(), minlength=256)
    unknown = int(counts[UNKNOWN_GREY])
    if unknown > _PLAIN * int(counts[UNKNOWN_GREY - 1] + counts[UNKNOWN_GREY + 1]):
        bright &= grey != UNKNOWN_GREY
        notes.append(
            f"{100.0 * unknown / grey.size:.0f} % of the pixels have the grey {UNKNOWN_GREY} that "
            "maps of ROS use for unknown: they are not free (--free 205..255 makes them free)"
        )
    if not bright.any():
        raise WorldError(
            f"image '{path}' has no free pixel: free is what is at least {_BRIGHT:.0%} bright, its "
            f"brightest has {shade.max():.0%}; --free LOW..HIGH says which levels are free"
        )
    return bright, notes


def read_image(path: Path) -> Pixels:
    """Read the pixels of an image.

    Args:
        path: the file, in any form that Pillow reads.

    Raises:
        WorldError: the file is missing, damaged, not an image, too large, or has several pages.
    """
    from PIL import Image, ImageOps  # Most missions read no image.

    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error", Image.DecompressionBombWarning)
            with Image.open(path) as image:
                check_size((image.height, image.width), f"image '{path}'")
                pages = getattr(image, "n_frames", 1)
                if pages > 1:
                    raise WorldError(f"image '{path}' has {pages} pages: save one of them")
                return _pixels(ImageOps.exif_transpose(image))
    except (Image.DecompressionBombWarning, Image.DecompressionBombError):
        raise WorldError(f"image '{path}' declares too many pixels: crop or shrink it") from None
    except FileNotFoundError:
        raise WorldError(f"image '{path}' does not exist") from None
    except (
        OSError,
        ValueError,
        SyntaxError,
        EOFError,
        IndexError,
        MemoryError,
        OverflowError,
    ) as error:
        raise WorldError(f"cannot read the image '{path}': {first_line(error)[:160]}") from None


def _pixels(image: Image.Image) -> Pixels:
    if image.mode.startswith("I") or image.mode == "F":
        deep = np.asarray(image, dtype=np.float64)
        white = 1.0 if image.mode == "F" else 65535.0
        return Pixels(deep, white, np.ones(deep.shape, dtype=np.bool_))
    if not image.has_transparency_data:
        form = "L" if image.mode in ("1", "L") else "RGB"
        levels = np.asarray(image.convert(form), dtype=np.float64)
        levels = levels.mean(axis=2) if levels.ndim == 3 else levels
        return Pixels(levels, 255.0, np.ones(levels.shape, dtype=np.bool_))
    pixels = np.asarray(image.convert("RGBA"))
    return Pixels(pixels[..., :3].mean(axis=2), 255.0, pixels[..., 3] == 255)
