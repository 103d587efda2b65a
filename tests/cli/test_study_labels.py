"""Names and labels of a study are text in the live table, never markup."""

from __future__ import annotations

import io

from rich.console import Console

from swarmscout.cli.study_progress import StudyProgress
from swarmscout.studies.progress import SoFar
from swarmscout.studies.study import Study

DECLARED = """
name = "labels"
question = "?"
trials = 2
[compare]
axis = "method"
baseline = "[red]base"
[scenario]
world = "lava-tube-small"
robots = 3
steps = 20
[axes]
method = [
  { label = "[red]base", destinations = "quantile" },
  { label = "mine [/shy]", destinations = "nearest" },
]
"""


def test_labels_are_shown_as_they_are_written(tmp_path):
    file = tmp_path / "labels.toml"
    file.write_text(DECLARED, encoding="utf-8")
    study = Study.load(file, tmp_path / "study")
    out = io.StringIO()
    console = Console(file=out, force_terminal=True, width=120)
    console.print(StudyProgress(SoFar(study, 4), "method", "[red]base")._table())
    for words in ("mine [/shy]", "[red]base", "times [red]base, so far"):
        assert words in out.getvalue()
