"""An exception in a user's code is told in one line, with the place."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from swarmscout.core.tracebacks import describe_error


def _fails(code: str, file: Path) -> str:
    file.write_text(code)
    with pytest.raises(BaseException) as caught:  # noqa: PT011
        exec(compile(code, str(file), "exec"), {"np": np})
    return describe_error(caught.value)


def test_the_deepest_line_of_the_user(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    file = tmp_path / "mine.py"
    # NumPy's own frames are no place where a user could put anything right.
    said = _fails("def f():\n    np.linalg.inv(np.zeros((2, 3)))\nf()\n", file)
    assert said.startswith("LinAlgError: ")
    assert said.endswith(f"({file}, line 2)")
    monkeypatch.chdir(tmp_path)
    assert _fails("x = {}\nx['a\\nb']\n", file) == "KeyError: 'a\\nb' (mine.py, line 2)"
    assert _fails("raise ValueError('a\\nb')\n", file) == "ValueError: a b (mine.py, line 1)"
    assert _fails("def (", file).endswith("(mine.py, line 1)")
    assert _fails("assert False\n", file) == "AssertionError (mine.py, line 1)"
    assert _fails("import sys\nsys.exit()\n", file).startswith("the code called sys.exit() (mine")
