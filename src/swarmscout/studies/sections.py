"""What a report says, section by section, as blocks."""

from __future__ import annotations

import platform
from collections.abc import Iterator, Sequence
from importlib.metadata import version
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from swarmscout.studies.comparison import Arm, Pairs, arms_of, compare, compare_arms
from swarmscout.studies.figures import (
    MOST_PANELS,
    curves_figure,
    differences_figure,
    profiles_figure,
)
from swarmscout.studies.formatting import (
    number,
    p_words,
    share,
    told_setting,
    told_world,
    with_interval,
)
from swarmscout.studies.intervals import FEW_UNITS, MANY_UNITS
from swarmscout.studies.metrics import METRICS
from swarmscout.studies.report_elements import Block, Code, Heading, Picture, Table, Text, Warn
from swarmscout.studies.report_tables import language_model_table, measures_table, times_table
from swarmscout.studies.scaling import scaling_pictures
from swarmscout.studies.study_file import dotted

if TYPE_CHECKING:
    import polars as pl

    from swarmscout.studies.study import Study

__all__ = ["report_blocks"]


def report_blocks(
    study: Study, frame: pl.DataFrame, areas: NDArray[np.float32]
) -> tuple[list[Block], list[Pairs]]:
    """Everything on the page, and the comparisons that it rests on.

    Args:
        study: the study.
        frame: its table.
        areas: [missions, steps + 1], the explored-area curves.
    """
    declared = study.declared
    arms = arms_of(study, frame, declared.metric)
    pairs = compare(study, frame)
    blocks: list[Block] = [
        Heading(declared.title or declared.name, 1),
        Text(f"**Asked:** {declared.question}"),
        *_answer(study, pairs),
        *_warnings(study, frame, pairs),
        *_what_was_run(study, frame),
        *_pictures(study, arms, areas, pairs),
        *scaling_pictures(study, frame),
        *_tables(study, frame, arms, pairs),
        *_failures(study, frame),
        *_how(study),
    ]
    return blocks, pairs


def _answer(study: Study, pairs: Sequence[Pairs]) -> Iterator[Block]:
    metric = METRICS[study.declared.metric]
    baseline = study.declared.compare.baseline
    yield Heading("Answer")
    if not pairs or not any(p.n for p in pairs):
        yield Text("There are no pairs yet.")
        return
    name = metric.label if not metric.unit else f"{metric.label} in {metric.unit}"
    yield Text(
        f"Declared before it ran: {name} (`{study.declared.metric}`), each value of "
        f"`{study.compared.name}` against `{baseline}`, in pairs with the same world and seed. "
        "Differences, ratios and shares have 95 % intervals; p is of the paired test, adjusted "
        f"for {len(pairs)} comparison{'s' if len(pairs) > 1 else ''} (Holm)."
    )
    yield _pairs_table(study, pairs)


def _pairs_table(study: Study, pairs: Sequence[Pairs]) -> Table:
    metric = METRICS[study.declared.metric]
    settings = [axis.name for axis in study.settings]
    unit = f" ({metric.unit})" if metric.unit else ""
    header = [
        *settings, study.compared.name, "pairs", f"difference{unit}",
        f"times {study.declared.compare.baseline}", "better in", "p", "verdict",
    ]  # fmt: skip
    rows = [
        [
            *map(str, p.setting),
            f"`{p.label}`",
            _units(p),
            with_interval(p.difference, sign=True),
            with_interval(p.ratio),
            share(p.improvement),
            p_words(p.p_holm),
            _verdict(p, metric.better),
        ]
        for p in pairs
    ]
    return Table(header, rows, numbers=len(settings) + 1)


def _units(p: Pairs) -> str:
    return f"{p.n} in {p.difference.units} worlds" if p.unit == "worlds" else str(p.n)


def _verdict(p: Pairs, better: int) -> str:
    """What the interval and the adjusted test say together."""
    if not np.isfinite(p.difference.low) or 0.0 in p.difference or not p.p_holm < 0.05:
        return "not shown"
    up = p.difference.value > 0.0
    if better == 0:
        return "more" if up else "less"
    return "better" if up == (better > 0) else "worse"


