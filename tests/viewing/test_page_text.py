"""Texts on the page and in exported files: bounded, private, harmless."""

from __future__ import annotations

import base64
import getpass
import gzip
import re
import textwrap
from pathlib import Path

import numpy as np
import pytest

from swarmscout import Run, Scenario, map_picture, record_mission
from swarmscout.viewing.mission_figures.catalogue import make_figures
from swarmscout.viewing.player.export import export_page
from swarmscout.viewing.player.page_text import page_data, page_text


@pytest.mark.parametrize(
    ("text", "shown"),
    [
        ("/opt/rules.py:Mine", "rules.py:Mine"),
        ("see /home/bob", "see ~"),
        ("'/Users/bob/a b.txt'", "'a b.txt'"),
        (r"C:\Users\bob\maps\cave.npy", "cave.npy"),
        ("file:///srv/maps/cave.obj", "cave.obj"),
        ("http://host/v1/chat", "http://host/v1/chat"),
        ("and/or 1/2 ./a/b ((3/4))", "and/or 1/2 ./a/b ((3/4))"),
        ("a /3/4 b", "a /3/4 b"),
        ("\x1b[31mred\x07\u202e", "\ufffd[31mred\ufffd\ufffd"),
        ("one\r\ntwo\tthree", "one\ntwo\tthree"),
        ("\ud800", "\ufffd"),
        ("<b>[/bold] $x_$</b>", "<b>[/bold] $x_$</b>"),
    ],
)
def test_texts_lose_folders_and_controls_and_nothing_else(text, shown):
    assert page_text(text) == shown


def test_the_home_folder_is_not_shown():
    assert page_text(f"read {Path.home()}/a/b.txt") == "read a/b.txt"
    assert page_data({"x": [f"{Path.home()}", float("nan"), 1]}) == {"x": ["~", None, 1]}


def test_long_texts_are_cut():
    assert page_text("x" * 30_000).endswith(" … (30,000 characters, cut)")
    assert page_text("x" * 20_000) == "x" * 20_000


RULE = """
    from swarmscout.destinations.selector import Choice

    class Rule:
        def choose(self, view, memory=None):
            cell = tuple(int(part) for part in view.frontiers[0])
            return Choice(cell, reason=f"by {__file__} \\x1b[2J", details={"file": __file__})
"""


@pytest.fixture(scope="module")
def private(tmp_path_factory: pytest.TempPathFactory) -> Run:
    """A run whose world and selector are files in a folder with a telling name."""
    folder = tmp_path_factory.mktemp("secret-folder")
    (folder / "$my_$rule.py").write_text(textwrap.dedent(RULE), encoding="utf-8")
    free = np.zeros((60, 60), dtype=np.uint8)
    free[2:-2, 2:-2] = 1
    np.save(folder / "room.npy", free)
    scenario = Scenario(
        world=str(folder / "room.npy"), robots=3, steps=12, start="spread",
        destinations=f"{folder / '$my_$rule.py'}:Rule",
    )  # fmt: skip
    return record_mission(scenario, out=folder / "run")


def test_an_exported_page_holds_no_folder_and_no_user_name(private, tmp_path):
    page = export_page([private], tmp_path / "page.html").read_bytes()
    kind = rb'<script type="application/x-(?:mission|belief)[^>]*>([^<]*)<'
    parts = [page, *(gzip.decompress(base64.b64decode(x)) for x in re.findall(kind, page))]
    assert len(parts) > 1
    assert any(b"$my_$rule.py:Rule" in part for part in parts)
    words = [b"secret-folder", str(Path.home()).encode() + b"/"]
    words += [f"/{getpass.getuser()}/".encode()]
    for part in parts:
        assert not [word for word in words if word in part]
        assert rb"\u001b" not in part


def test_names_are_text_and_not_formulas(private, tmp_path):
    assert map_picture(private, tmp_path / "map.png").stat().st_size > 1000
    assert make_figures(private, tmp_path / "figures", names=("team-map",), dpi=60)
