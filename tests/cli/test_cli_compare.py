"""``swarmscout compare``."""

import json
import shutil

import pytest

import swarmscout as ss
from swarmscout.cli.app import main


@pytest.fixture(scope="module")
def runs(tmp_path_factory):
    folder = tmp_path_factory.mktemp("runs")
    found = []
    for rule in ("quantile", "nearest"):
        for seed in (0, 1):
            out = folder / f"{rule}-{seed}"
            ss.explore(robots=4, steps=30, destinations=rule, seed=seed, out=out)
            found.append(str(out))
    return found


def test_runs_beside_each_other(runs, capsys, tmp_path, monkeypatch):
    monkeypatch.setenv("COLUMNS", "200")
    assert main(["compare", *runs, "--picture", str(tmp_path / "curves.svg")]) == 0
    out = capsys.readouterr().out.splitlines()
    assert out[0].split()[:3] == ["run", "seed", "destinations"]
    assert [line.split()[:3] for line in out[1:5]] == [
        [f"{rule}-{seed}", str(seed), rule]
        for rule in ("quantile", "nearest")
        for seed in (0, 1)
    ]  # fmt: skip
    assert out[1].split()[4] == f"{ss.Run.open(runs[0]).summary['explored_m2']:.1f}"
    assert out[5].startswith("destinations nearest over destinations quantile: ")
    assert "(2 pairs)" in out[5]
    assert "too few" in out[6]
    assert (tmp_path / "curves.svg").read_text(encoding="utf-8").startswith("<?xml")


def test_wrong_input_is_one_line(runs, capsys, tmp_path):
    for words, message in (
        ([runs[0]], "two runs or more"),
        ([runs[0], str(tmp_path / "no")], "does not exist"),
        ([*runs, "--picture", "x.doc"], "must end in .svg, .pdf or .png"),
    ):
        assert main(["compare", *words]) == 2
        err = capsys.readouterr().err
        assert message in err
        assert err.count("\n") == 1


def test_the_run_that_cannot_be_read_is_named(runs, capsys, tmp_path):
    broken = tmp_path / "broken"
    shutil.copytree(runs[1], broken)
    (broken / "coverage.parquet").write_bytes(b"PAR1")
    assert main(["compare", runs[0], str(broken)]) == 2
    err = capsys.readouterr().err
    assert str(broken) in err
    assert err.count("\n") == 1


def test_runs_by_different_rules_are_not_paired(runs, capsys, tmp_path):
    other = tmp_path / "other"
    shutil.copytree(runs[2], other)
    for name in ("run.json", "summary.json"):
        facts = json.loads((other / name).read_text(encoding="utf-8"))
        (other / name).write_text(json.dumps(facts | {"rules_version": 99}), encoding="utf-8")
    assert main(["compare", runs[0], str(other)]) == 0
    out = capsys.readouterr().out
    assert "warning: these runs were made by different rules (versions " in out
    assert ", 99)" in out
    assert " over " not in out


def test_a_narrow_terminal_gets_a_block_per_run(runs, capsys, monkeypatch):
    monkeypatch.setenv("COLUMNS", "40")
    assert main(["compare", *runs[:2]]) == 0
    out = capsys.readouterr().out.splitlines()
    assert out[0] == "quantile-0"
    assert "  seed: 0" in out
    assert f"  explored m²: {ss.Run.open(runs[0]).summary['explored_m2']:.1f}" in out
