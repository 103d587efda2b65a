"""The colours of every picture of a mission: figures, films, Rerun, the terminal and the page.

Two palettes hold the same names. :data:`LIGHT` has the paper's colours (Fig. 1) and serves print;
:data:`DARK` serves films and the page's dark theme. The page gets both as ``palette.js`` and
``palette.css``, see :mod:`swarmscout.viewing.player.page`.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.typing import NDArray

__all__ = ["DARK", "LIGHT", "RGB", "Palette", "rgb"]

RGB = tuple[int, int, int]


@dataclass(frozen=True)
class Palette:
    """Colours as ``#rrggbb``.

    Attributes:
        background, panel, text, muted, line: of a page or frame round the pictures.
        accent: curves of the explored area, and controls.
        second_run: curves of the run beside it.
        unknown, free, occupied, frontier: cells of the map.
        explore, charge, stranded: robots in EXP mode, in CHR mode, and without charge; stations
            have the colour of CHR mode.
        destination: a team's destination, and the line to it.
        team: the circle round a team.
        selected: the selected robot, its rays and its route.
        halo: behind text and signs that lie on the map.
        ground_low, ground_high: the floor of the cave by height.
        rock, cut: walls of the cave, and the cut through the rock.
    """

    background: str
    panel: str
    text: str
    muted: str
    line: str
    accent: str
    second_run: str
    unknown: str
    free: str
    occupied: str
    frontier: str
    explore: str
    charge: str
    stranded: str
    destination: str
    team: str
    selected: str
    halo: str
    ground_low: str
    ground_high: str
    rock: str
    cut: str

    @property
    def cells(self) -> NDArray[np.uint8]:
        """uint8[4, 3]: colours of unknown, free, occupied and frontier cells, by code."""
        names = (self.unknown, self.free, self.occupied, self.frontier)
        return np.array([rgb(colour) for colour in names], dtype=np.uint8)

    @property
    def robots(self) -> tuple[str, str, str]:
        """Colours of robots in EXP mode, in CHR mode, and stranded."""
        return self.explore, self.charge, self.stranded


# The paper's red and green, in shades that stay apart for the colour-blind (Okabe and Ito, 2008).
LIGHT = Palette(
    background="#f4f1ea", panel="#fffdf8", text="#23272c", muted="#5d636b", line="#dcd6ca",
    accent="#a34a06", second_run="#5d7fae",
    unknown="#9e9e9e", free="#ffffff", occupied="#000000", frontier="#5cd45c",
    explore="#e3211c", charge="#007a55", stranded="#33567f", destination="#8a2be2",
    team="#30343a", selected="#b35c00", halo="#fffdf8",
    ground_low="#c79f76", ground_high="#fff3dc", rock="#9a8672", cut="#b9b1a4",
)  # fmt: skip
DARK = Palette(
    background="#0e1115", panel="#161a20", text="#e9e5dc", muted="#98a0a9", line="#2b313a",
    accent="#ffb35c", second_run="#6f93c4",
    unknown="#1b1f25", free="#4a525c", occupied="#d8d2c4", frontier="#2f9e57",
    explore="#ff5d4f", charge="#2fd07a", stranded="#7fa3cf", destination="#c29aff",
    team="#cfcbc2", selected="#ffd166", halo="#0e1115",
    ground_low="#8a6a4d", ground_high="#f3dfbd", rock="#6d5a4a", cut="#23272d",
)  # fmt: skip


@cache
def rgb(colour: str) -> RGB:
    """``#rrggbb`` as three numbers from 0 to 255."""
    red, green, blue = bytes.fromhex(colour.removeprefix("#"))
    return red, green, blue
