"""Commands run in an empty folder, in this process or in one of their own."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from swarmscout.cli.app import main

Answer = tuple[int, str, str]


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """An empty working directory."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.delenv("SWARMSCOUT_DEBUG", raising=False)
    return tmp_path


@pytest.fixture
def command(here: Path, capfd: pytest.CaptureFixture[str]) -> Callable[..., Answer]:
    """Run a command in this process: exit code, stdout, stderr."""

    def run(*words: str) -> Answer:
        capfd.readouterr()
        code = main(words)
        told = capfd.readouterr()
        return code, told.out, told.err

    return run


class Child(subprocess.Popen[str]):
    """A process that does not outlive a test that fails."""

    def __exit__(self, kind: Any, value: Any, trace: Any) -> None:
        if kind is not None:
            self.kill()
        super().__exit__(kind, value, trace)


@pytest.fixture
def start(here: Path) -> Callable[..., subprocess.Popen[str]]:
    """Start a command in a process of its own, with its output in pipes."""

    def begin(*words: str, **more: Any) -> subprocess.Popen[str]:
        return Child(
            [sys.executable, "-m", "swarmscout", *words],
            text=True,
            **{"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, **more},
        )

    return begin
