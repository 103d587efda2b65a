"""A study's report: one self-contained HTML page, its Markdown twin, figures and data.

What it says is made by :mod:`swarmscout.studies.sections`; here it becomes files.
"""

from __future__ import annotations

import io
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from swarmscout.core.errors import RunError, StudyError
from swarmscout.recording.table_files import write_whole
from swarmscout.studies.report_elements import Block, Picture
from swarmscout.studies.report_render import figure_bytes, html_page, markdown_page
from swarmscout.studies.table import curves, missions_table

if TYPE_CHECKING:
    import polars as pl

    from swarmscout.studies.comparison import Pairs
    from swarmscout.studies.study import Study

__all__ = ["write_pages", "write_report"]


def write_report(study: Study) -> Path:
    """Write everything that can be said of a study as far as it has been run.

    Args:
        study: the study.

    Returns:
        The HTML page. Beside it are ``report.md``, ``figures/`` (SVG and PDF) and ``data/``.

    Raises:
        StudyError: nothing has finished, a run is damaged, or the disk is full.
    """
    from swarmscout.studies.sections import report_blocks

    frame = missions_table(study)
    if not (frame["status"] == "finished").any():
        raise StudyError(f"study '{study.declared.name}' has no finished mission to report on")
    areas = curves(study, frame)
    blocks, pairs = report_blocks(study, frame, areas)
    try:
        page = write_pages(study.folder.path, study.declared.title or study.declared.name, blocks)
        _write_data(study.folder.path / "data", frame, areas, pairs, study)
    except (OSError, RunError) as error:
        raise StudyError(f"cannot write the report: {error}") from None
    return page


def write_pages(folder: Path, title: str, blocks: Sequence[Block], name: str = "report") -> Path:
    """Blocks as ``<name>.html`` and ``<name>.md``, with figures as SVG and PDF beside them.

    Args:
        folder: where to.
        title: of the page's window.
        blocks: what is on the page.
        name: of the two files.

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


def _write_data(
    folder: Path,
    frame: pl.DataFrame,
    areas: NDArray[np.float32],
    pairs: Sequence[Pairs],
    study: Study,
) -> None:
    import polars as pl

    folder.mkdir(exist_ok=True)
    _write_table(folder, "missions", frame)
    rows, steps = np.nonzero(np.isfinite(areas))
    long = pl.DataFrame(
        {
            "row": rows.astype(np.int32),
            "step": steps.astype(np.int32),
            "explored_m2": areas[rows, steps],
        }
    )
    _write_table(folder, "curves", long)
    names = [axis.name for axis in study.settings]
    compared = [
        {
            **dict(zip(names, p.setting, strict=True)),
            study.compared.name: p.label,
            "baseline": str(study.declared.compare.baseline),
            "metric": study.declared.metric,
            "pairs": p.n,
            "units": p.difference.units,
            "unit": p.unit,
            "interval": p.difference.method,
            "difference": p.difference.value,
            "difference_low": p.difference.low,
            "difference_high": p.difference.high,
            "ratio": p.ratio.value,
            "ratio_low": p.ratio.low,
            "ratio_high": p.ratio.high,
            "improvement": p.improvement.value,
            "improvement_low": p.improvement.low,
            "improvement_high": p.improvement.high,
            "p": p.p,
            "p_holm": p.p_holm,
        }
        for p in pairs
    ]
    if compared:
        _write_table(folder, "comparisons", pl.DataFrame(compared, infer_schema_length=None))


def _write_table(folder: Path, name: str, frame: pl.DataFrame) -> None:
    parquet, csv = io.BytesIO(), io.BytesIO()
    frame.write_parquet(parquet, compression="zstd")
    frame.write_csv(csv, float_precision=None)
    write_whole(folder / f"{name}.parquet", parquet.getvalue())
    write_whole(folder / f"{name}.csv", csv.getvalue())
