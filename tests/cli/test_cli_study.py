"""``swarmscout study`` as it is typed."""

import io

import pytest
from rich.console import Console

from swarmscout.cli.app import main
from swarmscout.cli.study_progress import StudyProgress
from swarmscout.studies.progress import RunningTotals
from swarmscout.studies.study import Study

SMALL = """
name = "small"
question = "Which explores more?"
trials = 1
compare = { axis = "destinations", baseline = "quantile" }

[scenario]
world = "lava-tube-small"
robots = 3
steps = 10

[axes]
destinations = ["quantile", "nearest"]
"""


@pytest.fixture
def study_file(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    file = tmp_path / "study.toml"
    file.write_text(SMALL, encoding="utf-8")
    return file


def test_a_study_is_run_reported_and_gone_on_with(study_file, capsys):
    assert main(["study", "study.toml", "--jobs", "1"]) == 0
    out = capsys.readouterr().out
    assert "small: 2 missions" in out
    assert "Best: destinations = " in out
    assert "nearest against quantile: " in out
    # Before the first mission.
    assert out.startswith("warning: 1 seed and 1 comparison cannot show any difference")
    assert "report: runs/study-small/report.html" in out
    assert main(["study", "runs/study-small", "--jobs", "1"]) == 0
    assert "small: all 2 missions were run before" in capsys.readouterr().out
    assert main(["study", "study.toml", "--jobs", "1", "--trials", "2", "--no-report"]) == 0
    assert "small: 4 missions, 2 of them done before" in capsys.readouterr().out


def test_failed_missions_are_listed_and_the_exit_says_so(study_file, capsys):
    rule = "class Rule:\n    def choose(self, view, memory):\n        raise ValueError('no idea')\n"
    (study_file.parent / "my.py").write_text(rule, encoding="utf-8")
    study_file.write_text(SMALL.replace('"nearest"', '"my.py:Rule"'), encoding="utf-8")
    assert main(["study", "study.toml", "--jobs", "1"]) == 2
    err = capsys.readouterr().err
    assert "failed: lava-tube-small-Rule-n3-s0-" in err
    assert "no idea" in err
    assert "1 mission failed (--retry runs them again" in err


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["no.toml"], "study file 'no.toml' does not exist"),
        (["study.toml", "--engine", "dask"], "--engine dask needs --scheduler ADDRESS"),
        (["study.toml", "--scheduler", "x:1"], "--scheduler is for --engine dask"),
        (["study.toml", "--jobs", "0"], "--jobs 0: at least 1 is needed"),
        (["study.toml", "--trials", "0"], "--trials 0: at least 1 is needed"),
        (["study.toml", "--out", "study.toml"], "is a file: a study needs a folder"),
        (["study.toml", "--trials", "9000000000000000000"], "key 'trials' = 9000000000000000000"),
        (["study.toml", "--trials", "9e18"], "9e18"),
        (["."], "is not a study's folder"),
    ],
)
def test_wrong_input_is_one_line(study_file, capsys, words, message):
    if words == ["."]:
        study_file.unlink()
    assert main(["study", *words]) == 2
    err = capsys.readouterr().err
    assert message in err
    assert err.count("\n") == 1


def test_the_live_table_shows_labels_as_text_in_40_columns(study_file):
    label = "mine [/shy] with a name that is long"
    method = f'method = [{{ label = "base", destinations = "quantile" }}, {{ label = "{label}", '
    text = SMALL.replace('destinations = ["quantile", "nearest"]', method + "robots = 2 }]")
    text = text.replace('"destinations", baseline = "quantile"', '"method", baseline = "base"')
    study_file.write_text(text.replace("robots = 3\n", ""), encoding="utf-8")
    study = Study.load("study.toml")
    progress = StudyProgress(RunningTotals(study, 2), "method", "base")
    console = Console(width=40, record=True, file=io.StringIO())
    console.print(progress.table())
    shown = console.export_text()
    assert "…" not in shown
    assert all(len(line) <= 40 for line in shown.splitlines())
    for word in label.split():
        assert word in shown
