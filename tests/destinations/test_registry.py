"""Selectors are found by name and by file, and what is wrong is said in one line."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

from swarmscout.core.errors import SelectorError
from swarmscout.destinations.nearest import Nearest
from swarmscout.destinations.quantile import Quantile
from swarmscout.destinations.registry import RECOMMENDED, make_selector, selectors

CHOICE = "from swarmscout.destinations.selector import Choice\n"
SOUND = (
    CHOICE
    + "class First:\n"
    + "    def __init__(self, skip=0):\n        self.skip = skip\n"
    + "    def choose(self, view, memory):\n"
    + "        return Choice(tuple(view.frontiers[self.skip]))\n"
)


def test_names() -> None:
    names = selectors()
    assert {"quantile", "nearest", "random"} <= set(names)
    assert RECOMMENDED in names
    assert all(line and "\n" not in line for line in names.values())
    assert make_selector("nearest") == Nearest()
    assert make_selector("quantile", {"sigma": 0.1}) == Quantile(sigma=0.1)


@pytest.mark.parametrize(
    ("name", "parameters", "says"),
    [
        ("quantil", None, "unknown selector 'quantil': did you mean 'quantile'?"),
        ("Nearest", None, "did you mean 'nearest'?"),
        ("zzz", None, "unknown selector 'zzz': known: "),
        ("quantile", {"sigme": 0.1}, "no parameter 'sigme': did you mean 'sigma'?"),
        ("nearest", {"far": 1}, "selector 'nearest' has no parameter 'far': it takes none"),
        (
            "quantile",
            {"sigma": -1.0},
            "selector 'quantile': sigma = -1.0: should be greater",
        ),
        ("quantile", {"bias_min": "a"}, "selector 'quantile': "),
        ("rule.py", None, "names a file but no class in it: write 'rule.py:ClassName'"),
        ("missing.py:Rule", None, "selector file 'missing.py' does not exist"),
    ],
)
def test_mistakes_with_names(name: str, parameters: Any, says: str) -> None:
    with pytest.raises(SelectorError) as caught:
        make_selector(name, parameters)
    assert says in str(caught.value)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("text", "attribute", "says"),
    [
        ("class Frist:\n    pass\n", "First", "has no 'First': did you mean 'Frist'?"),
        ("x = 1\n", "First", "has no 'First': none are known"),
        ("class First\n    pass\n", "First", "cannot be loaded: SyntaxError"),
        ("import no_such_module_at_all\n", "First", "cannot be loaded: ModuleNotFoundError"),
        ("1 / 0\n", "First", "cannot be loaded: ZeroDivisionError"),
        ("class First:\n    pass\n", "First", "it has no method choose(view, memory)"),
        ("First = 3\n", "First", "'{file}:First'"),
        (
            "class First:\n    def __init__(self):\n        raise ValueError('no luck')\n",
            "First",
            "'{file}:First': no luck",
        ),
    ],
)
def test_mistakes_in_files(tmp_path: Path, text: str, attribute: str, says: str) -> None:
    file = tmp_path / "rule.py"
    file.write_text(text)
    with pytest.raises(SelectorError) as caught:
        make_selector(f"{file}:{attribute}")
    assert says.format(file=file) in str(caught.value)
    assert "\n" not in str(caught.value)


def test_files_are_found_from_a_base_folder_and_do_not_replace_each_other(tmp_path: Path) -> None:
    made = []
    for number in range(2):
        folder = tmp_path / str(number)
        folder.mkdir()
        (folder / "rule.py").write_text(SOUND + f"NUMBER = {number}\n")
        made.append(make_selector("rule.py:First", {"skip": number}, base=folder))
    assert type(made[0]) is not type(made[1])
    assert [selector.skip for selector in made] == [0, 1]
    with pytest.raises(SelectorError, match="no parameter 'skp': did you mean 'skip'"):
        make_selector("rule.py:First", {"skp": 1}, base=tmp_path / "0")


def test_dataclasses_work_in_files(tmp_path: Path) -> None:
    file = tmp_path / "rule.py"
    file.write_text(
        "from __future__ import annotations\nfrom dataclasses import dataclass\n"
        + CHOICE
        + "@dataclass(frozen=True, slots=True)\nclass Rule:\n    weight: float = 1.0\n"
        + "    def choose(self, view, memory):\n        return Choice(tuple(view.frontiers[0]))\n"
    )
    assert make_selector(f"{file}:Rule", {"weight": 2.0}).weight == 2.0


def test_a_file_s_module_has_the_same_name_in_every_process(tmp_path: Path) -> None:
    """Numba looks the module of a cached kernel up by its name."""
    (tmp_path / "mine.py").write_text(
        "from swarmscout.destinations.nearest import Nearest\nclass Mine(Nearest):\n    pass\n"
    )
    ask = (
        "from swarmscout.destinations.registry import make_selector\n"
        f"print(type(make_selector({str(tmp_path / 'mine.py')!r} + ':Mine')).__module__)"
    )
    names = {
        subprocess.run(
            [sys.executable, "-c", ask],
            env={**os.environ, "PYTHONHASHSEED": seed},
            capture_output=True,
            text=True,
            check=True,
        ).stdout
        for seed in ("1", "2")
    }
    assert len(names) == 1


def test_selectors_of_other_packages_are_listed_by_their_docstrings(tmp_path: Path) -> None:
    (tmp_path / "far_away.py").write_text(SOUND.replace("First:\n", "Far:\n    'The far one.'\n"))
    info = tmp_path / "far_pack-1.0.dist-info"
    info.mkdir()
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: far-pack\nVersion: 1.0\n")
    (info / "entry_points.txt").write_text(
        "[swarmscout.selectors]\nfar = far_away:Far\nbroken = far_away:Gone\n"
        "random = far_away:Far\n"
    )
    ask = (
        "from swarmscout.destinations.registry import make_selector, selectors\n"
        "names = selectors()\n"
        "print(names['far'], names['broken'], type(make_selector('far')).__module__, sep='|')\n"
        "print(type(make_selector('random')).__module__)"
    )
    path = os.pathsep.join([str(tmp_path), *sys.path])
    done = subprocess.run(
        [sys.executable, "-c", ask],
        env={**os.environ, "PYTHONPATH": path},
        capture_output=True,
        text=True,
        check=True,
    )
    first, second = done.stdout.splitlines()
    assert first.startswith("The far one. (from far-pack)|selector 'broken' (far_away:Gone) cannot")
    assert first.endswith("|far_away")
    assert second == "swarmscout.destinations.random"
