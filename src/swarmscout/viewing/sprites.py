"""Small marks with soft edges, made once and pasted often: robots, rings, stations, dots."""

from __future__ import annotations

import math
from functools import cache

from PIL import Image, ImageDraw

from swarmscout.viewing.palette import RGB

__all__ = ["disc", "dot_ring", "paste", "ring", "star", "station"]

_FINE = 4


def paste(picture: Image.Image, mark: Image.Image, x: float, y: float) -> None:
    """Put a mark's middle on a pixel."""
    left, top = round(x - mark.width / 2), round(y - mark.height / 2)
    if -mark.width < left < picture.width and -mark.height < top < picture.height:
        picture.paste(mark, (left, top), mark)


@cache
def disc(colour: RGB, radius: float, edge: RGB = (255, 255, 255)) -> Image.Image:
    """A disc with a thin edge."""
    sheet, draw, middle = _sheet(2 * radius + 2)
    _ellipse(draw, middle, radius + 0.5, radius + 0.5, fill=edge)
    _ellipse(draw, middle, radius - 0.2, radius - 0.2, fill=colour)
    return _small(sheet)


@cache
def ring(colour: RGB, across: int, up: int, width: float) -> Image.Image:
    """An ellipse's line, with half axes in pixels."""
    sheet, draw, (x, y) = _sheet(2 * across + 4, 2 * up + 4)
    box = [x - across * _FINE, y - up * _FINE, x + across * _FINE, y + up * _FINE]
    draw.ellipse(box, outline=colour, width=round(width * _FINE))
    return _small(sheet)


@cache
def dot_ring(colour: RGB, radius: float, dot: float) -> Image.Image:
    """Eight dots on a circle (paper, Fig. 9)."""
    sheet, draw, (x, y) = _sheet(2 * (radius + dot) + 2)
    for k in range(8):
        angle = k * math.pi / 4
        place = x + radius * _FINE * math.cos(angle), y + radius * _FINE * math.sin(angle)
        _ellipse(draw, place, dot, dot, fill=colour)
    return _small(sheet)


@cache
def station(colour: RGB, radius: float, plus: RGB) -> Image.Image:
    """A plus on a disc."""
    sheet, draw, (x, y) = _sheet(2 * radius + 4)
    _ellipse(draw, (x, y), radius + 1, radius + 1, fill=plus)
    _ellipse(draw, (x, y), radius, radius, fill=colour)
    arm, half = 0.55 * radius * _FINE, 0.16 * radius * _FINE
    draw.rectangle([x - arm, y - half, x + arm, y + half], fill=plus)
    draw.rectangle([x - half, y - arm, x + half, y + arm], fill=plus)
    return _small(sheet)


@cache
def star(radius: float) -> Image.Image:
    """The mark of a leader."""
    sheet, draw, (x, y) = _sheet(2 * radius + 3)
    for size, colour in ((radius + 0.8, (0, 0, 0)), (radius, (255, 255, 255))):
        points = []
        for k in range(10):
            r = size * _FINE * (0.45 if k % 2 else 1.0)
            angle = -math.pi / 2 + k * math.pi / 5
            points.append((x + r * math.cos(angle), y + r * math.sin(angle)))
        draw.polygon(points, fill=colour)
    return _small(sheet)


def _sheet(
    width: float, height: float | None = None
) -> tuple[Image.Image, ImageDraw.ImageDraw, tuple[float, float]]:
    # Odd sizes have a middle pixel.
    columns, rows = (2 * math.ceil(size / 2) + 1 for size in (width, height or width))
    sheet = Image.new("RGBA", (columns * _FINE, rows * _FINE))
    return sheet, ImageDraw.Draw(sheet), (columns * _FINE / 2, rows * _FINE / 2)


def _ellipse(
    draw: ImageDraw.ImageDraw, middle: tuple[float, float], across: float, up: float, fill: RGB
) -> None:
    x, y = middle
    a, b = across * _FINE, up * _FINE
    draw.ellipse([x - a, y - b, x + a, y + b], fill=fill)


def _small(sheet: Image.Image) -> Image.Image:
    return sheet.resize((sheet.width // _FINE, sheet.height // _FINE), Image.Resampling.BOX)
