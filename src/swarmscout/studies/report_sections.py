"""The sections of a report."""

from __future__ import annotations

import platform
from collections.abc import Iterator, Sequence
from importlib.metadata import version
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from swarmscout.studies.comparison import Arm, Pairs, arms_of, compare_arms
from swarmscout.studies.design import design_of
from swarmscout.studies.formatting import code, number, with_interval, world_text
from swarmscout.studies.intervals import FEW_UNITS, MANY_UNITS
from swarmscout.studies.metrics import METRICS
from swarmscout.studies.ranking import Ranking
from swarmscout.studies.report_answer import answer_blocks
from swarmscout.studies.report_elements import Block, Code, Heading, Picture, Table, Text, Warn
from swarmscout.studies.report_figures import (
    MOST_PANELS,
    curves_figure,
    differences_figure,
    profiles_figure,
)
from swarmscout.studies.report_tables import (
    arms_table,
    language_model_table,
    measures_table,
    times_table,
)
from swarmscout.studies.scaling import scaling_pictures
from swarmscout.studies.study_file import dotted

if TYPE_CHECKING:
    import polars as pl

    from swarmscout.studies.study import Study

__all__ = ["report_blocks"]


def report_blocks(
    study: Study,
    frame: pl.DataFrame,
    areas: NDArray[np.float32],
    pairs: Sequence[Pairs],
    ranking: Ranking | None,
) -> list[Block]:
    """All elements of a study's report.

    Args:
        study: the study.
        frame: its table.
        areas: [missions, steps + 1], the explored-area curves.
        pairs: its comparisons with the baseline.
        ranking: its combinations in order; None without an order.
    """
    declared = study.declared
    arms = arms_of(study, frame, declared.metric)
    return [
        Heading(declared.title or declared.name, 1),
        Text(f"**Question:** {declared.question}"),
        *answer_blocks(study, frame, pairs, ranking),
        *_warnings(frame, pairs),
        *_pictures(study, arms, areas, pairs),
        *scaling_pictures(study, frame),
        *_tables(study, frame, arms, pairs),
        *_what_was_run(study, frame),
        *_failures(study, frame),
        *_how(study),
    ]


def _warnings(frame: pl.DataFrame, pairs: Sequence[Pairs]) -> Iterator[Block]:
    few = [p for p in pairs if p.too_few]
    if few:
        least = min(p.difference.units for p in few)
        unit = few[0].unit
        yield Warn(
            f"Intervals rest on as few as {least} {unit}: below {FEW_UNITS} they are wide and "
            f"assume a normal distribution. Run more {unit} before drawing conclusions."
            + (" With fewer than 6, no paired test can come below 0.05." if least < 6 else "")
        )
    lacking = sum(p.lacking for p in pairs)
    if lacking:
        yield Warn(f"{lacking} pairs are left out because one of their missions has no result.")
    not_run = int((frame["status"] == "not run").sum())
    if not_run:
        yield Warn(f"{not_run} of {frame.height} missions have not been run yet.")


def _what_was_run(study: Study, frame: pl.DataFrame) -> Iterator[Block]:
    declared = study.declared
    yield Heading("What was run")
    counts = {
        status: int((frame["status"] == status).sum())
        for status in ("finished", "failed", "not run")
    }
    missions = ", ".join(f"{n:,} {status}" for status, n in counts.items() if n)
    last = declared.first_seed + declared.trials - 1
    worlds = list(dict.fromkeys(frame.select("world", "world_seed").iter_rows()))
    shown = ", ".join(code(world_text(world)) for world in worlds[:20])
    rows = [
        ["missions", missions],
        ["base scenario", code(declared.base)],
        *[[code(key), code(value)] for key, value in sorted(dotted(declared.scenario))],
        *[[f"axis {code(a.name)}", ", ".join(map(code, a.labels))] for a in study.axes],
        ["seeds", f"{declared.first_seed} to {last}" if last > declared.first_seed else str(last)],
        ["worlds", shown + (f" and {len(worlds) - 20} more" if len(worlds) > 20 else "")],
        ["recorded", f"`{declared.record}`"],
    ]
    yield Table(["", ""], rows, numbers=2)


