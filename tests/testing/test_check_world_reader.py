"""World readers in a file and of another package, and their conformance check."""

from __future__ import annotations

import importlib.metadata
import re
from pathlib import Path

import numpy as np
import pytest

from swarmscout.core.errors import WorldError
from swarmscout.testing import check_world_reader
from swarmscout.worlds import load_world, world_from_array

SOURCE = """
import numpy as np
from swarmscout.core.errors import WorldError
from swarmscout.worlds import world_from_array

class CsvReader:
    suffixes = (".csv",)

    def read(self, path, seed):
        if path is None:
            return world_from_array(np.ones((60, 60 + 10 * seed), dtype=bool), 0.1, name="made")
        try:
            free = np.loadtxt(path, delimiter=",", dtype=int) == 0
        except ValueError as error:
            raise WorldError(f"'{path}': {error}") from None
        return world_from_array(free, 0.1, name=path.stem)
"""


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "my.py").write_text(SOURCE)
    occupied = np.zeros((50, 70), dtype=int)
    occupied[20:30, 20:30] = 1
    np.savetxt(tmp_path / "map.csv", occupied, fmt="%d", delimiter=",")
    return tmp_path


def test_a_reader_in_a_file(folder):
    assert load_world("my.py:CsvReader:map.csv").free.sum() == 50 * 70 - 100
    assert load_world("my.py:CsvReader", seed=2).free.shape == (60, 80)
    assert load_world("my.py:CsvReader:map.csv", base=folder, start_m=(1, 1)).start_m == (1.0, 1.0)
    for what, says in (
        ("my.py:Other", "has no 'Other'"),
        ("gone.py:CsvReader", "'gone.py' does not exist"),
        ("my.py:CsvReader:gone.csv", "'gone.csv' does not exist"),
        ("map.csv", "unknown kind of file '.csv': known are"),
    ):
        with pytest.raises(WorldError, match=says):
            load_world(what)
    with pytest.raises(WorldError, match=r"cell_m = 0\.5 has no meaning for a world reader"):
        load_world("my.py:CsvReader", cell_m=0.5)


def test_a_reader_of_another_package(folder, monkeypatch):
    monkeypatch.syspath_prepend(str(folder))
    point = importlib.metadata.EntryPoint("csv-maps", "my:CsvReader", "swarmscout.world_readers")
    monkeypatch.setattr(
        "swarmscout.core.registry.entry_points",
        lambda group: [point] if group == point.group else [],
    )
    assert load_world("map.csv").free.sum() == 50 * 70 - 100
    assert load_world("csv-maps").name == "made"
    assert load_world("csv-maps:map.csv").name == "map"


def test_whatever_a_reader_does_wrong_is_one_line(folder):
    for body, says in (
        ("return 7", "returned a int, expected a World"),
        ("return 1 / 0", "failed: ZeroDivisionError"),
    ):
        text = f"class R:\n    suffixes = ()\n    def read(self, path, seed):\n        {body}\n"
        name = f"r{len(says)}.py"
        (folder / name).write_text(text)
        with pytest.raises(WorldError, match=says) as caught:
            load_world(f"{name}:R")
        assert "\n" not in str(caught.value)


def test_a_sound_reader(folder):
    report = check_world_reader("my.py:CsvReader", [folder / "map.csv"])
    assert report.name == "my.py:CsvReader"
    assert "a damaged file '*.csv'" in str(report)
    with pytest.raises(WorldError, match="give some"):
        check_world_reader("my.py:CsvReader")


class Made:
    suffixes = ()

    def read(self, path, seed):
        return world_from_array(np.ones((60, 60), dtype=bool), 0.1)


class Random(Made):
    def read(self, path, seed):
        free = np.random.random((60, 60)) < 2.0  # noqa: NPY002
        return world_from_array(free, 0.1)


class Counting(Made):
    def __init__(self):
        self.count = 0

    def read(self, path, seed):
        self.count += 1
        return world_from_array(np.ones((60, 60 + self.count), dtype=bool), 0.1)


class Narrow(Made):
    def read(self, path, seed):
        return world_from_array(np.ones((2, 60), dtype=bool), 0.1)


class Suffix(Made):
    suffixes = ("csv",)


class Greedy(Made):
    suffixes = (".csv",)


class OneArgument(Made):
    def read(self, path):
        return super().read(path, 0)


@pytest.mark.parametrize(
    ("reader", "says"),
    [
        (Random, "draws from a global random generator"),
        (Counting, "gives another world the second time"),
        (Narrow, "no robot of 0.3 m fits"),
        (Suffix, "expected a tuple such as"),
        (Greedy, "makes a world of a damaged file"),
        (OneArgument, r"does not take two arguments, read\(path, seed\)"),
    ],
)
def test_unsound_readers(folder, reader, says):
    files = [folder / "map.csv"] if reader is Greedy else []
    with pytest.raises(WorldError, match=says):
        check_world_reader(reader, files)
    assert check_world_reader(Made).situations


def test_the_reader_in_the_docs_is_sound(folder):
    page = (Path(__file__).parents[2] / "docs" / "worlds.md").read_text(encoding="utf-8")
    blocks = re.findall(r"```python\n(.*?)```", page, flags=re.DOTALL)
    block = next(block for block in blocks if "class CsvReader" in block)
    assert len(block.splitlines()) <= 10
    (folder / "my.py").write_text(block, encoding="utf-8")
    assert check_world_reader("my.py:CsvReader", [folder / "map.csv"]).situations
