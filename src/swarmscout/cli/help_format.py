"""The help of all commands as plain text in two columns, at the terminal's width."""

from __future__ import annotations

import re
import textwrap
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from cyclopts.help import HelpEntry, HelpPanel
    from rich.console import Console, ConsoleOptions

__all__ = ["TwoColumns"]

_TITLES = {"Parameters": "Options"}
_INDENT = "  "
_WIDEST_LABEL = 26
_NARROW = 60  # Columns; below this, descriptions stand under their options.


class TwoColumns:
    """Draws help pages; paragraphs are wrapped here and not where a docstring breaks its lines."""

    def __call__(self, console: Console, options: ConsoleOptions, panel: HelpPanel) -> None:
        """One panel: commands, arguments or options."""
        if not panel.entries:
            return
        title = _plain(panel.title)
        console.out(f"{_TITLES.get(title, title)}:", highlight=False)
        labels = [", ".join(entry.display_labels_with_metavar) for entry in panel.entries]
        width = min(_WIDEST_LABEL, max(map(len, labels)))
        for label, entry in zip(labels, panel.entries, strict=True):
            console.out(_row(label, _meaning(entry), width, console.width), highlight=False)
        console.out("")

    def render_usage(self, console: Console, options: ConsoleOptions, usage: Any) -> None:
        """The line on how to call the command."""
        if usage:
            console.out(f"{_filled(f'Usage: {_plain(usage)}', console.width)}\n", highlight=False)

    def render_description(
        self, console: Console, options: ConsoleOptions, description: Any
    ) -> None:
        """What the command does, paragraph by paragraph."""
        text = _plain(description)
        if text:
            for paragraph in re.split(r"\n\s*\n", text):
                filled = _filled(" ".join(paragraph.split()), console.width)
                console.out(f"{filled}\n", highlight=False)


def _row(label: str, meaning: str, width: int, columns: int) -> str:
    if columns < _NARROW:
        return f"{_INDENT}{label}\n{_filled(meaning, columns, 3 * _INDENT)}".rstrip()
    body = _filled(meaning, columns, " " * (width + 2 * len(_INDENT)))
    if len(label) > width:
        return f"{_INDENT}{label}\n{body}".rstrip()
    return f"{_INDENT}{label:<{width}}{body[len(_INDENT) + width :]}".rstrip()


def _filled(text: str, columns: int, indent: str = "") -> str:
    return textwrap.fill(
        text, columns, initial_indent=indent, subsequent_indent=indent, break_on_hyphens=False
    )


def _meaning(entry: HelpEntry) -> str:
    parts = [" ".join(_plain(entry.description).split())]
    if entry.choices:
        parts.append(f"[{', '.join(entry.choices)}]")
    if entry.default not in (None, "True", "False"):
        parts.append(f"[default: {entry.default}]")
    if entry.default in ("True", "False") and entry.negative_names:
        parts.append(f"[default: {'on' if entry.default == 'True' else 'off'}]")
    if entry.required:
        parts.append("[required]")
    return " ".join(part for part in parts if part)


def _plain(text: Any) -> str:
    """The text of what Cyclopts hands over: a Rich text, perhaps wrapped once."""
    if text is None:
        return ""
    inner = getattr(text, "primary_renderable", text)
    return str(getattr(inner, "plain", inner)).strip()
