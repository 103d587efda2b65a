"""Worlds from plain images: bright pixels are free."""

from __future__ import annotations

import warnings
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from swarmscout.core.errors import WorldError
from swarmscout.worlds.arrays import world_from_array
from swarmscout.worlds.resampling import check_length, check_size, refined
from swarmscout.worlds.world import World

__all__ = ["IMAGE_SUFFIXES", "load_image", "read_image"]

IMAGE_SUFFIXES = frozenset(
    {".png", ".pgm", ".pbm", ".ppm", ".jpg", ".jpeg", ".bmp", ".tif", ".tiff"}
)
_BRIGHT = 0.6
"""Free from here: between the mid grey that maps use for "unknown" and the light grey of floors."""


def load_image(path: Path, cell_m: float | None, resolution_m: float | None) -> World:
    """A world from an image: pixels of at least 60 % brightness are free, transparent ones are not.

    Args:
        path: the image; its top row is the highest.
        cell_m: edge of a pixel, in metres; None for 0.1.
        resolution_m: as for :func:`swarmscout.worlds.resampling.refined`.

    Raises:
        WorldError: the image is missing or broken, or has no bright pixel.
    """
    cell = 0.1 if cell_m is None else cell_m
    check_length("cell_m", cell)
    brightness, opaque = read_image(path)
    bright = (brightness.mean(axis=2) >= _BRIGHT - 1e-9) & opaque
    if not bright.any():
        raise WorldError(
            f"image '{path}' has no free pixel: free is what is at least {_BRIGHT:.0%} bright, "
            f"its brightest has {brightness.mean(axis=2).max():.0%}"
        )
    free, edge = refined(np.flipud(bright).astype(np.uint8), cell, resolution_m)
    return world_from_array(free, edge, name=path.stem, source={"file": path.name, "cell_m": cell})


def read_image(path: Path) -> tuple[NDArray[np.float64], NDArray[np.bool_]]:
    """Read an image's colours.

    Args:
        path: the file, in any form that Pillow reads.

    Returns:
        float64[rows, cols, channels] colours in [0, 1] (one channel if grey, else three), row 0 at
        the top, and bool[rows, cols] where a pixel is fully opaque.

    Raises:
        WorldError: the file is missing, broken, no image, or too large.
    """
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error", Image.DecompressionBombWarning)
            with Image.open(path) as image:
                check_size((image.height, image.width), f"image '{path}'")
                return _colours(image)
    except (Image.DecompressionBombWarning, Image.DecompressionBombError):
        raise WorldError(f"image '{path}' declares too many pixels: crop or shrink it") from None
    except FileNotFoundError:
        raise WorldError(f"image '{path}' does not exist") from None
    except (OSError, ValueError, SyntaxError, EOFError, IndexError, MemoryError) as error:
        why = str(error).splitlines()[0] if str(error) else type(error).__name__
        raise WorldError(f"cannot read the image '{path}': {why}") from None


def _colours(image: Image.Image) -> tuple[NDArray[np.float64], NDArray[np.bool_]]:
    if image.mode.startswith("I") or image.mode == "F":
        deep = np.asarray(image, dtype=np.float64)
        # 16 bits; what came as floating point is already between 0 and 1.
        return np.clip(deep / (1.0 if image.mode == "F" else 65535.0), 0.0, 1.0)[
            ..., None
        ], np.ones(deep.shape, dtype=np.bool_)
    has_alpha = image.has_transparency_data
    plain = image.mode in ("1", "L") and not has_alpha
    pixels = np.asarray(image.convert("L" if plain else "RGBA"))
    if plain:
        return pixels[..., None] / 255.0, np.ones(pixels.shape, dtype=np.bool_)
    return pixels[..., :3] / 255.0, pixels[..., 3] == 255
