"""The report: a page that needs nothing else, opened in a real browser where there is one."""

import base64
import json
import re
import shutil
import subprocess
import xml.etree.ElementTree as ElementTree
from dataclasses import replace

import polars as pl
import pytest
from in_this_process import InThisProcess
from matplotlib.backends.backend_agg import FigureCanvasAgg
from small_studies import PATIENCE_S, SMALL

from swarmscout.core.errors import StudyError
from swarmscout.studies.comparison import arms_of
from swarmscout.studies.formatting import code
from swarmscout.studies.metrics import METRICS
from swarmscout.studies.ranking import rank_combinations
from swarmscout.studies.report import write_report
from swarmscout.studies.report_answer import silent_models
from swarmscout.studies.report_elements import Code, Heading, Table, Text, Warn
from swarmscout.studies.report_figures import curves_figure, heat_map_figure
from swarmscout.studies.report_render import html_page, markdown_page
from swarmscout.studies.scheduler import run_study
from swarmscout.studies.study import Study

FULL = SMALL.replace('"nearest"]', '"nearest", "random"]') + "teams.desired_size = [1, 2, 4]\n"

METHOD = """method = [
    { label = "base", destinations = "quantile" }, { label = "LABEL", destinations = "nearest" },
]"""
LONG_COMPARE = 'axis = "method"\nbaseline = "base"'


@pytest.fixture(scope="module")
def report(tmp_path_factory):
    folder = tmp_path_factory.mktemp("report")
    (folder / "study.toml").write_text(FULL.replace("{trials}", "3"), encoding="utf-8")
    study = Study.load(folder / "study.toml", folder / "out")
    run_study(study, InThisProcess())
    return study, write_report(study).page


def test_the_page_needs_nothing_from_elsewhere(report):
    _, page = report
    text = page.read_text(encoding="utf-8")
    assert not re.findall(r'(?:src|href)="(?!data:|#)', text)
    assert "<script" not in text
    assert text.count("<img") == 5  # Heat map, curves, differences, profiles, scaling.
    for word in ("Question", "Answer", "Ranking", "Failures", "seeds", "rules version", "0 to 2"):
        assert word in text


def test_the_twin_and_the_figures_are_beside_it(report):
    study, page = report
    twin = page.with_suffix(".md").read_text(encoding="utf-8")
    pictures = re.findall(r"\]\((figures/[\w-]+\.svg)\)", twin)
    assert len(pictures) == 5
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
    twin = write_report(more).page.with_suffix(".md").read_text(encoding="utf-8")
    assert "6 of 10 missions have not been run yet" in twin
    assert "3 pairs are left out because" in twin


def test_pages_escape_what_they_are_given():
    blocks = [
        Heading("a < b", 1), Text("`x<y>` & **c**"), Warn("w"), Code("if a < b: pass"),
        Table(["k", "v"], [["a|b", "<1"], [code("**c** `d`"), code("`")]]),
    ]  # fmt: skip
    page = html_page("t & t", blocks, {})
    assert "<h1>a &lt; b</h1>" in page
    assert "<code>x&lt;y&gt;</code> &amp; <strong>c</strong>" in page
    assert "<title>t &amp; t</title>" in page
    assert "<td><code>**c** `d`</code></td>" in page
    assert '<td class="number"><code>`</code></td>' in page
    assert "| a\\|b | <1 |" in markdown_page(blocks)


def test_pages_have_contents_and_follow_the_system_to_dark(report):
    _, page = report
    text = page.read_text(encoding="utf-8")
    anchors = re.findall(r'<a href="#([\w-]+)"', text)
    assert anchors[:3] == ["answer", "ranking", "compared-with-the-baseline"]
    assert all(f'id="{anchor}"' in text for anchor in anchors)
    assert "prefers-color-scheme: dark" in text
    for svg in re.findall(r'src="data:image/svg\+xml;base64,([^"]*)"', text):
        assert b"prefers-color-scheme: dark" in base64.b64decode(svg)
    # Figures for papers stay light everywhere.
    for svg in (page.parent / "figures").glob("*.svg"):
        assert "prefers-color-scheme" not in svg.read_text(encoding="utf-8")


def test_panels_name_their_axes_and_labels_are_text(make_study):
    label = "mine [/shy] $x$ **b** `t`"
    text = SMALL.replace('destinations = ["quantile", "nearest"]', METHOD.replace("LABEL", label))
    text = text.replace('axis = "destinations"\nbaseline = "quantile"', LONG_COMPARE)
    study = make_study(text + "robots = [3, 4]\n", trials=1)
    run_study(study, InThisProcess())
    twin = write_report(study).page.with_suffix(".md").read_text(encoding="utf-8")
    assert f"`` {label} ``" in twin
    arms = arms_of(study, study.frame(), "explored_m2")
    figure = curves_figure(arms, study.curves(), study.compared.labels, ["robots"])
    assert [axes.get_title() for axes in figure.axes] == ["robots = 3", "robots = 4"]
    (legend,) = figure.legends
    assert [t.get_text().strip() for t in legend.get_texts()] == ["base", label.replace("$", r"\$")]


def test_no_label_is_cut(report):
    study, _ = report
    frame = study.frame()
    ranking = rank_combinations(study, frame)
    long = tuple(
        replace(rank, labels=(f"a label of some length {rank.labels[0]}", *rank.labels[1:]))
        for rank in ranking.ranks
    )
    columns = list(dict.fromkeys(rank.labels[0] for rank in long))
    figure = heat_map_figure(
        replace(ranking, ranks=long), METRICS["explored_m2"], columns, study.settings[0].labels
    )
    FigureCanvasAgg(figure).draw()
    whole = figure.get_window_extent()
    for axes in figure.axes[:-1]:  # The last is the colour bar.
        for text in (*axes.get_xticklabels(), *axes.get_yticklabels(), axes.xaxis.label):
            box = text.get_window_extent()
            assert whole.x0 <= box.x0 <= box.x1 <= whole.x1, text
            assert whole.y0 <= box.y0 <= box.y1 <= whole.y1, text


def test_a_model_that_never_chose_is_said_under_the_answer(report):
    study, _ = report
    frame = study.frame()
    assert silent_models(frame) == ""
    asked = pl.Series("llm.asked", [5] * frame.height)
    for chosen, said in ((0, "In 27 of 27 missions"), (2, "")):
        by_model = pl.Series("llm.by_model", [chosen] * frame.height)
        with_model = frame.with_columns(asked, by_model)
        assert silent_models(with_model).startswith(said)
        assert bool(silent_models(with_model)) == bool(said)


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
    opened = subprocess.run(command, capture_output=True, text=True, timeout=PATIENCE_S, check=True)
    assert "CONSOLE" not in opened.stderr
    found = re.search(r'data-found="([^"]*)"', opened.stdout)
    seen = json.loads(found[1].replace("&quot;", '"'))
    assert len(seen["found"]) == 5
    assert all(image["wide"] > 100 and image["shown"] > 100 for image in seen["found"])
    assert seen["width"], "the page is wider than its window"
    pdf = tmp_path / "report.pdf"
    command[-2:] = [f"--print-to-pdf={pdf}", page.as_uri()]
    subprocess.run(command, capture_output=True, timeout=PATIENCE_S, check=True)
    assert pdf.read_bytes().startswith(b"%PDF")
    shutil.rmtree(tmp_path / "profile", ignore_errors=True)
