"""Blocks as one self-contained HTML page, and as Markdown with figures beside it."""

from __future__ import annotations

import base64
import html
import io
import re
from collections.abc import Iterable, Mapping

from matplotlib.figure import Figure

from swarmscout.studies.report_elements import Block, Code, Heading, Picture, Table, Text, Warn

__all__ = ["figure_bytes", "html_page", "markdown_page"]

_STYLE = """
:root { color-scheme: light; }
body { font: 16px/1.55 system-ui, -apple-system, "Segoe UI", "DejaVu Sans", sans-serif;
  color: #1d2329; background: #fff; max-width: 62rem; margin: 2rem auto; padding: 0 1.2rem; }
h1 { font-size: 1.7rem; line-height: 1.25; margin: 0 0 .4rem; }
h2 { font-size: 1.25rem; margin: 2.2rem 0 .5rem; border-bottom: 1px solid #d6dbe0; }
h3 { font-size: 1.05rem; margin: 1.4rem 0 .4rem; }
p { margin: .5rem 0; max-width: 48rem; }
.warn { background: #fff4d6; border-left: 4px solid #d49a00; padding: .5rem .8rem; }
code, pre { font-family: ui-monospace, "DejaVu Sans Mono", monospace; font-size: .9em; }
code { background: #eef1f4; border-radius: 3px; padding: 0 .25em; }
pre { background: #eef1f4; padding: .7rem .9rem; overflow-x: auto; border-radius: 4px; }
pre code { background: none; padding: 0; }
.wide { overflow-x: auto; margin: .7rem 0; }
table { border-collapse: collapse; font-size: .88rem; font-variant-numeric: tabular-nums; }
th, td { padding: .28rem .7rem; text-align: left; border-bottom: 1px solid #e3e7eb;
  white-space: nowrap; }
th { border-bottom: 2px solid #8a949e; vertical-align: bottom; white-space: normal; }
table.words td { white-space: normal; }
td.number, th.number { text-align: right; }
figure { margin: 1rem 0 1.6rem; }
figure img { max-width: 100%; height: auto; display: block; }
figcaption { font-size: .88rem; color: #49535d; max-width: 48rem; margin-top: .4rem; }
@page { margin: 16mm; }
@media print {
  body { margin: 0; padding: 0; max-width: none; font-size: 10pt; }
  h2, h3 { break-after: avoid; }
  figure, tr, .warn { break-inside: avoid; }
  .wide { overflow: visible; }
  table { font-size: 7.5pt; }
  th, td { padding: .15rem .35rem; white-space: normal; }
  pre { white-space: pre-wrap; }
}
"""


def figure_bytes(figure: Figure, kind: str) -> bytes:
    """A figure as ``svg``, ``pdf`` or ``png``; the same figure gives the same bytes."""
    import matplotlib

    packed = io.BytesIO()
    dates = {"svg": {"Date": None}, "pdf": {"CreationDate": None}, "png": {}}
    with matplotlib.rc_context({"svg.hashsalt": "swarmscout", "pdf.fonttype": 42}):
        figure.savefig(packed, format=kind, metadata=dates[kind], dpi=130)
    return packed.getvalue()


def html_page(title: str, blocks: Iterable[Block], pictures: Mapping[str, bytes]) -> str:
    """One page that needs nothing from anywhere.

    Args:
        title: of the window.
        blocks: what is on it.
        pictures: SVG of each picture, by its name.
    """
    body = "\n".join(_html(block, pictures) for block in blocks)
    return (
        f'<!doctype html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
        f'<meta name="viewport" content="width=device-width, initial-scale=1">\n'
        f'<link rel="icon" href="data:,">\n<title>{html.escape(title)}</title>\n'
        f"<style>{_STYLE}</style>\n</head>\n<body>\n{body}\n</body>\n</html>\n"
    )


def markdown_page(blocks: Iterable[Block], folder: str = "figures") -> str:
    """The same as Markdown.

    Args:
        blocks: what is on it.
        folder: where the figures lie, seen from the page.
    """
    return "\n\n".join(_markdown(block, folder) for block in blocks) + "\n"


def _html(block: Block, pictures: Mapping[str, bytes]) -> str:
    match block:
        case Heading(text, level):
            return f"<h{level}>{_inline(text)}</h{level}>"
        case Text(text):
            return f"<p>{_inline(text)}</p>"
        case Warn(text):
            return f'<p class="warn">{_inline(text)}</p>'
        case Code(text):
            return f"<pre><code>{html.escape(text)}</code></pre>"
        case Table():
            return _html_table(block)
        case Picture(name, _, caption):
            data = base64.b64encode(pictures[name]).decode()
            alt = html.escape(re.sub(r"[`*]", "", caption), quote=True)
            return (
                f'<figure id="{name}"><img alt="{alt}" src="data:image/svg+xml;base64,{data}">\n'
                f"<figcaption>{_inline(caption)}</figcaption></figure>"
            )


def _html_table(table: Table) -> str:
    def row(cells: Iterable[str], tag: str) -> str:
        told = (
            f'<{tag} class="number">{_inline(cell)}</{tag}>'
            if at >= table.numbers
            else f"<{tag}>{_inline(cell)}</{tag}>"
            for at, cell in enumerate(cells)
        )
        return f"<tr>{''.join(told)}</tr>"

    rows = "\n".join(row(cells, "td") for cells in table.rows)
    head = row(table.header, "th")
    kind = ' class="words"' if table.numbers >= len(table.header) else ""
    inside = f"<thead>{head}</thead>\n<tbody>{rows}</tbody>"
    return f'<div class="wide"><table{kind}>\n{inside}</table></div>'


def _inline(text: str) -> str:
    told = html.escape(text, quote=False)
    told = re.sub(r"`([^`]+)`", r"<code>\1</code>", told)
    return re.sub(r"\*\*([^*]+)\*\*", r"<strong>\1</strong>", told)


def _markdown(block: Block, folder: str) -> str:
    match block:
        case Heading(text, level):
            return f"{'#' * level} {text}"
        case Text(text):
            return text
        case Warn(text):
            return f"> **Note:** {text}"
        case Code(text):
            return f"```\n{text.rstrip()}\n```"
        case Picture(name, _, caption):
            alt = re.sub(r"[`*\[\]]", "", caption.partition(". ")[0])
            return f"![{alt}]({folder}/{name}.svg)\n\n{caption}"
        case Table(header, rows, numbers):
            line = ["---" if at < numbers else "---:" for at in range(len(header))]
            cells = [header, line, *([cell.replace("|", "\\|") for cell in row] for row in rows)]
            return "\n".join(f"| {' | '.join(row)} |" for row in cells)
