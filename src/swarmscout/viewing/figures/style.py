"""How figures look: sizes for print, the paper's colours, and marks that differ without them."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

__all__ = [
    "CHARGE",
    "CURVE",
    "DESTINATION",
    "EXPLORE",
    "MAP_COLOURS",
    "PAGE_INCHES",
    "STRANDED",
    "print_style",
    "ring_of_dots",
]

PAGE_INCHES = 7.0
"""The width of a page's text."""

# The paper's red and green, in shades that stay apart for the colour-blind (Okabe and Ito, 2008);
# robots in CHR mode are squares besides, and stranded ones crosses.
EXPLORE, CHARGE, STRANDED = "#d7261d", "#008059", "#33567f"
DESTINATION, CURVE = "#7a2bd6", "#a34a06"
MAP_COLOURS = ("#9e9e9e", "#ffffff", "#000000", "#6fd66f")
"""Unknown, free, occupied, frontier (paper, Fig. 1)."""


@contextmanager
def print_style() -> Iterator[None]:
    """Small type, thin lines; text in SVG and PDF stays text."""
    from matplotlib import rc_context

    settings: Any = {
        "font.size": 8.0,
        "axes.titlesize": 8.5,
        "axes.linewidth": 0.6,
        "xtick.major.width": 0.6,
        "ytick.major.width": 0.6,
        "legend.fontsize": 7.5,
        "legend.frameon": False,
        "svg.fonttype": "none",
        "svg.hashsalt": "swarmscout",
        "pdf.fonttype": 42,
    }
    with rc_context(settings):
        yield


def ring_of_dots() -> Any:
    """A marker: eight dots on a circle (paper, Fig. 9)."""
    import numpy as np
    from matplotlib.path import Path as Outline

    angles = np.arange(8) * (np.pi / 4)
    dot = Outline.circle(radius=0.17)
    outline = np.asarray(dot.vertices)
    return Outline.make_compound_path(
        *(Outline(outline + np.array([np.cos(a), np.sin(a)]), dot.codes) for a in angles)
    )
