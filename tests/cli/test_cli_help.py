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
    ["explain"], ["models"], ["models", "install"],
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
    ):
        line = next(line for line in done.stdout.splitlines() if f" {name} " in line)
        assert len(line.strip("│ ").split()) > 3


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
