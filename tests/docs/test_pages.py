"""What README and docs show runs, and what they say of the code is so."""

import re
from pathlib import Path

import pytest

import swarmscout as ss
from swarmscout.mission.scenario_keys import scenario_page
from swarmscout.studies.engines import LocalEngine
from swarmscout.studies.scheduler import run_study
from swarmscout.testing import check_policy, check_selector, check_sensor

ROOT = Path(__file__).parents[2]
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md"))]


def python_blocks(page):
    return re.findall(r"```python\n(.*?)```", page.read_text(encoding="utf-8"), flags=re.DOTALL)


def run_the_study_of(page, folder):
    """Run the page's first study, in one world, into the folder that its example opens."""
    text = re.findall(r"```toml\n(.*?)```", page.read_text(encoding="utf-8"), flags=re.DOTALL)[0]
    file = folder / "my-study.toml"
    file.write_text(re.sub(r"world_seed = .*", "world_seed = [0]", text), encoding="utf-8")
    study = ss.Study.load(file)
    assert study.folder.path.as_posix() in page.read_text(encoding="utf-8")
    run_study(study, LocalEngine(1))


@pytest.mark.parametrize("page", [p for p in PAGES if python_blocks(p)], ids=lambda p: p.name)
def test_examples_run(page, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    run = "runs/lava-tube-quantile-n15-s0"  # The page on recordings reads one.
    ss.explore(steps=150, destinations="quantile", out=run)
    if page.name == "studies.md":
        run_the_study_of(page, tmp_path)
    names = {"__name__": "example"}
    for block in python_blocks(page):
        exec(compile(block, page.name, "exec"), names)


def test_the_selector_in_the_readme_passes_the_check(tmp_path):
    block = next(b for b in python_blocks(ROOT / "README.md") if "def choose" in b)
    assert len(block.splitlines()) < 30
    (tmp_path / "my.py").write_text(block, encoding="utf-8")
    check_selector(f"{tmp_path}/my.py:Apart")
    ss.explore(robots=5, steps=40, destinations=f"{tmp_path}/my.py:Apart")


def test_the_policy_on_its_page_passes_the_check(tmp_path):
    block = next(b for b in python_blocks(ROOT / "docs" / "policies.md") if "def desired" in b)
    assert len(block.splitlines()) < 30
    (tmp_path / "my.py").write_text(block, encoding="utf-8")
    check_policy(f"{tmp_path}/my.py:OpenGround")
    teams = {"policy": f"{tmp_path}/my.py:OpenGround", "leave_rule": "general"}
    ss.explore(robots=5, steps=40, teams=teams, policy={"open_cells": 12})


def test_the_scenario_page_is_up_to_date():
    page = (ROOT / "docs" / "scenario.md").read_text(encoding="utf-8")
    assert page == scenario_page(), "python -m swarmscout.mission.scenario_keys > docs/scenario.md"


def test_every_deviation_is_on_the_paper_page():
    page = (ROOT / "docs" / "paper.md").read_text(encoding="utf-8")
    sources = ROOT / "src" / "swarmscout"
    deviating = {
        path.relative_to(sources).as_posix()
        for path in sources.rglob("*.py")
        if "Deviation:" in path.read_text(encoding="utf-8")
    }
    where_we_differ = page.split("## Where we differ")[1]
    named = set(re.findall(r"`([\w/]+\.py)`", where_we_differ))
    assert named == deviating


def test_links_lead_somewhere():
    for page in PAGES:
        for target in re.findall(r"\]\(([^)#]+)\)", page.read_text(encoding="utf-8")):
            if "://" not in target:
                assert (page.parent / target).exists(), f"{page.name}: {target}"


@pytest.mark.parametrize("file", sorted((ROOT / "studies").glob("*.toml")), ids=lambda f: f.stem)
def test_committed_studies_can_be_run(file):
    study = ss.Study.load(file)
    assert study.declared.name == file.stem
    assert len(study.missions) == len({mission.name for mission in study.missions})


def test_the_sensor_on_its_page_passes_the_check(tmp_path):
    block = next(b for b in python_blocks(ROOT / "docs" / "sensors.md") if "def scan" in b)
    (tmp_path / "my.py").write_text(block, encoding="utf-8")
    check_sensor(f"{tmp_path}/my.py:FourWays")


NAMED = sorted(
    {
        (page.name, module, name)
        for page in PAGES
        for module, names in re.findall(
            r"`([a-z_]+/[a-z_/]+\.py)`((?:[:,] `\w+`)*)", page.read_text(encoding="utf-8")
        )
        for name in (re.findall(r"\w+", names) or [""])
    }
)


@pytest.mark.parametrize(("page", "module", "name"), NAMED)
def test_the_code_that_a_page_names_exists(page, module, name):
    places = [ROOT / "src" / "swarmscout" / module, ROOT / "src" / module, ROOT / module]
    found = [place for place in places if place.is_file()]
    assert found, f"{page} names {module}"
    defined = rf"^(?:\s*(?:def|class) )?{name}\b"
    assert re.search(defined, found[0].read_text(encoding="utf-8"), re.MULTILINE)
