"""The paper's figures with a language model: it is asked, and titles name it."""

from __future__ import annotations

from pathlib import Path

import polars as pl
import pytest
from provider import serving

from swarmscout import Run
from swarmscout.cli.app import main


def reproduce(out: Path, figure: str, rule: str, url: str) -> str:
    words = ("--quick", "--jobs", "1", "--out", str(out), "--destinations", rule)
    code = main(["reproduce", figure, *words, "--llm", url, "--llm-model", "test-model"])
    assert code == 0
    return (out / figure / "page.md").read_text(encoding="utf-8")


def test_the_decision_shown_is_the_models(tmp_path: Path) -> None:
    with serving("good") as server:
        twin = reproduce(tmp_path, "reasoning", "llm", server.url)
    assert server.seen
    assert "by llm, asking test-model" in twin
    assert "The reason that the selector gave:" in twin
    assert "open" in twin
    assert f"--destinations llm --llm {server.url} --llm-model test-model" in twin


@pytest.mark.slow
def test_a_shortlist_stands_beside_a_random_pick(tmp_path: Path) -> None:
    with serving("good") as server:
        twin = reproduce(tmp_path, "target-stats", "llm-shortlist", server.url)
    assert "by llm-shortlist, asking test-model" in twin
    assert "shortlist-random" in twin
    runs = [Run.open(path) for path in sorted((tmp_path / "target-stats/study/missions").iterdir())]
    asked = [run for run in runs if run.scenario.destinations == "llm-shortlist"]
    assert len(runs) == 3 * len(asked) > 0
    for run in asked:
        assert run.attempts.height > 0
        assert (run.attempts["model"] == "test-model").all()
        assert run.decisions.filter(pl.col("step") > 20)["cause"].len() > 0
