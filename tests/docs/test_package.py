"""What a package index, contributors and continuous integration are given fits together."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path

import yaml

ROOT = Path(__file__).parents[2]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))


def test_every_python_that_is_promised_is_tested() -> None:
    prefix = "Programming Language :: Python :: 3."
    promised = [
        line.removeprefix("Programming Language :: Python :: ")
        for line in PROJECT["project"]["classifiers"]
        if line.startswith(prefix)
    ]
    workflow = yaml.safe_load((ROOT / ".github/workflows/test.yml").read_text("utf-8"))
    assert workflow["jobs"]["test"]["strategy"]["matrix"]["python"] == promised
    assert f"for version in {' '.join(promised)}; do" in (ROOT / "Makefile").read_text("utf-8")
    assert PROJECT["project"]["requires-python"] == f">={promised[0]}"


def test_on_a_package_index_every_link_of_the_readme_is_an_address() -> None:
    text = (ROOT / "README.md").read_text("utf-8")
    hook = PROJECT["tool"]["hatch"]["metadata"]["hooks"]["fancy-pypi-readme"]
    for rule in hook["substitutions"]:
        text = re.sub(rule["pattern"], rule["replacement"], text)
    links = re.findall(r"\]\(([^)]+)\)", text)
    images = re.findall(r"!\[[^\]]*\]\(([^)]+)\)", text)
    assert len(images) >= 2
    assert all(link.startswith(("https://", "#")) for link in links)
    assert all(link.startswith("https://raw.") for link in images)


def test_what_hosts_read_is_well_formed() -> None:
    for name in (".github/ISSUE_TEMPLATE/bug.yml", ".github/ISSUE_TEMPLATE/idea.yml"):
        form = yaml.safe_load((ROOT / name).read_text("utf-8"))
        assert form["name"]
        assert form["body"]
    hooks = yaml.safe_load((ROOT / ".pre-commit-config.yaml").read_text("utf-8"))["repos"]
    assert all(hook["language"] == "system" for repo in hooks for hook in repo["hooks"])


def test_development_tools_are_pinned() -> None:
    pinned = {
        re.sub(r"[-_.]+", "-", line.split("==")[0].lower())
        for line in (ROOT / "constraints.txt").read_text("utf-8").splitlines()
    }
    extras = PROJECT["project"]["optional-dependencies"]
    wanted = [*PROJECT["project"]["dependencies"], *extras["dev"]]
    names = {re.sub(r"[-_.]+", "-", re.split(r"[<>=\[ ]", line)[0].lower()) for line in wanted}
    assert names <= pinned
