"""``swarmscout compare``."""

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


def test_runs_beside_each_other(runs, capsys, tmp_path):
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
