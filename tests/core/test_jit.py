"""Damaged and full kernel caches."""

import ast
import importlib.util
import os
import subprocess
import sys
from pathlib import Path

import pytest

from swarmscout.core import jit

SOURCE = """
from swarmscout.core.jit import kernel

@kernel
def doubled(x):
    return 2 * x
"""


@pytest.fixture
def load(tmp_path, monkeypatch):
    """Import a module with one kernel; its cache lies beside it."""
    monkeypatch.setattr(jit, "kernels", {})
    monkeypatch.setattr("numba.config.CACHE_DIR", str(tmp_path / "cache"))
    file = tmp_path / "doubling.py"
    file.write_text(SOURCE, encoding="utf-8")

    def load():
        spec = importlib.util.spec_from_file_location("doubling", file)
        module = importlib.util.module_from_spec(spec)
        spec.loader.exec_module(module)
        return module.doubled

    return load


@pytest.mark.parametrize("kind", ["*.nbi", "*.nbc"])
@pytest.mark.parametrize("damage", ["empty", "cut off", "overwritten"])
def test_a_damaged_cache_is_rebuilt(load, tmp_path, kind, damage):
    assert load()(2) == 4
    (file,) = (tmp_path / "cache").rglob(kind)
    data = file.read_bytes()
    file.write_bytes({"empty": b"", "cut off": data[:-9], "overwritten": b"\x00" * 80}[damage])
    damaged = load()
    assert damaged._cache.is_filled() == (kind == "*.nbc")
    assert damaged(3) == 6
    again = load()
    assert again(4) == 8
    assert sum(again.stats.cache_hits.values()) == 1


FIRST = """
import numpy
from swarmscout.core.jit import kernel

@kernel
def at(x, i):
    return x[i]

print(at(numpy.arange(3), 2), at.stats.cache_hits.total(), at.stats.cache_misses.total())
try:
    print(at(numpy.arange(3), 3) is None)
except IndexError as error:
    print(error)
"""


def test_kernels_that_check_their_indices_are_cached_apart(tmp_path):
    file = tmp_path / "first.py"
    file.write_text(FIRST, encoding="utf-8")

    def printed(checks):
        environment = {**os.environ, "NUMBA_CACHE_DIR": str(tmp_path / "cache")}
        environment["NUMBA_BOUNDSCHECK"] = checks
        done = subprocess.run(
            [sys.executable, str(file)], env=environment, capture_output=True, text=True, check=True
        )
        return done.stdout.splitlines()

    assert printed("0") == ["2 0 1", "False"]
    assert printed("1") == ["2 0 1", "index is out of bounds"]
    assert printed("1") == ["2 1 0", "index is out of bounds"]
    assert printed("0") == ["2 1 0", "False"]


def test_a_full_disk_is_named_with_the_cure(tmp_path):
    resource = pytest.importorskip("resource")
    file = tmp_path / "doubling.py"
    file.write_text(SOURCE + "\nprint(doubled(2))\n", encoding="utf-8")

    def no_large_files():
        resource.setrlimit(resource.RLIMIT_FSIZE, (100, 100))

    done = subprocess.run(
        [sys.executable, str(file)], capture_output=True, text=True, preexec_fn=no_large_files,
        check=False,
    )  # fmt: skip
    last = done.stderr.strip().splitlines()[-1]
    assert "cannot keep compiled kernels in '" in last
    assert "File too large; free space there, or set NUMBA_CACHE_DIR to another folder" in last


def test_a_change_in_a_shared_file_compiles_anew(load, monkeypatch):
    assert load()(2) == 4
    assert sum(load().stats.cache_misses.values()) == 0
    same = load()
    same(2)
    assert sum(same.stats.cache_hits.values()) == 1
    monkeypatch.setattr(jit, "_shared_stamp", lambda: "changed")
    other = load()
    assert other(2) == 4
    assert sum(other.stats.cache_misses.values()) == 1


def test_kernels_import_constants_and_functions_from_shared_files_alone():
    package = Path(jit.__file__).parents[1]
    for path in package.rglob("*.py"):
        tree = ast.parse(path.read_text(encoding="utf-8"))
        kernels = [
            node
            for node in ast.walk(tree)
            if isinstance(node, ast.FunctionDef)
            and any(
                ast.unparse(d) in ("kernel", "inlined", "allocating") for d in node.decorator_list
            )
        ]
        used = {
            n.id
            for k in kernels
            for part in (*k.body, k.args)
            for n in ast.walk(part)
            if isinstance(n, ast.Name)
        }
        for node in tree.body:
            if isinstance(node, ast.ImportFrom) and str(node.module).startswith("swarmscout."):
                names = {alias.asname or alias.name for alias in node.names} & used
                file = str(node.module).removeprefix("swarmscout.").replace(".", "/") + ".py"
                assert not names or file in jit.SHARED, f"{path.name}: {sorted(names)}"


def test_functions_without_counted_references_make_no_arrays():
    # Numba refuses most, but not what another function has made it compile before.
    makers = {"array", "arange", "argsort", "copy", "empty", "full", "ones", "sort", "zeros"}
    for path in Path(jit.__file__).parents[1].rglob("*.py"):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.FunctionDef) and any(
                ast.unparse(decorator) == "inlined" for decorator in node.decorator_list
            ):
                called = {
                    call.func.attr
                    for call in ast.walk(node)
                    if isinstance(call, ast.Call) and isinstance(call.func, ast.Attribute)
                }
                assert not called & makers, f"{path.name}: {node.name}"
