from __future__ import annotations

import importlib.util
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numba
import pytest

from swarmscout.cli.compiling import (
    counting_compiled,
    say_if_compiling,
    uncompiled_kernels,
)
from swarmscout.core import jit

Command = Callable[..., tuple[int, str, str]]


def test_selectors_are_listed_and_one_is_recommended(command: Command) -> None:
    code, out, err = command("list", "selectors")
    assert (code, err) == (0, "")
    lines = out.splitlines()
    assert {line.split()[0] for line in lines} >= {"quantile", "nearest", "random"}
    assert sum(line.endswith("(recommended)") for line in lines) == 1
    assert all(len(line.split()) > 3 for line in lines)


@pytest.mark.parametrize(("what", "name"), [("policies", "by-mode"), ("worlds", "lava-tube")])
def test_lists_have_one_line_each(what: str, name: str, command: Command) -> None:
    code, out, _ = command("list", what)
    assert code == 0
    line = next(line for line in out.splitlines() if line.startswith(name))
    assert len(line.split()) > 3


def test_the_version(command: Command) -> None:
    from swarmscout import __version__

    assert command("--version")[:2] == (0, f"{__version__}\n")


def test_the_doctor_finds_all_well(command: Command) -> None:
    code, out, err = command("doctor")
    assert (code, err) == (0, "")
    for said in ("swarmscout", "Python 3", "cores", "numba", "polars", "kernels", "cache"):
        assert said in out
    assert "(writable)" in out


def test_the_doctor_sees_what_cannot_be_written(
    command: Command, here: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (here / "runs").write_text("a file where a folder should be")
    code, out, err = command("doctor")
    assert code == 2
    assert "runs (NOT writable)" in " ".join(out.split())
    assert err.startswith("error: folder 'runs' is not writable")
    assert err.count("\n") == 1


def test_warming_leaves_no_kernel_uncompiled(start: Callable[..., Any]) -> None:
    out, err = start("warm").communicate()
    assert err == ""
    assert out.splitlines()[-1].startswith("ready after ")
    assert out.splitlines()[-1].endswith("every kernel is compiled")


def test_a_kernel_is_compiled_when_numba_has_it_as_it_is_now(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path / "cache"))
    monkeypatch.setattr(numba.config, "CACHE_DIR", str(tmp_path / "cache"))
    monkeypatch.setattr(jit, "kernels", {})
    file = tmp_path / "made_up.py"
    program = "from swarmscout.core.jit import kernel\n@kernel\ndef twice(x):\n    return {} * x\n"

    def uncompiled(factor: int) -> tuple[list[str], Any]:
        file.write_text(program.format(factor))
        spec = importlib.util.spec_from_file_location("made_up", file)
        assert spec is not None
        assert spec.loader is not None
        module = importlib.util.module_from_spec(spec)
        spec.loader.exec_module(module)
        return uncompiled_kernels(), module

    missing, module = uncompiled(2)
    assert missing == ["made_up.twice"]
    say_if_compiling()
    assert capsys.readouterr().out.startswith("compiling 1 kernels: this happens once")
    compiled: list[int] = []
    with counting_compiled(compiled.append):
        assert module.twice(3) == 6
    assert compiled[-1] == len(compiled) >= 1
    assert uncompiled(2)[0] == []
    say_if_compiling()
    assert capsys.readouterr().out == ""
    assert uncompiled(30)[0] == ["made_up.twice"]  # The source has changed.