def _warnings(study: Study, frame: pl.DataFrame, pairs: Sequence[Pairs]) -> Iterator[Block]:
    few = [p for p in pairs if p.too_few]
    if few:
        least = min(p.difference.units for p in few)
        unit = few[0].unit
        yield Warn(
            f"Intervals rest on as few as {least} {unit}: below {FEW_UNITS} they are wide and lean "
            f"on the normal distribution. Take more {unit} before you conclude anything."
            + (" With fewer than 6 no paired test can come below 0.05." if least < 6 else "")
        )
    lacking = sum(p.lacking for p in pairs)
    if lacking:
        yield Warn(f"{lacking} pairs are left out: one of the two missions has no result.")
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
    told = ", ".join(f"{n:,} {status}" for status, n in counts.items() if n)
    last = declared.first_seed + declared.trials - 1
    worlds = list(dict.fromkeys(frame.select("world", "world_seed").iter_rows()))
    shown = ", ".join(f"`{told_world(world)}`" for world in worlds[:20])
    rows = [
        ["missions", told],
        ["base scenario", f"`{declared.base}`"],
        *[[f"`{key}`", f"`{value}`"] for key, value in sorted(dotted(declared.scenario))],
        *[
            [f"axis `{axis.name}`", ", ".join(f"`{label}`" for label in axis.labels)]
            for axis in study.axes
        ],
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
    panels = len({arm.setting for arm in arms})
    told = f" The first {MOST_PANELS} of {panels} settings." if panels > MOST_PANELS else ""
    setting = f" A panel for each `{'`, `'.join(a.name for a in study.settings)}`." * (panels > 1)
    yield Heading("Explored area over time")
    yield Picture(
        "curves",
        curves_figure(arms, areas, order),
        "Explored area: mean over missions, and a band that holds the mean with 95 % at each step "
        "(Student's t over "
        f"{'worlds' if any(len(set(arm.worlds)) > 1 for arm in arms) else 'seeds'}). Bands of two "
        "lines may overlap where their pairs differ clearly: see the differences." + setting + told,
    )
    if any(p.n for p in pairs):
        yield Heading("Differences, pair by pair")
        yield Picture(
            "differences",
            differences_figure(
                [p for p in pairs if p.n], metric, study.declared.compare.baseline, order
            ),
            f"Every point is a pair: {metric.label} less that of "
            f"`{study.declared.compare.baseline}` in the same world with the same seed. Diamond "
            "and bar: the mean and its 95 % interval." + setting + told,
        )
    yield Heading("Distribution of scores")
    yield Picture(
        "profiles",
        profiles_figure(arms, metric, order),
        f"Performance profiles: the share of missions whose {metric.label} is at least so much. A "
        "line that lies above another everywhere is better whatever score one asks for."
        + setting
        + told,
    )


def _tables(
    study: Study, frame: pl.DataFrame, arms: Sequence[Arm], pairs: Sequence[Pairs]
) -> Iterator[Block]:
    metric = METRICS[study.declared.metric]
    settings = [axis.name for axis in study.settings]
    yield Heading("Tables")
    yield Heading(f"By {study.compared.name}: {metric.axis_label}", 3)
    yield Table(
        [*settings, study.compared.name, "missions", "mean", "interquartile mean", "deviation"],
        [
            [
                *map(str, arm.setting),
                f"`{arm.label}`",
                str(len(arm.values)),
                with_interval(arm.mean),
                with_interval(arm.middle),
                number(arm.deviation),
            ]
            for arm in arms
        ],
        numbers=len(settings) + 1,
    )
    by_world = [alone for _, alone in compare_arms(study, frame) if alone]
    if by_world:
        yield Heading("In each world alone", 3)
        yield Text(
            "An interval here rests on seeds and holds for that world; the table at the top rests "
            "on worlds and holds for more worlds of these kinds."
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
                    f"`{told_world(world)}`", *map(str, p.setting), f"`{p.label}`", str(p.n),
                    with_interval(p.difference, sign=True), with_interval(p.ratio),
                ]
            )  # fmt: skip
    names = [axis.name for axis in study.settings]
    baseline = study.declared.compare.baseline
    return Table(
        ["world", *names, study.compared.name, "pairs", "difference", f"times {baseline}"],
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
    rows = [[f"`{failure.mission}`", failure.error] for failure in failures[:50]]
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
        "makes the same missions, to the bit."
    )
    yield Code(f"swarmscout study {study.folder.file.name} --out NEW_FOLDER")
    yield Text(
        "Intervals are at 95 %: BCa bootstrap (9,999 resamples) from "
        f"{MANY_UNITS} units on, Student's t below. Units are worlds when there is more than one "
        "(each world counts as the mean over its pairs), else seeds. p: two-sided test that turns "
        "the signs of the units' differences, adjusted by Holm. Interquartile mean: the mean of "
        "the middle half. **Better in**: share of pairs, ties half. The study's file:"
    )
    yield Code(study.text)
    yield Text(
        f"Settings: {told_setting([axis.name for axis in study.settings]) or 'one'}. Data: "
        "`data/missions`, `data/curves` (row: of missions), `data/comparisons`, each as Parquet "
        "and CSV."
    )
