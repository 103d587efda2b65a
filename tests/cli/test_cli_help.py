"""Help is fast: it imports nothing that is heavy."""

from __future__ import annotations

import os
import resource
import subprocess
import sys

import pytest

COMMANDS = [
    [], ["explore"], ["view"], ["figures"], ["video"],
    ["worlds"], ["worlds", "list"], ["worlds", "show"],
    ["worlds", "import"], ["worlds", "generate"], ["list"], ["list", "selectors"],
    ["list", "policies"], ["list", "worlds"], ["warm"], ["doctor"], ["study"], ["compare"],
    ["explain"], ["models"], ["models", "install"], ["check"], ["schema"], ["list", "keys"],
]  # fmt: skip
HEAVY = ("numpy", "numba", "openai", "polars", "scipy", "matplotlib", "pydantic", "PIL", "yaml")

PROGRAM = """
import sys
from swarmscout.cli.app import main
code = main([*sys.argv[1:], "--help"])
print("IMPORTED", *sorted(name for name in sys.modules if "." not in name), file=sys.stderr)
sys.exit(code)
"""


@pytest.mark.parametrize("words", COMMANDS, ids=" ".join)
def test_help_imports_nothing_heavy(words: list[str]) -> None:
    done = subprocess.run(
        [sys.executable, "-c", PROGRAM, *words], capture_output=True, text=True, check=True
    )
    assert done.stdout.startswith("Usage: ")
    imported = done.stderr.split()
    assert imported[0] == "IMPORTED"
    assert not set(imported) & set(HEAVY)


def test_every_command_has_its_line() -> None:
    done = subprocess.run(
        [sys.executable, "-m", "swarmscout", "--help"], capture_output=True, text=True, check=True
    )
    for name in (
        "explore",
        "explain",
        "view",
        "figures",
        "video",
        "worlds",
        "list",
        "models",
        "warm",
        "doctor",
        "check",
        "schema",
    ):
        line = next(line for line in done.stdout.splitlines() if f" {name} " in line)
        assert len(line.strip("│ ").split()) > 3


@pytest.mark.parametrize("columns", ["40", "80", "200"])
@pytest.mark.parametrize("words", [[], ["explore"], ["worlds", "import"]], ids=" ".join)
def test_help_fills_its_lines(words: list[str], columns: str) -> None:
    done = subprocess.run(
        [sys.executable, "-m", "swarmscout", *words, "--help"],
        capture_output=True, text=True, check=True, env={**os.environ, "COLUMNS": columns},
    )  # fmt: skip
    lines = done.stdout.splitlines()
    assert all(len(line) <= int(columns) for line in lines if "  --" not in line)
    starts = [len(line) - len(line.lstrip()) for line in lines]
    for here, below, indent, next_indent in zip(lines, lines[1:], starts, starts[1:], strict=False):
        if indent == next_indent > 8 and below.split():  # A paragraph that goes on.
            assert len(f"{here} {below.split()[0]}") > int(columns), here


def test_help_takes_less_than_a_third_of_a_second() -> None:
    taken = []
    settings = {key: v for key, v in os.environ.items() if key != "PYTHONDONTWRITEBYTECODE"}
    for _ in range(6):
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        subprocess.run(
            [sys.executable, "-m", "swarmscout", "--help"],
            capture_output=True, check=True, env=settings,
        )  # fmt: skip
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        taken.append(after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime)
    assert min(taken) < 0.3
