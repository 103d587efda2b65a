from __future__ import annotations

import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from swarmscout.core import extras

ROOT = Path(__file__).parents[2]


def test_in_a_clone_the_clone_is_installed(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.chdir(ROOT)
    assert extras.install_command("mesh").endswith("pip install -e '.[mesh]'")
    monkeypatch.chdir(tmp_path)
    assert extras.install_command("mesh") == f"pip install -e '{ROOT}[mesh]'"


def test_elsewhere_the_package_is_installed(tmp_path: Path) -> None:
    installed = tmp_path / "lib" / "site-packages" / "swarmscout" / "core"
    installed.mkdir(parents=True)
    file = shutil.copy(str(extras.__file__), installed)
    program = f"import runpy; print(runpy.run_path({file!r})['install_command']('mesh'))"
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True)
    assert done.stdout == "pip install 'swarmscout[mesh]'\n"
