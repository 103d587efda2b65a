"""Each example runs, with fewer steps; examples/README.md lists them all."""

from __future__ import annotations

import re
import runpy
from pathlib import Path

import pytest

FOLDER = Path(__file__).parents[2] / "examples"
EXAMPLES = sorted(FOLDER.glob("*.py"))
STEPS = re.compile(r"^STEPS = \d+$", flags=re.MULTILINE)


@pytest.mark.parametrize("example", EXAMPLES, ids=lambda path: path.stem)
def test_an_example_runs(
    example: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("MPLBACKEND", "agg")
    text = STEPS.sub("STEPS = 30", example.read_text("utf-8"))
    script = tmp_path / example.name
    script.write_text(re.sub(r"^SEEDS = \d+$", "SEEDS = 2", text, flags=re.MULTILINE), "utf-8")
    runpy.run_path(str(script), run_name="example" if "spawn" in text else "__main__")
    assert capsys.readouterr().out
    assert [path.name for path in tmp_path.iterdir()] == [example.name], "it leaves files behind"


def test_examples_are_short_and_listed() -> None:
    assert len(EXAMPLES) >= 20
    page = (FOLDER / "README.md").read_text("utf-8")
    for example in EXAMPLES:
        text = example.read_text("utf-8")
        assert len(text.splitlines()) <= 40, example.name
        assert f"({example.name})" in page, f"examples/README.md does not list {example.name}"
    numbers = [example.name[:2] for example in EXAMPLES]
    assert numbers == sorted(set(numbers))
