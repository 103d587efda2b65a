"""Every figure of the paper, in small."""

import re
import xml.etree.ElementTree as ElementTree

import pytest
from in_this_process import InThisProcess

from swarmscout.cli.app import main
from swarmscout.core.errors import StudyError
from swarmscout.reproduction.catalogue import PAPER_FIGURES, figures_named, reproduce
from swarmscout.reproduction.options import Options
from swarmscout.studies.scheduler import run_study


@pytest.fixture(scope="module")
def pages(tmp_path_factory):
    """Every page, by its figure's name."""
    found = {}
    out = tmp_path_factory.mktemp("paper")
    options = Options(
        out=out, run_study=lambda study: run_study(study, InThisProcess()), quick=True,
        selector="llm-like",
    )  # fmt: skip
    reproduce(list(PAPER_FIGURES), options, found.__setitem__)
    return found


@pytest.mark.parametrize("name", PAPER_FIGURES)
def test_every_figure_stands_beside_the_papers_claim(pages, name):
    twin = pages[name].with_suffix(".md").read_text(encoding="utf-8")
    assert "**The paper:**" in twin
    assert "**Here:**" in twin
    assert f"swarmscout reproduce {name} --quick" in twin
    pictures = re.findall(r"\]\((figures/[\w-]+)\.svg\)", twin)
    assert pictures
    for picture in pictures:
        ElementTree.parse(pages[name].parent / f"{picture}.svg")
        assert (pages[name].parent / f"{picture}.pdf").stat().st_size > 1000


@pytest.mark.parametrize("name", ["llm-vs-baseline", "reasoning", "target-stats", "scale-100"])
def test_it_is_said_when_no_language_model_was_asked(pages, name):
    twin = pages[name].with_suffix(".md").read_text(encoding="utf-8")
    assert "no language model was asked" in twin
    assert "quick: small counts, no result" in twin


def test_the_comparison_says_how_little_five_trials_show(pages):
    twin = pages["llm-vs-baseline"].with_suffix(".md").read_text(encoding="utf-8")
    assert "cannot come below 0.05" in twin
    for rule in ("nearest", "utility", "information-gain", "minpos", "hungarian"):
        assert f"`{rule}`" in twin
    assert (pages["llm-vs-baseline"].parent / "study" / "report.html").exists()


def test_the_papers_own_design_is_one_cave(tmp_path):
    options = Options(
        out=tmp_path, run_study=lambda study: run_study(study, InThisProcess()), quick=True,
        caves=1,
    )  # fmt: skip
    reproduce(["llm-vs-baseline"], options, lambda name, page: None)
    twin = (tmp_path / "llm-vs-baseline" / "page.md").read_text(encoding="utf-8")
    assert "one cave, trials 1 to 1" in twin
    assert "pairs of each start" not in twin
    assert "reproduce llm-vs-baseline --quick --caves 1" in twin
    assert main(["reproduce", "llm-vs-baseline", "--caves", "0"]) == 2


def test_another_rule_can_stand_in_the_models_place(tmp_path):
    options = Options(out=tmp_path, run_study=None, quick=True, selector="multi-criteria")
    ((_, blocks),) = reproduce(["reasoning"], options, lambda name, page: None)
    told = " ".join(getattr(block, "text", "") for block in blocks)
    assert "by multi-criteria" in told
    assert "no language model was asked" not in told


def test_unknown_figures_are_one_line(capsys):
    with pytest.raises(StudyError, match="did you mean 'sensor'"):
        figures_named("sensors")
    assert main(["reproduce", "sensors"]) == 2
    assert capsys.readouterr().err.count("\n") == 1
