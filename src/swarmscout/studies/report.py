"""A study's report: one self-contained HTML page, the same as Markdown, figures and data."""

from __future__ import annotations

import io
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from swarmscout.core.errors import RunError, StudyError
from swarmscout.recording.table_files import write_whole
from swarmscout.studies.comparison import Pairs, compare
from swarmscout.studies.intervals import Estimate
from swarmscout.studies.ranking import Ranking, rank_combinations
from swarmscout.studies.report_elements import Block, Picture
from swarmscout.studies.report_render import figure_bytes, html_page, markdown_page

if TYPE_CHECKING:
    import polars as pl

    from swarmscout.studies.study import Study

__all__ = ["Report", "write_pages", "write_report"]


@dataclass(frozen=True)
class Report:
    """A report that was written.

    Attributes:
        page: the HTML page. Beside it are ``report.md``, ``figures/`` (SVG and PDF) and ``data/``.
        summary: the answer in a few lines of plain text.
        silent_models: a sentence when a language model was asked and never chose; else empty.
    """

    page: Path
    summary: list[str]
    silent_models: str


def write_report(study: Study) -> Report:
    """Write the report of a study on the missions that have finished.

    Args:
        study: the study.

    Raises:
        StudyError: nothing has finished, a run is damaged, or the disk is full.
    """
    from swarmscout.studies.report_answer import silent_models, summary_lines
    from swarmscout.studies.report_sections import report_blocks

    frame = study.frame()
    if not (frame["status"] == "finished").any():
        raise StudyError(f"study '{study.declared.name}' has no finished mission to report on")
    areas = study.curves()
    pairs, ranking = compare(study, frame), rank_combinations(study, frame)
    blocks = report_blocks(study, frame, areas, pairs, ranking)
    tables = {
        "missions": frame,
        "curves": _curves_table(areas),
        "comparisons": _comparisons_table(study, pairs),
        "ranking": _ranking_table(ranking),
    }
    try:
        page = write_pages(study.folder.path, study.declared.title or study.declared.name, blocks)
        (study.folder.path / "data").mkdir(exist_ok=True)
        for name, table in tables.items():
            if table.height:
                _write_table(study.folder.path / "data", name, table)
    except (OSError, RunError) as error:
        raise StudyError(f"cannot write the report: {error}") from None
    summary = summary_lines(study, frame, pairs, ranking)
    return Report(page, summary, silent_models(frame))


def write_pages(folder: Path, title: str, blocks: Sequence[Block], name: str = "report") -> Path:
    """Write ``<name>.html`` and ``<name>.md``, with figures as SVG and PDF beside them.

    Args:
        folder: where they go.
        title: the window's title.
        blocks: the page's contents.
        name: stem of the two files.

    Returns:
        The HTML page.

    Raises:
        RunError: the disk is full or the folder cannot be written.
    """
    figures = folder / "figures"
    figures.mkdir(parents=True, exist_ok=True)
    pictures = {}
    for block in blocks:
        if isinstance(block, Picture):
            for kind in ("svg", "pdf"):
                data = figure_bytes(block.figure, kind)
                write_whole(figures / f"{block.name}.{kind}", data)
                if kind == "svg":
                    pictures[block.name] = data
    page = folder / f"{name}.html"
    write_whole(folder / f"{name}.md", markdown_page(blocks).encode())
    write_whole(page, html_page(title, blocks, pictures).encode())
    return page


def _curves_table(areas: NDArray[np.float32]) -> pl.DataFrame:
    import polars as pl

    rows, steps = np.nonzero(np.isfinite(areas))
    return pl.DataFrame(
        {
            "row": rows.astype(np.int32),
            "step": steps.astype(np.int32),
            "explored_m2": areas[rows, steps],
        }
    )


def _comparisons_table(study: Study, pairs: Sequence[Pairs]) -> pl.DataFrame:
    import polars as pl

    names = study.setting_names
    rows = [
        {
            **dict(zip(names, p.setting, strict=True)),
            study.compared.name: p.label,
            "baseline": str(study.declared.compare.baseline),
            "metric": study.declared.metric,
            "pairs": p.n,
            "units": p.difference.units,
            "unit": p.unit,
            "interval": p.difference.method,
            **_columns("difference", p.difference),
            **_columns("ratio", p.ratio),
            **_columns("improvement", p.improvement),
            "p": p.p,
            "p_holm": p.p_holm,
        }
        for p in pairs
    ]
    return pl.DataFrame(rows, infer_schema_length=None)


def _ranking_table(ranking: Ranking | None) -> pl.DataFrame:
    import polars as pl

    ranks = [] if ranking is None else ranking.ranks
    rows = [
        {
            "rank": at + 1,
            **dict(zip(ranking.axes if ranking else (), rank.labels, strict=True)),
            "missions": rank.missions,
            **_columns("mean", rank.mean),
            **_columns("gap", rank.gap),
            "p": rank.p,
            "may_be_best": rank.may_be_best,
        }
        for at, rank in enumerate(ranks)
    ]
    return pl.DataFrame(rows, infer_schema_length=None)


def _columns(name: str, estimate: Estimate) -> dict[str, float]:
    return {name: estimate.value, f"{name}_low": estimate.low, f"{name}_high": estimate.high}


def _write_table(folder: Path, name: str, frame: pl.DataFrame) -> None:
    parquet, csv = io.BytesIO(), io.BytesIO()
    frame.write_parquet(parquet, compression="zstd")
    frame.write_csv(csv, float_precision=None)
    write_whole(folder / f"{name}.parquet", parquet.getvalue())
    write_whole(folder / f"{name}.csv", csv.getvalue())
