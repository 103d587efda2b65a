"""Sections of pages in docs/ that benchmarks write."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from swarmscout.studies.report_elements import Block, Picture
from swarmscout.studies.report_render import figure_bytes, markdown_page

BEGIN, END = "<!-- {} begin -->", "<!-- {} end -->"


def write_section(page: Path, name: str, blocks: Sequence[Block]) -> None:
    """Write blocks between two markers of a page, and their figures into docs/images."""
    images = page.parent / "images"
    images.mkdir(exist_ok=True)
    for block in blocks:
        if isinstance(block, Picture):
            (images / f"{block.name}.svg").write_bytes(figure_bytes(block.figure, "svg"))
    begin, end = BEGIN.format(name), END.format(name)
    before, found, rest = page.read_text(encoding="utf-8").partition(begin)
    _, also, after = rest.partition(end)
    if not (found and also):
        raise SystemExit(f"{page} has no markers '{begin}' and '{end}'")
    text = markdown_page(blocks, "images").strip()
    page.write_text(f"{before}{begin}\n\n{text}\n\n{end}{after}", encoding="utf-8")
