"""The page's files: others' libraries unchanged, our own named and in order, all in the wheel."""

from __future__ import annotations

import hashlib
import json
import re
import tomllib
from dataclasses import asdict
from pathlib import Path

import swarmscout
from swarmscout.viewing.palette import DARK, LIGHT
from swarmscout.viewing.player.page import PAGE_FILES, file_bytes, one_file, served_policy

PAGE = Path(swarmscout.__file__).parent / "viewing" / "player" / "page"


def test_libraries_are_the_official_files():
    libraries = tomllib.loads((PAGE / "vendor" / "vendor.toml").read_text(encoding="utf-8"))
    sums = {}
    for library in libraries.values():
        assert library["version"]
        assert library["licence"].startswith("MIT")
        assert set(library["from"]) == set(library["sha256"])
        sums |= library["sha256"]
    there = {path.name for path in (PAGE / "vendor").iterdir()} - {"vendor.toml"}
    assert there == set(sums)
    for name, expected in sums.items():
        assert hashlib.sha256((PAGE / "vendor" / name).read_bytes()).hexdigest() == expected


def test_every_file_of_the_page_is_named():
    there = {
        path.relative_to(PAGE).as_posix()
        for path in PAGE.rglob("*")
        if path.suffix in (".js", ".css", ".html")
    }
    assert there - {"standalone.js"} == set(PAGE_FILES) - {"palette.js", "palette.css"}


def test_nothing_names_another_host():
    for name in PAGE_FILES:
        if not name.startswith("vendor/"):
            assert not re.search(rb"https?://", file_bytes(name)), name


def test_our_modules_are_small():
    for path in PAGE.glob("*.js"):
        assert len(path.read_text(encoding="utf-8").splitlines()) < 400, path.name


def test_one_file_holds_everything():
    page = one_file("a <b> & c", [b"data"]).decode()
    assert "<title>a &lt;b&gt; &amp; c</title>" in page
    assert not re.search(r"<script[^>]* src=|<link[^>]*stylesheet", page)
    assert page.count('<script type="application/x-code"') == sum(
        name.endswith(".js") for name in PAGE_FILES
    )
    policy = re.search(r'Content-Security-Policy" content="([^"]*)"', page).group(1)
    for where in (policy, served_policy()):
        assert "default-src 'none'" in where
        assert "unsafe" not in where
        assert "http" not in where


def test_the_page_has_the_palettes_of_all_pictures():
    script = file_bytes("palette.js").decode()
    palettes = json.loads(script.removeprefix("export const PALETTES = ").rstrip(";\n"))
    assert palettes == {"light": asdict(LIGHT), "dark": asdict(DARK)}
    style = file_bytes("palette.css").decode()
    for palette in (LIGHT, DARK):
        for colour in asdict(palette).values():
            assert colour in style
    for name in PAGE_FILES:
        if name.endswith(("style.css", "overlay.js", "map.js", "colours.js", "curves.js")):
            assert not re.search(rb"#[0-9a-f]{6}\b", file_bytes(name)), name
