"""Scaling curves: metrics over an axis of numbers, with intervals."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

from swarmscout.studies.comparison import arms_of
from swarmscout.studies.formatting import code, setting_text
from swarmscout.studies.metrics import METRICS
from swarmscout.studies.report_elements import Block, Heading, Picture
from swarmscout.studies.report_figures import scaling_figure
from swarmscout.studies.study_file import Axis

if TYPE_CHECKING:
    import polars as pl

    from swarmscout.studies.intervals import Estimate
    from swarmscout.studies.study import Study

__all__ = ["scaling_picture", "scaling_pictures"]

_SHOWN = ("explored_m2", "overlap_ratio", "limit_share", "blocked_share", "step_ms", "charges")


def scaling_pictures(study: Study, frame: pl.DataFrame) -> Iterator[Block]:
    """A figure for each axis of three numbers or more."""
    axes = [axis for axis in study.axes if axis.is_number and len(axis.values) >= 3]
    axes = [axis for axis in axes if not axis.is_place]
    if axes:
        yield Heading("Scaling")
    for axis in axes:
        yield scaling_picture(study, frame, axis)


def scaling_picture(
    study: Study,
    frame: pl.DataFrame,
    axis: Axis,
    metrics: tuple[str, ...] = _SHOWN,
    *,
    only: bool = False,
) -> Picture:
    """Metrics over one axis; a line per combination of the other axes that are not places.

    Args:
        study: the study.
        frame: its table.
        axis: an axis of numbers.
        metrics: the panels besides the declared metric; those that were not recorded are left out.
        only: leave out the declared metric.
    """
    declared = study.declared.metric
    wanted = [declared, *(metric for metric in metrics if metric != declared)]
    wanted = list(metrics) if only else wanted
    wanted = [metric for metric in wanted if frame[metric].is_not_null().any()][:6]
    others = [a for a in (*study.settings, study.compared) if a is not axis]
    names = [a.name for a in others]
    columns = []
    for metric in wanted:
        series: dict[str, tuple[list[float], list[Estimate]]] = {}
        for arm in arms_of(study, frame, metric):
            labels = dict(zip(study.setting_names, arm.setting, strict=True))
            labels[study.compared.name] = arm.label
            if not len(arm.values):
                continue
            its = [labels[name] for name in names]
            label = setting_text(names, its) if len(names) > 1 else str(*its)
            places, estimates = series.setdefault(label, ([], []))
            places.append(float(labels[axis.name]))
            estimates.append(arm.mean)
        lines = [(label, places, estimates) for label, (places, estimates) in series.items()]
        columns.append((METRICS[metric], lines))
    shown = ", ".join(METRICS[metric].label for metric in wanted)
    per_line = f", a line per {', '.join(map(code, names))}" if names else ""
    return Picture(
        f"scaling-{axis.name.replace('.', '-')}",
        scaling_figure(columns, axis.name, list(range(len(columns[0][1])))),
        f"Over {code(axis.name)}: {shown}{per_line}. Means with 95 % intervals.",
    )
