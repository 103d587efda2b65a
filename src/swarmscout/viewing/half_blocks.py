"""A map in a terminal: two map cells in one character, by upper half blocks."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from swarmscout.core.enums import CHARGE, FREE, OCCUPIED, UNKNOWN
from swarmscout.viewing.map_image import FRONTIER, cell_codes
from swarmscout.viewing.palette import DARK, rgb

if TYPE_CHECKING:
    from rich.text import Text

    from swarmscout.mission.mission import Mission

__all__ = ["colours_of", "half_block_map", "half_blocks"]

Colours = NDArray[np.uint8]
# Unknown, free, occupied, frontier, charging station, robot in CHR mode, robot in EXP mode: where
# several things share half a character, the last of these is shown.
COLOURS = np.concatenate(
    [DARK.cells, np.array([rgb(DARK.charge), rgb(DARK.charge), rgb(DARK.explore)], dtype=np.uint8)]
)
_STATION, _CHARGING, _EXPLORING = 4, 5, 6
_MARGIN = 2


def half_block_map(mission: Mission, width: int, height: int) -> Text:
    """The swarm's map with its robots, at most as large as asked for.

    Args:
        mission: a running mission.
        width: most characters in a line.
        height: most lines.
    """
    return half_blocks(colours_of(mission, width, 2 * height))


def colours_of(mission: Mission, width: int, height: int) -> Colours:
    """uint8[h, w, 3]: the explored part of the map, h ≤ height, w ≤ width; row 0 is highest."""
    labels = cell_codes(mission.map.labels, mission.scenario.map.frontier_neighbours)
    frame, alive = mission.frame, mission.bodies.alive
    charging = mission.minds.mode == CHARGE
    for points, mark in (
        (mission.stations_m, _STATION),
        (mission.bodies.position[alive & charging], _CHARGING),
        (mission.bodies.position[alive & ~charging], _EXPLORING),
    ):
        rows, columns = frame.cells_of(points).T
        labels[rows.clip(0, frame.rows - 1), columns.clip(0, frame.columns - 1)] = mark
    rows, columns = np.nonzero(labels != UNKNOWN)
    window = labels[_around(rows, frame.rows), _around(columns, frame.columns)]
    fewer = max(1, -(-window.shape[0] // height), -(-window.shape[1] // width))
    # Codes are ranks: walls hide free cells, which hide unknown ones.
    assert UNKNOWN < FREE < OCCUPIED < FRONTIER
    padded = np.pad(window, [(0, -side % fewer) for side in window.shape])
    squares = padded.reshape(padded.shape[0] // fewer, fewer, padded.shape[1] // fewer, fewer)
    return np.asarray(COLOURS[squares.max(axis=(1, 3))][::-1])


def half_blocks(pixels: Colours) -> Text:
    """A picture [h, w, 3] as lines of half blocks."""
    from rich.text import Text

    if len(pixels) % 2:
        pixels = np.concatenate([pixels, np.zeros_like(pixels[:1])])
    text = Text(no_wrap=True)
    for k in range(0, len(pixels), 2):
        start = 0
        pairs: list[Any] = np.concatenate([pixels[k], pixels[k + 1]], axis=1).tolist()
        for end in range(1, len(pairs) + 1):
            if end == len(pairs) or pairs[end] != pairs[start]:
                r, g, b, r2, g2, b2 = pairs[start]
                style = f"#{r:02x}{g:02x}{b:02x} on #{r2:02x}{g2:02x}{b2:02x}"
                text.append("▀" * (end - start), style)
                start = end
        text.append("\n")
    return text


def _around(cells: NDArray[np.int64], size: int) -> slice:
    return slice(max(0, int(cells.min()) - _MARGIN), min(size, int(cells.max()) + _MARGIN + 1))