def _pictures(
    study: Study, arms: Sequence[Arm], areas: NDArray[np.float32], pairs: Sequence[Pairs]
) -> Iterator[Block]:
    order = study.compared.labels
    metric = METRICS[study.declared.metric]
    baseline = study.declared.compare.baseline
    names = study.setting_names
    panels = len({arm.setting for arm in arms})
    setting = f" A panel for each {', '.join(map(code, names))}." * (panels > 1)
    setting += f" The first {MOST_PANELS} of {panels} settings." * (panels > MOST_PANELS)
    units = "worlds" if any(len(set(arm.worlds)) > 1 for arm in arms) else "seeds"
    yield Heading("Explored area over time")
    yield Picture(
        "curves",
        curves_figure(arms, areas, order, names),
        "Explored area: mean over missions, with a band of 95 % intervals of the mean at each step "
        f"(Student's t over {units}). Bands may overlap where pairs differ clearly: see the "
        f"differences.{setting}",
    )
    if any(p.n for p in pairs):
        yield Heading("Differences, pair by pair")
        yield Picture(
            "differences",
            differences_figure([p for p in pairs if p.n], metric, baseline, order, names),
            f"Every point is a pair: {metric.label} less that of {code(baseline)} in the same "
            f"world with the same seed. Diamond and bar: the mean and its 95 % interval.{setting}",
        )
    yield Heading("Distribution of scores")
    yield Picture(
        "profiles",
        profiles_figure(arms, metric, order, names),
        f"Performance profiles: the share of missions whose {metric.label} is at least the value "
        f"on the axis. A line above another everywhere is better at every value.{setting}",
    )


def _tables(
    study: Study, frame: pl.DataFrame, arms: Sequence[Arm], pairs: Sequence[Pairs]
) -> Iterator[Block]:
    metric = METRICS[study.declared.metric]
    yield Heading("Tables")
    yield Heading(f"By {study.compared.name}: {metric.axis_label}", 3)
    yield arms_table(
        study,
        ["missions", "mean", "interquartile mean", "deviation"],
        [
            (
                arm,
                [
                    str(len(arm.values)), with_interval(arm.mean), with_interval(arm.middle),
                    number(arm.deviation),
                ],
            )
            for arm in arms
        ],
    )  # fmt: skip
    if any(p.unit == "worlds" for p in pairs):
        by_world = [alone for _, alone in compare_arms(study, frame) if alone]
        yield Heading("By world", 3)
        yield Text(
            "An interval here rests on seeds and holds for that world. Those at the top rest on "
            "worlds and hold for further worlds of these kinds."
        )
        yield _world_table(study, by_world)
    yield from times_table(study, frame)
    yield from measures_table(study, frame)
    yield from language_model_table(study, frame)


def _world_table(study: Study, by_world: Sequence[Sequence[Pairs]]) -> Table:
    worlds = list(dict.fromkeys(p.world for alone in by_world for p in alone))
    rows = []
    for world in worlds:
        cells = {(p.setting, p.label): p for alone in by_world for p in alone if p.world == world}
        for p in cells.values():
            rows.append(
                [
                    code(world_text(world)), *map(code, p.setting), code(p.label), str(p.n),
                    with_interval(p.difference, sign=True), with_interval(p.ratio),
                ]
            )  # fmt: skip
    names = study.setting_names
    baseline = study.declared.compare.baseline
    return Table(
        ["world", *names, study.compared.name, "pairs", "difference", f"times {code(baseline)}"],
        rows,
        numbers=len(names) + 2,
    )


def _failures(study: Study, frame: pl.DataFrame) -> Iterator[Block]:
    yield Heading("Failures")
    failures = study.failures()
    if not failures:
        yield Text("No mission failed.")
        return
    yield Text(f"{len(failures)} of {frame.height} missions failed.")
    rows = [[code(failure.mission), code(failure.error)] for failure in failures[:50]]
    if len(failures) > 50:
        rows.append([f"{len(failures) - 50} more", f"see `{study.folder.failures.name}/`"])
    yield Table(["mission", "error"], rows, numbers=2)


def _how(study: Study) -> Iterator[Block]:
    yield Heading("How it was made")
    versions = study.versions
    packages = ", ".join(f"{name} {version(name)}" for name in ("numpy", "scipy", "numba"))
    yield Text(
        f"swarmscout {versions['version']}, rules version {versions['rules_version']}; Python "
        f"{platform.python_version()}, {packages}; {platform.machine()}. The same command "
        "makes the same missions, bit for bit."
    )
    yield Code(f"swarmscout study {study.folder.file.name} --out NEW_FOLDER")
    yield Text(f"The design: {design_of(study).describe()}")
    yield Text(
        "Intervals are at 95 %: BCa bootstrap (9,999 resamples) from "
        f"{MANY_UNITS} units on, Student's t below. Units are worlds when there is more than one "
        "(each world counts as the mean over its pairs), and seeds otherwise. p: two-sided "
        "sign-flip test of the units' differences, adjusted by Holm. Ranking: one-sided paired t "
        "tests against the best, with Bonferroni's correction, which also covers that the best "
        "was picked from the same data. Interquartile mean: the mean of the middle half. "
        "**Better in**: share of pairs, ties count half. The study's file:"
    )
    yield Code(study.text)
    yield Text(
        "Data: `data/missions`, `data/curves` (with the row in missions), `data/comparisons` and "
        "`data/ranking`, each as Parquet and CSV."
    )
