"""The frames of a film: the cave, the map and the explored area, step by step."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw, ImageFont

from swarmscout.viewing import sprites
from swarmscout.viewing.map_image import Window, map_image
from swarmscout.viewing.map_picture import short_name, world_name
from swarmscout.viewing.overview import Overview
from swarmscout.viewing.palette import DARK, RGB, rgb
from swarmscout.viewing.relief import relief_of
from swarmscout.viewing.replay import Moment, Replay

__all__ = ["Film"]

Place = Callable[[NDArray[np.float64]], NDArray[np.float64]]
"""Points ``(x, y)`` [n, 2] in metres to pixels."""

BACKGROUND, PANEL, LINE = rgb(DARK.background), rgb(DARK.panel), rgb(DARK.line)
TEXT, MUTED, CURVE = rgb(DARK.text), rgb(DARK.muted), rgb(DARK.accent)
CURVE_AHEAD = (74, 62, 48)
"""The part of the curve that lies in the future."""


class Film:
    """Draws the frames of a film.

    Args:
        replay: the run.
        size: ``(width, height)`` in pixels.
    """

    def __init__(self, replay: Replay, size: tuple[int, int] = (1280, 720)) -> None:
        self._replay = replay
        self._size = width, height = size
        unit = height / 720
        self._font, self._small = (_font(size * unit) for size in (18, 13))
        self._unit = unit
        gap, head = round(12 * unit), round(50 * unit)
        side = round(0.29 * width)
        self._cave_box = (0, head, width - side - 2 * gap, height)
        lower = round(0.30 * height)
        self._map_box = (width - side - gap, head, width - gap, height - lower - 2 * gap)
        self._curve_box = (width - side - gap, height - lower - gap, width - gap, height - gap)

        run, window = replay.run, replay.window()
        self._relief = relief_of(run.world())
        cave = self._cave_box
        self._cave = Overview(
            self._relief, window, cave[2] - cave[0], cave[3] - cave[1], run.frame, DARK
        )
        self._rows, self._columns, self._map_scale = self._map_cells(window)
        self._still = self._template()
        self._drawn_curve = self._curve()

    def frame(self, step: int) -> Image.Image:
        """The frame of a step."""
        moment = self._replay.moment(step)
        known = moment.labels != 0
        picture = self._still.copy()
        cave = Image.fromarray(self._cave.picture(known))
        self._swarm(cave, moment, self._cave.pixels_of, self._cave.scale, self._cave.flattening)
        picture.paste(cave, self._cave_box[:2])
        picture.paste(self._map(moment), self._map_box[:2])
        draw = ImageDraw.Draw(picture)
        words = f"step {step} of {self._replay.last}   {moment.explored_m2:.0f} m² explored"
        draw.text((self._size[0] - 12, 14 * self._unit), words, TEXT, self._font, anchor="ra")
        self._reveal_curve(picture, step)
        return picture

    def _map(self, moment: Moment) -> Image.Image:
        image = map_image(moment.labels, self._replay.run.scenario.map.frontier_neighbours, DARK)
        inside = (self._rows >= 0)[:, None] & (self._columns >= 0)[None, :]
        shown = image[self._rows[:, None], self._columns[None, :]]
        picture = Image.fromarray(np.where(inside[..., None], shown, DARK.cells[0]))
        scale = self._map_scale
        left, top = self._map_corner

        def place(points: NDArray[np.float64]) -> NDArray[np.float64]:
            return np.column_stack([(points[:, 0] - left) * scale, (top - points[:, 1]) * scale])

        self._swarm(picture, moment, place, scale, 1.0)
        return picture

    def _map_cells(self, window: Window) -> tuple[NDArray[np.int64], NDArray[np.int64], float]:
        """The map's row and column at each line and column of its panel (-1: outside)."""
        left, right, bottom, top = window
        x0, y0, x1, y1 = self._map_box
        scale = min((x1 - x0) / (right - left), (y1 - y0) / (top - bottom))
        middle_x, middle_y = (left + right) / 2, (bottom + top) / 2
        self._map_corner = (
            middle_x - (x1 - x0) / (2 * scale),
            middle_y + (y1 - y0) / (2 * scale),
        )
        frame = self._replay.run.frame
        x_m = self._map_corner[0] + (np.arange(x1 - x0) + 0.5) / scale
        y_m = self._map_corner[1] - (np.arange(y1 - y0) + 0.5) / scale
        cells = [
            np.floor((y_m - frame.origin_y_m) / frame.cell_m).astype(np.int64),
            np.floor((x_m - frame.origin_x_m) / frame.cell_m).astype(np.int64),
        ]
        for index, limit in zip(cells, frame.shape, strict=True):
            index[(index < 0) | (index >= limit)] = -1
        return cells[0], cells[1], scale

    def _swarm(
        self, picture: Image.Image, moment: Moment, place: Place, scale: float, flat: float
    ) -> None:
        """Stations, destinations, teams and robots over a picture."""
        unit, run = self._unit, self._replay.run
        size = max(3.6 * unit, run.scenario.body.radius_m * scale)
        for x, y in place(run.stations_m):
            sprites.paste(picture, sprites.station(rgb(DARK.charge), 7 * unit, BACKGROUND), x, y)
        heading = [team for team in moment.teams if team.destination_m is not None]
        violet = rgb(DARK.destination)
        around = sprites.dot_ring(violet, max(5 * unit, 0.4 * scale), 1.5 * unit)
        for team in heading:
            assert team.destination_m is not None
            ends = place(np.stack([moment.place_m[team.leader], team.destination_m]))
            _dashes(picture, ends, violet, unit)
            sprites.paste(picture, around, *ends[1])
        for team in moment.teams:
            if len(team.members) > 1:
                across = max(6, round((team.radius_m + 0.45) * scale))
                line = sprites.ring(
                    rgb(DARK.team), across, max(4, round(across * flat)), 1.4 * unit
                )
                sprites.paste(picture, line, *place(team.centre_m[None])[0])
        marks = [sprites.disc(rgb(colour), round(4 * size) / 4) for colour in DARK.robots]
        for (x, y), kind in zip(place(moment.place_m), moment.robot_kinds.tolist(), strict=True):
            sprites.paste(picture, marks[kind], x, y)
        leaders = [team.leader for team in moment.teams if len(team.members) > 1]
        for x, y in place(moment.place_m[leaders]):
            sprites.paste(picture, sprites.star(round(3.2 * size) / 4), x, y)

    def _template(self) -> Image.Image:
        """The part of a frame that does not change."""
        picture = Image.new("RGB", self._size, BACKGROUND)
        draw = ImageDraw.Draw(picture)
        scenario = self._replay.run.scenario
        title = f"{world_name(self._replay.run)} · {short_name(scenario.destinations)}"
        words = f"{title} · {scenario.robots} robots"
        draw.text((14, 14 * self._unit), words, TEXT, self._font)
        return picture

    def _curve(self) -> tuple[Image.Image, Image.Image, tuple[int, int]]:
        """The panel with a dim and with a bright curve, and the curve's first and last x."""
        x0, y0, x1, y1 = self._curve_box
        fine, unit = 3, self._unit
        width, height = x1 - x0, y1 - y0
        explored = self._replay.explored_m2
        high = max(1.0, float(explored[-1])) * 1.08
        left, right = round(52 * unit), width - round(14 * unit)
        top, bottom = round(34 * unit), height - round(28 * unit)
        x = left + (right - left) * np.arange(len(explored)) / max(1, len(explored) - 1)
        y = bottom - (bottom - top) * explored / high
        panels = []
        for colour in (CURVE_AHEAD, CURVE):
            panel = Image.new("RGB", (width * fine, height * fine), PANEL)
            draw = ImageDraw.Draw(panel)
            draw.line([left * fine, bottom * fine, right * fine, bottom * fine], LINE, fine)
            points = [(a * fine, b * fine) for a, b in zip(x.tolist(), y.tolist(), strict=True)]
            draw.line(points, colour, round(2.2 * unit * fine), joint="curve")
            panel = panel.resize((width, height), Image.Resampling.BOX)
            draw = ImageDraw.Draw(panel)
            draw.text((12 * unit, 8 * unit), "explored area (m²)", MUTED, self._small)
            for value, anchor in ((0.0, "rs"), (float(explored[-1]), "rm")):
                level = bottom - (bottom - top) * value / high
                draw.text(
                    (left - 8 * unit, level), f"{value:.0f}", MUTED, self._small, anchor=anchor
                )
            for step, anchor in ((0, "la"), (self._replay.last, "ra")):
                at = left + (right - left) * step / max(1, self._replay.last), bottom + 7 * unit
                draw.text(at, f"{step}", MUTED, self._small, anchor=anchor)
            panels.append(panel)
        return panels[0], panels[1], (left, right)

    def _reveal_curve(self, picture: Image.Image, step: int) -> None:
        dim, bright, (left, right) = self._drawn_curve
        x0, y0 = self._curve_box[:2]
        at = round(left + (right - left) * step / max(1, self._replay.last))
        picture.paste(dim, (x0, y0))
        picture.paste(bright.crop((0, 0, at, bright.height)), (x0, y0))
        y = bright.height - round(28 * self._unit)
        line = [x0 + at, y0 + round(34 * self._unit), x0 + at, y0 + y]
        ImageDraw.Draw(picture).line(line, TEXT, 1)


def _font(pixels: float) -> ImageFont.FreeTypeFont:
    """A font that comes with Matplotlib and has a ²."""
    from matplotlib import get_data_path

    return ImageFont.truetype(f"{get_data_path()}/fonts/ttf/DejaVuSans.ttf", round(pixels))


def _dashes(picture: Image.Image, ends: NDArray[np.float64], colour: RGB, unit: float) -> None:
    """Dots from one pixel to another."""
    (x0, y0), (x1, y1) = ends.tolist()
    count = int(math.hypot(x1 - x0, y1 - y0) / (6.0 * unit))
    dot = sprites.disc(colour, max(0.9, 0.9 * unit), colour)
    for k in range(1, count):
        share = k / count
        sprites.paste(picture, dot, x0 + (x1 - x0) * share, y0 + (y1 - y0) * share)
