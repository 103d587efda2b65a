"""The elements of a report, which pages of HTML and of Markdown are written from.

In texts and cells, `code` and **bold** are written as in Markdown.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["Block", "Code", "Heading", "Picture", "Table", "Text", "Warn"]


@dataclass(frozen=True)
class Heading:
    """A heading; level 1 is the title."""

    text: str
    level: int = 2


@dataclass(frozen=True)
class Text:
    """A paragraph."""

    text: str


@dataclass(frozen=True)
class Warn:
    """A highlighted paragraph."""

    text: str


@dataclass(frozen=True)
class Code:
    """Commands or a file."""

    text: str


@dataclass(frozen=True)
class Table:
    """Rows of cells; from column ``numbers`` on cells are aligned to the right."""

    header: Sequence[str]
    rows: Sequence[Sequence[str]]
    numbers: int = 1


@dataclass(frozen=True)
class Picture:
    """A figure.

    Attributes:
        name: stem of its files.
        figure: the figure.
        caption: what it shows, how it was measured, and what to look for.
    """

    name: str
    figure: Figure
    caption: str


Block = Heading | Text | Warn | Code | Table | Picture
