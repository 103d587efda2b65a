"""The report: a page that needs nothing else, opened in a real browser where there is one."""

import json
import re
import shutil
import subprocess
import xml.etree.ElementTree as ElementTree

import polars as pl
import pytest
from in_this_process import InThisProcess
from small_studies import SMALL

from swarmscout.core.errors import StudyError
from swarmscout.studies.report import write_report
from swarmscout.studies.report_elements import Code, Heading, Table, Text, Warn
from swarmscout.studies.report_render import html_page, markdown_page
from swarmscout.studies.scheduler import run_study
from swarmscout.studies.study import Study

FULL = SMALL.replace('"nearest"]', '"nearest", "random"]') + "teams.desired_size = [1, 2, 4]\n"


@pytest.fixture(scope="module")
def report(tmp_path_factory):
    folder = tmp_path_factory.mktemp("report")
    (folder / "study.toml").write_text(FULL.replace("{trials}", "3"), encoding="utf-8")
    study = Study.load(folder / "study.toml", folder / "out")
    run_study(study, InThisProcess())
    return study, write_report(study)


def test_the_page_needs_nothing_from_elsewhere(report):
    _, page = report
    text = page.read_text(encoding="utf-8")
    assert not re.findall(r'(?:src|href)="(?!data:|#)', text)
    assert "<script" not in text
    assert text.count("<img") == 4  # Curves, differences, profiles, scaling.
    for word in ("Asked", "Answer", "Failures", "seeds", "rules version", "0 to 2"):
        assert word in text


def test_the_twin_and_the_figures_are_beside_it(report):
    study, page = report
    twin = page.with_suffix(".md").read_text(encoding="utf-8")
    pictures = re.findall(r"\]\((figures/[\w-]+\.svg)\)", twin)
    assert len(pictures) == 4
    for picture in pictures:
        svg = study.folder.path / picture
        ElementTree.parse(svg)
        assert svg.with_suffix(".pdf").read_bytes().startswith(b"%PDF")
    assert "Intervals rest on as few as 3 seeds" in twin


def test_every_number_can_be_had_as_data(report):
    study, page = report
    data = page.parent / "data"
    missions = pl.read_parquet(data / "missions.parquet")
    assert missions.height == pl.read_csv(data / "missions.csv").height == 27
    assert missions["mission"].to_list() == study.frame()["mission"].to_list()
    curves = pl.read_parquet(data / "curves.parquet")
    last = curves.group_by("row", maintain_order=True).agg(pl.col("explored_m2").last())
    assert last["explored_m2"].to_list() == pytest.approx(missions["explored_m2"].to_list())
    compared = pl.read_csv(data / "comparisons.csv")
    assert compared.height == 6
    assert set(compared["pairs"]) == {3}


def test_the_same_study_gives_the_same_report(report):
    study, page = report
    before = {f.name: f.read_bytes() for f in (study.folder.path / "figures").glob("*.svg")}
    text = page.read_text(encoding="utf-8")
    write_report(study)
    assert page.read_text(encoding="utf-8") == text
    after = {f.name: f.read_bytes() for f in (study.folder.path / "figures").glob("*.svg")}
    assert after == before


def test_nothing_finished_is_said(make_study):
    with pytest.raises(StudyError, match="has no finished mission"):
        write_report(make_study())


def test_an_unfinished_study_has_a_report_that_says_so(make_study):
    study = make_study(trials=2)
    run_study(study, InThisProcess())
    more = make_study(trials=5)
    twin = write_report(more).with_suffix(".md").read_text(encoding="utf-8")
    assert "6 of 10 missions have not been run yet" in twin
    assert "3 pairs are left out" in twin


def test_pages_escape_what_they_are_given():
    blocks = [
        Heading("a < b", 1), Text("`x<y>` & **c**"), Warn("w"), Code("if a < b: pass"),
        Table(["k", "v"], [["a|b", "<1"]]),
    ]  # fmt: skip
    page = html_page("t & t", blocks, {})
    assert "<h1>a &lt; b</h1>" in page
    assert "<code>x&lt;y&gt;</code> &amp; <strong>c</strong>" in page
    assert "<title>t &amp; t</title>" in page
    assert "| a\\|b | <1 |" in markdown_page(blocks)


CHROMIUM = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "chrome"))), None)

LOOK = """<script>
window.addEventListener("load", () => {
  const found = [...document.images].map((i) => ({ wide: i.naturalWidth, shown: i.width }));
  const width = document.documentElement.scrollWidth <= window.innerWidth;
  document.body.dataset.found = JSON.stringify({ found, width });
});
</script>"""


@pytest.mark.skipif(CHROMIUM is None, reason="no Chromium here: apt-get install chromium")
def test_the_page_opens_in_a_browser(report, tmp_path):
    _, page = report
    text = page.read_text(encoding="utf-8")
    watched = tmp_path / "watched.html"
    watched.write_text(text.replace("</body>", LOOK + "</body>"), encoding="utf-8")
    command = [
        CHROMIUM, "--headless", "--no-sandbox", "--disable-gpu", "--enable-logging=stderr",
        f"--user-data-dir={tmp_path / 'profile'}", "--window-size=1000,900", "--dump-dom",
        watched.as_uri(),
    ]  # fmt: skip
    opened = subprocess.run(command, capture_output=True, text=True, timeout=60, check=True)
    assert "CONSOLE" not in opened.stderr
    found = re.search(r'data-found="([^"]*)"', opened.stdout)
    seen = json.loads(found[1].replace("&quot;", '"'))
    assert len(seen["found"]) == 4
    assert all(image["wide"] > 100 and image["shown"] > 100 for image in seen["found"])
    assert seen["width"], "the page is wider than its window"
    pdf = tmp_path / "report.pdf"
    command[-2:] = [f"--print-to-pdf={pdf}", page.as_uri()]
    subprocess.run(command, capture_output=True, timeout=60, check=True)
    assert pdf.read_bytes().startswith(b"%PDF")
    shutil.rmtree(tmp_path / "profile", ignore_errors=True)
