"""A report as one self-contained HTML page, and as Markdown with figures beside it."""

from __future__ import annotations

import base64
import html
import io
import re
from collections.abc import Iterable, Mapping, Sequence

from matplotlib.figure import Figure

from swarmscout.studies.report_elements import Block, Code, Heading, Picture, Table, Text, Warn

__all__ = ["figure_bytes", "html_page", "markdown_page"]

_STYLE = """
:root { color-scheme: light dark; --ink: #1d2329; --paper: #fff; --soft: #49535d;
  --line: #d6dbe0; --strong: #8a949e; --code: #eef1f4; --link: #0b5fa5;
  --warn: #fff4d6; --edge: #d49a00; }
@media (prefers-color-scheme: dark) {
  :root { --ink: #e3e7eb; --paper: #15191d; --soft: #a9b3bd; --line: #363e46; --strong: #6b7580;
    --code: #232a31; --link: #7dbcf5; --warn: #3a3115; --edge: #d49a00; }
}
body { font: 16px/1.55 system-ui, -apple-system, "Segoe UI", "DejaVu Sans", sans-serif;
  color: var(--ink); background: var(--paper); max-width: 62rem; margin: 2rem auto;
  padding: 0 1.2rem; overflow-wrap: break-word; }
h1 { font-size: 1.7rem; line-height: 1.25; margin: 0 0 .4rem; }
h2 { font-size: 1.25rem; margin: 2.2rem 0 .5rem; border-bottom: 1px solid var(--line); }
h3 { font-size: 1.05rem; margin: 1.4rem 0 .4rem; }
p { margin: .5rem 0; max-width: 48rem; }
a { color: var(--link); }
nav { margin: .8rem 0; padding: .5rem .9rem; background: var(--code); border-radius: 4px;
  font-size: .9rem; }
nav a { margin-right: 1.1rem; display: inline-block; }
.warn { background: var(--warn); border-left: 4px solid var(--edge); padding: .5rem .8rem; }
code, pre { font-family: ui-monospace, "DejaVu Sans Mono", monospace; font-size: .9em; }
code { background: var(--code); border-radius: 3px; padding: 0 .25em; }
pre { background: var(--code); padding: .7rem .9rem; overflow-x: auto; border-radius: 4px; }
pre code { background: none; padding: 0; }
.wide { overflow-x: auto; margin: .7rem 0; }
table { border-collapse: collapse; font-size: .88rem; font-variant-numeric: tabular-nums; }
th, td { padding: .28rem .7rem; text-align: left; border-bottom: 1px solid var(--line);
  white-space: nowrap; }
th { border-bottom: 2px solid var(--strong); vertical-align: bottom; white-space: normal; }
table.words td, td code { white-space: normal; }
td.number, th.number { text-align: right; }
figure { margin: 1rem 0 1.6rem; }
figure img { max-width: 100%; height: auto; display: block; }
figcaption { font-size: .88rem; color: var(--soft); max-width: 48rem; margin-top: .4rem; }
@page { margin: 16mm; }
@media print {
  body { margin: 0; padding: 0; max-width: none; font-size: 10pt; }
  h2, h3 { break-after: avoid; }
  figure, tr, .warn { break-inside: avoid; }
  nav { display: none; }
  .wide { overflow: visible; }
  table { font-size: 7.5pt; }
  th, td { padding: .15rem .35rem; white-space: normal; }
  pre { white-space: pre-wrap; }
}
"""

# Matplotlib writes colours as inline styles, and text and black lines partly with none at all.
_DARK_FIGURE = """<style>@media (prefers-color-scheme: dark) {
svg { fill: #e3e7eb; }
[style*="fill: #ffffff"] { fill: #15191d !important; }
[style*="stroke: #ffffff"] { stroke: #15191d !important; }
[style*="fill: #000000"] { fill: #e3e7eb !important; }
[style*="stroke: #000000"] { stroke: #e3e7eb !important; }
[style*="stroke: #0072b2"] { stroke: #4aa8e0 !important; }
[style*="fill: #0072b2"] { fill: #4aa8e0 !important; }
}</style>"""

_CONTENTS_FROM = 4
"""Number of sections from which on a page has a table of contents."""


def figure_bytes(figure: Figure, kind: str) -> bytes:
    """A figure as ``svg``, ``pdf`` or ``png``; the same figure gives the same bytes."""
    import matplotlib

    packed = io.BytesIO()
    dates = {"svg": {"Date": None}, "pdf": {"CreationDate": None}, "png": {}}
    with matplotlib.rc_context({"svg.hashsalt": "swarmscout", "pdf.fonttype": 42}):
        figure.savefig(packed, format=kind, metadata=dates[kind], dpi=130)
    return packed.getvalue()


