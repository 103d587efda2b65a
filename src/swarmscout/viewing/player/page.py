"""The player's page: its files, and the same page as one file that holds everything.

The page makes no requests to other hosts, and its Content-Security-Policy forbids them.
"""

from __future__ import annotations

import base64
import gzip
import hashlib
import html
import json
import re
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from functools import cache
from importlib.resources import files
from importlib.resources.abc import Traversable

from swarmscout.viewing.palette import DARK, LIGHT

__all__ = ["PAGE_FILES", "file_bytes", "one_file", "served_policy"]

PAGE_FILES: dict[str, str] = {
    "index.html": "text/html; charset=utf-8",
    "style.css": "text/css; charset=utf-8",
    "palette.css": "text/css; charset=utf-8",
    "vendor/uPlot.min.css": "text/css; charset=utf-8",
    **{
        f"{name}.js": "text/javascript; charset=utf-8"
        for name in (
            "vendor/uPlot.iife.min",
            "vendor/three.core.min",
            "vendor/three.module.min",
            "vendor/OrbitControls",
            "elements",
            "packets",
            "history",
            "mission",
            "sensing",
            "palette",
            "colours",
            "canvas",
            "teams",
            "overlay",
            "legend",
            "gauges",
            "map",
            "terrain",
            "terrain_cpu",
            "robots",
            "scene",
            "curves",
            "decisions",
            "describe",
            "timeline",
            "clock",
            "sources",
            "ownmap",
            "pointer",
            "keyboard",
            "main",
        )
    },
}
"""All files of the page and their types; a script stands after those that it imports."""

_NOTHING_ELSE = "default-src 'none'; img-src data: blob:; base-uri 'none'; form-action 'none'"
_IMPORT = re.compile(r"""\bfrom\s*["'](\./[^"']+|three)["']""")
_NAMES = {"three": "vendor/three.module.min.js"}


@cache
def file_bytes(name: str) -> bytes:
    """The bytes of one of :data:`PAGE_FILES`."""
    if name.startswith("palette."):
        return _palettes(name)
    place: Traversable = files("swarmscout.viewing.player").joinpath("page")
    for part in name.split("/"):
        place = place.joinpath(part)
    return place.read_bytes()


def _palettes(name: str) -> bytes:
    """The palettes as a script and as a style sheet."""
    palettes = {"dark": asdict(DARK), "light": asdict(LIGHT)}
    if name.endswith(".js"):
        return f"export const PALETTES = {json.dumps(palettes, indent=1)};\n".encode()
    rules = []
    for theme, colours in palettes.items():
        values = "".join(f" --{key}: {colour};" for key, colour in colours.items())
        rules.append(f':root[data-theme="{theme}"] {{ color-scheme: {theme};{values} }}\n')
    return "".join(rules).encode()


@cache
def served_policy() -> str:
    """The Content-Security-Policy for the page when a server hands out its files."""
    match = re.search(rb'<script type="importmap">(.*?)</script>', file_bytes("index.html"), re.S)
    assert match is not None
    return (
        f"{_NOTHING_ELSE}; script-src 'self' {_hash_of(match.group(1))}; style-src 'self'; "
        "connect-src 'self'; frame-ancestors 'none'"
    )


def one_file(
    title: str,
    missions: Sequence[bytes],
    beliefs: Sequence[Mapping[int, bytes]] = (),
) -> bytes:
    """The page as one HTML file.

    Args:
        title: of the page.
        missions: each mission's data, as :func:`swarmscout.viewing.player.recorded.player_data`
            makes it; one or two.
        beliefs: for each mission the maps of single robots, as
            :func:`swarmscout.viewing.player.beliefs.packed_beliefs` makes them.
    """
    styles = [file_bytes(name) for name in PAGE_FILES if name.endswith(".css")]
    start = file_bytes("standalone.js")
    policy = (
        f"{_NOTHING_ELSE}; script-src {_hash_of(start)} blob:; "
        f"style-src {' '.join(_hash_of(style) for style in styles)}"
    )
    head = [
        f'<meta http-equiv="Content-Security-Policy" content="{policy}">',
        f"<title>{html.escape(title)}</title>",
        *(f"<style>{style.decode()}</style>" for style in styles),
    ]
    body = [_embedded(name) for name in PAGE_FILES if name.endswith(".js")]
    body += [
        f'<script type="application/x-mission">{base64.b64encode(data).decode()}</script>'
        for data in missions
    ]
    body += [
        f'<script type="application/x-belief" data-mission="{k}" data-robot="{robot}">'
        f"{base64.b64encode(data).decode()}</script>"
        for k, maps in enumerate(beliefs)
        for robot, data in maps.items()
    ]
    body.append(f"<script>{start.decode()}</script>")
    page = file_bytes("index.html").decode()
    page = re.sub(r"<script.*?</script>\n|<link rel=\"stylesheet\".*?>\n", "", page)
    page = page.replace("<title>swarmscout</title>", "\n".join(head))
    return page.replace("</body>", "\n".join([*body, "</body>"])).encode()


def _embedded(name: str) -> str:
    """A script, zipped, with the files that its imports mean."""
    code = file_bytes(name)
    imports = {found: _file_behind(name, found) for found in _IMPORT.findall(code.decode())}
    known = list(PAGE_FILES)
    late = [file for file in imports.values() if known.index(file) >= known.index(name)]
    assert not late, f"{name} imports {late} but stands before it in PAGE_FILES"
    kind = "plain" if ".iife." in name else "module"
    facts = html.escape(json.dumps(imports))
    text = base64.b64encode(gzip.compress(code, mtime=0)).decode()
    return (
        f'<script type="application/x-code" data-file="{name}" data-kind="{kind}" '
        f'data-imports="{facts}">{text}</script>'
    )


def _file_behind(name: str, specifier: str) -> str:
    if specifier in _NAMES:
        return _NAMES[specifier]
    folder = name.rpartition("/")[0]
    file = specifier.removeprefix("./")
    return f"{folder}/{file}" if folder else file


def _hash_of(text: bytes) -> str:
    return f"'sha256-{base64.b64encode(hashlib.sha256(text).digest()).decode()}'"
