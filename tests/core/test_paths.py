"""Paths that begin with the home folder or a variable need not exist yet."""

from __future__ import annotations

from pathlib import Path

import pytest

from swarmscout.core.errors import SwarmscoutError
from swarmscout.core.paths import expanded


def test_a_path_is_expanded_where_nothing_exists_yet(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("HOME", str(tmp_path))
    monkeypatch.setenv("RUNS", str(tmp_path / "runs"))
    assert expanded("~/new/run") == tmp_path / "new" / "run"
    assert expanded("$RUNS/new") == tmp_path / "runs" / "new"
    assert expanded("a/~b$") == Path("a/~b$")


def test_what_cannot_be_expanded_is_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.delenv("NO_SUCH", raising=False)
    with pytest.raises(SwarmscoutError, match=r"environment variable .NO_SUCH is not set"):
        expanded("$NO_SUCH/run")
    with pytest.raises(SwarmscoutError, match="'~no-such-user' has no home folder"):
        expanded("~no-such-user/run")
    (tmp_path / "~no-such-user").mkdir()
    assert expanded("~no-such-user") == Path("~no-such-user")