def html_page(title: str, blocks: Iterable[Block], pictures: Mapping[str, bytes]) -> str:
    """One page that loads nothing from elsewhere, light or dark as the reader's system is.

    Args:
        title: the window's title.
        blocks: the page's contents.
        pictures: SVG of each picture, by its name.
    """
    blocks = list(blocks)
    parts = [_html(block, pictures) for block in blocks]
    contents = _contents([b for b in blocks if isinstance(b, Heading) and b.level == 2])
    titles = (at for at, b in enumerate(blocks) if isinstance(b, Heading) and b.level == 1)
    parts.insert(next(titles, -1) + 1, contents)
    body = "\n".join(part for part in parts if part)
    return (
        f'<!doctype html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
        f'<meta name="viewport" content="width=device-width, initial-scale=1">\n'
        f'<link rel="icon" href="data:,">\n<title>{html.escape(title)}</title>\n'
        f"<style>{_STYLE}</style>\n</head>\n<body>\n{body}\n</body>\n</html>\n"
    )


def markdown_page(blocks: Iterable[Block], folder: str = "figures") -> str:
    """The same contents as Markdown.

    Args:
        blocks: the page's contents.
        folder: the figures' folder, relative to the page.
    """
    return "\n\n".join(_markdown(block, folder) for block in blocks) + "\n"


def _contents(sections: Sequence[Heading]) -> str:
    if len(sections) < _CONTENTS_FROM:
        return ""
    links = "\n".join(f'<a href="#{_anchor(s.text)}">{_inline(s.text)}</a>' for s in sections)
    return f'<nav aria-label="Contents">\n{links}\n</nav>'


def _anchor(text: str) -> str:
    return re.sub(r"[^a-z0-9]+", "-", text.lower()).strip("-")


def _html(block: Block, pictures: Mapping[str, bytes]) -> str:
    match block:
        case Heading(text, level):
            anchor = f' id="{_anchor(text)}"' if level == 2 else ""
            return f"<h{level}{anchor}>{_inline(text)}</h{level}>"
        case Text(text):
            return f"<p>{_inline(text)}</p>"
        case Warn(text):
            return f'<p class="warn">{_inline(text)}</p>'
        case Code(text):
            return f"<pre><code>{html.escape(text)}</code></pre>"
        case Table():
            return _html_table(block)
        case Picture(name, _, caption):
            data = base64.b64encode(_follows_the_page(pictures[name])).decode()
            alt = html.escape(re.sub(r"[`*]", "", caption), quote=True)
            return (
                f'<figure id="{name}"><img alt="{alt}" src="data:image/svg+xml;base64,{data}">\n'
                f"<figcaption>{_inline(caption)}</figcaption></figure>"
            )


def _follows_the_page(svg: bytes) -> bytes:
    """A figure that is dark where the page is."""
    return re.sub(rb"(<svg[^>]*>)", rb"\1" + _DARK_FIGURE.encode(), svg, count=1)


def _html_table(table: Table) -> str:
    def row(cells: Iterable[str], tag: str) -> str:
        shown = (
            f'<{tag} class="number">{_inline(cell)}</{tag}>'
            if at >= table.numbers
            else f"<{tag}>{_inline(cell)}</{tag}>"
            for at, cell in enumerate(cells)
        )
        return f"<tr>{''.join(shown)}</tr>"

    rows = "\n".join(row(cells, "td") for cells in table.rows)
    head = row(table.header, "th")
    kind = ' class="words"' if table.numbers >= len(table.header) else ""
    inside = f"<thead>{head}</thead>\n<tbody>{rows}</tbody>"
    return f'<div class="wide"><table{kind}>\n{inside}</table></div>'


def _inline(text: str) -> str:
    """Markdown code and bold as HTML; within code nothing is markup."""
    parts = re.split(r"(?<!`)(`+)(?!`)(.+?)(?<!`)\1(?!`)", text)
    shown = []
    for plain, fence, code in zip(parts[::3], [*parts[1::3], ""], [*parts[2::3], ""], strict=True):
        escaped = html.escape(plain, quote=False)
        shown.append(re.sub(r"\*\*([^*]+)\*\*", r"<strong>\1</strong>", escaped))
        if fence:
            inside = code[1:-1] if len(fence) > 1 else code
            shown.append(f"<code>{html.escape(inside, quote=False)}</code>")
    return "".join(shown)


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
