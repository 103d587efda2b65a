"""The commands that README and docs show are valid, and README's work in their order."""

from __future__ import annotations

import re
import shlex
import shutil
from pathlib import Path

import numpy as np
import pytest

from swarmscout.cli.app import app, main
from swarmscout.cli.values import with_values_joined

ROOT = Path(__file__).parents[2]
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md")), ROOT / "examples/README.md"]
BLOCK = re.compile(r"^```(\w*)\n(.*?)^```", flags=re.DOTALL | re.MULTILINE)
PROGRAM = re.compile(r"(?:\$ )?(?:\.venv/bin/)?swarmscout ")
# They wait for a browser or a network, or serve pages until Ctrl-C.
WAITS = re.compile(r"--view|--rerun|--engine dask|view \S+( \S+)?$|--llm\b|models install")


def commands(page: Path) -> list[str]:
    """The commands of a page, without comments; continued lines are joined."""
    found = []
    for language, block in BLOCK.findall(page.read_text("utf-8")):
        if language not in ("", "sh", "bash", "console"):
            continue
        for line in block.replace("\\\n", " ").splitlines():
            start = PROGRAM.match(line)
            if start:
                found.append(re.split(r"\s+#\s", line[start.end() :])[0].strip())
    return found


@pytest.mark.parametrize(
    ("page", "command"),
    [(page, command) for page in PAGES for command in commands(page)],
    ids=lambda value: value.name if isinstance(value, Path) else value,
)
def test_a_command_is_valid(page: Path, command: str) -> None:
    app.parse_args(with_values_joined(shlex.split(command)), exit_on_error=False, print_error=False)


@pytest.fixture
def clone(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """What README's commands need of a clone, in a folder of its own."""
    for name in ("examples", "studies"):
        shutil.copytree(ROOT / name, tmp_path / name)
    monkeypatch.setenv("HOME", str(tmp_path / "home"))
    monkeypatch.setenv("SHELL", "/bin/bash")
    monkeypatch.chdir(tmp_path)
    return tmp_path


def shorten(words: list[str]) -> list[str]:
    """The same command as a short mission or a small study."""
    if words[0] == "explore" and "--help" not in words and "--steps" not in words:
        return [*words, "--steps", "60"]
    if words[0] == "study":
        return [*words, "--trials", "2", "--jobs", "1"]
    if words[0] == "reproduce":
        return [*words, "--caves", "1", "--jobs", "1"]
    return words


def run_all(page: Path) -> None:
    for command in commands(page):
        if WAITS.search(command):
            continue
        words: list[str] = []
        for word in shlex.split(command):
            words += sorted(map(str, Path().glob(word))) if "*" in word else [word]
        assert main(shorten(words)) == 0, command


@pytest.mark.slow
def test_the_commands_of_the_readme_work_in_order(clone: Path) -> None:
    blocks = BLOCK.findall((ROOT / "README.md").read_text("utf-8"))
    (clone / "my.py").write_text(next(b for _, b in blocks if "def choose" in b), "utf-8")
    # The page starts with the run of `make demo`.
    assert main(["explore", "--steps", "60", "--quiet"]) == 0

    run_all(ROOT / "README.md")
    for file in ("runs/mine.html", "runs/mine.gif", "worlds/cave/world.png", "runs/again/map.png"):
        assert (clone / file).is_file(), file


# Pages whose commands ask a language model, of a server or of one that must be installed first.
MODELS = ("llm.md",)
OWN_FILE = re.compile(r"\b(\w+\.py):(\w+)")


def write_plug_ins(page: Path, folder: Path) -> None:
    """The files that a page's commands name, from its own blocks; one of README's for all."""
    blocks = [b for p in (ROOT / "README.md", page) for _, b in BLOCK.findall(p.read_text("utf-8"))]
    files: dict[str, set[str]] = {}
    for name, made in OWN_FILE.findall("\n".join(commands(page))):
        files.setdefault(name, set()).update(
            b for b in blocks if re.search(rf"^class {made}\b", b, flags=re.MULTILINE)
        )
    for name, found in files.items():
        assert found, f"{page.name} does not define what is in {name}"
        (folder / name).write_text("\n".join(found), "utf-8")


@pytest.mark.slow
@pytest.mark.parametrize(
    "page",
    [p for p in PAGES[1:] if commands(p) and p.name not in MODELS],
    ids=lambda page: page.name,
)
def test_the_commands_of_a_page_work_in_order(page: Path, clone: Path) -> None:
    write_plug_ins(page, clone)
    shutil.copy("examples/maps/rooms.yaml", "warehouse.yaml")
    shutil.copy("examples/maps/rooms.png", "rooms.png")
    walls = np.ones((40, 40), dtype=int)
    walls[2:-2, 2:-2] = 0
    np.savetxt("plan.csv", walls, fmt="%d", delimiter=",")
    cave = ["worlds", "generate", "tube", "--length", "40", "--mesh"]
    for file in ("cave.ply", "darpa_cave_01.ply"):
        assert main([*cave, file, "--out", f"worlds/{file}"]) == 0
    for run in ("mine", "lava-tube-quantile-n15-s0", "lava-tube-nearest-n15-s0"):
        assert main(["explore", "--steps", "60", "--quiet", "--out", f"runs/{run}"]) == 0
    toml = [b for n, b in BLOCK.findall(page.read_text("utf-8")) if n == "toml"]
    if page.name == "studies.md":
        (clone / "my-study.toml").write_text(toml[0], "utf-8")
    run_all(page)
