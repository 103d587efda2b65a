"""The paper's comparisons: explored area, and properties of chosen cells."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import polars as pl
from matplotlib.figure import Figure
from numpy.typing import NDArray

from swarmscout.recording.table_files import read_table
from swarmscout.reproduction.options import Options, said_of, study_named
from swarmscout.studies.comparison import Pairs, arms_of, compare
from swarmscout.studies.formatting import p_text, with_interval
from swarmscout.studies.intervals import Estimate, by_unit, mean_interval
from swarmscout.studies.report import write_report
from swarmscout.studies.report_elements import Block, Heading, Picture, Table, Text
from swarmscout.studies.report_figures import curves_figure, style_of
from swarmscout.studies.study import Study

__all__ = ["llm_vs_baseline", "target_stats"]


def llm_vs_baseline(options: Options) -> list[Block]:
    """Explored area by the baseline, by the language model (or its stand-in), and by controls."""
    study = study_named(options, "llm-vs-baseline")
    options.run_study(study)
    write_report(study)
    frame = study.frame()
    areas = study.curves()
    arms = arms_of(study, frame, "explored_m2")
    figure = curves_figure(arms, areas, study.compared.labels, study.setting_names)
    figure.suptitle(f"“LLM” {said_of(options)}", fontsize="small", parse_math=False)
    rule = options.selector.rpartition(":")[2]
    pairs = compare(study, frame)
    world = study.missions[0].world_seed
    five = frame.filter(pl.col("world_seed") == world)
    few = compare(study, five)
    worlds = frame["world_seed"].n_unique()
    caves = f"{worlds} caves" if worlds > 1 else "one cave"
    ratios = "; ".join(
        f"{p.setting[0]}: {with_interval(p.ratio)} times the baseline"
        for p in pairs
        if str(p.label) == rule
    )
    whole: list[Block] = []
    if worlds > 1:
        whole = [Heading(f"All {pairs[0].n} pairs of each start", 3), _ratios(pairs)]
    return [
        Text(
            "**The paper:** with N = 15 and 300 steps the LLM-based method explores about 20 % "
            "more than the baseline, the mean of five trials in one cave, with 20 steps of warm-up."
            f" **Here:** “LLM” {said_of(options)}. {ratios}."
        ),
        Picture(
            "llm-vs-baseline", figure,
            f"Explored area over time, mean and 95 % band over {caves}, trials 1 to "
            f"{study.declared.trials} in each; “LLM” {said_of(options)}. From one place (left) "
            "and spread over the cave (right) are two different problems.",
        ),
        *whole,
        Heading(f"The paper's design: {study.declared.trials} trials in one cave", 3),
        Text(
            f"The first cave alone (world seed {world}). With five pairs the paired test "
            "cannot come below 0.05: five trials show a tendency and no more."
        ),
        _ratios(few),
        Text("The whole study, with every pair: `study/report.html` in this figure's folder."),
    ]  # fmt: skip


def _ratios(pairs: Sequence[Pairs]) -> Table:
    rows = [
        [
            str(p.setting[0]), f"`{p.label}`", str(p.n), with_interval(p.ratio),
            with_interval(p.difference, sign=True), p_text(p.p_holm),
        ]
        for p in pairs
    ]  # fmt: skip
    return Table(["start", "rule", "pairs", "times baseline", "difference (m²)", "p"], rows, 2)


_CELL_MEASURES = {
    "frontier_neighbours": "frontier cells among 8 neighbours",
    "obstacle_neighbours": "obstacle cells among 8 neighbours",
    "distance_m": "distance from the leader (m)",
}


def target_stats(options: Options) -> list[Block]:
    """Distributions of frontier and obstacle neighbours and of distances of chosen cells."""
    study = study_named(options, "target-stats")
    options.run_study(study)
    chosen = _decisions(study)
    labels = [str(label) for label in study.compared.labels]
    figure = Figure(figsize=(10.0, 3.3), layout="constrained")
    for at, (column, name) in enumerate(_CELL_MEASURES.items()):
        axes = figure.add_subplot(1, 3, at + 1)
        last = 8.0 if at < 2 else float(np.ceil(chosen["distance_m"].quantile(0.99) or 1.0))
        edges = np.arange(-0.5, 9.0) if at < 2 else np.linspace(0.0, last, 25)
        for index, label in enumerate(labels):
            values = chosen.filter(pl.col("rule") == label)[column].to_numpy()
            share, _ = np.histogram(values, edges)
            axes.stairs(
                share / max(1, len(values)), edges, label=label, linewidth=1.6,
                fill=index == 0, alpha=0.35 if index == 0 else 1.0, **style_of(2 * index + 1),
            )  # fmt: skip
        axes.set(xlabel=name, ylabel="share of decisions" if at == 0 else "")
    axes.legend(frameon=False, fontsize="small")
    figure.suptitle(f"Chosen cells; “LLM” {said_of(options)}", fontsize="small", parse_math=False)
    rows = [
        [
            name,
            *[with_interval(_mean(chosen, label, column)) for label in labels],
            with_interval(_difference(chosen, labels, column), sign=True),
        ]
        for column, name in _CELL_MEASURES.items()
    ]
    return [
        Text(
            "**The paper:** the LLM prefers cells with more frontier cells and fewer obstacles "
            f"around, and allows slightly more distant ones. **Here:** {chosen.height:,} decisions "
            f"of {len(study.missions)} missions; “LLM” {said_of(options)}."
        ),
        Picture(
            "target-stats", figure,
            "Properties of chosen cells: (a) frontier cells and (b) obstacle cells among the 8 "
            f"neighbours, (c) straight distance from the leader. “LLM” {said_of(options)}.",
        ),
        Table(["mean over missions", *labels, "difference"], rows),
    ]  # fmt: skip


def _decisions(study: Study) -> pl.DataFrame:
    """Every decision for a cell, with the rule, world and seed of its mission."""
    frame = study.frame().filter(pl.col("status") == "finished")
    found = []
    for name, rule, world, seed in frame.select(
        "mission", study.compared.name, "world_seed", "seed"
    ).iter_rows():
        table = read_table(study.folder.run(name), "decisions").filter(pl.col("cell").is_not_null())
        found.append(
            table.select(*_CELL_MEASURES).with_columns(
                pl.lit(str(rule)).alias("rule"),
                pl.lit(world).alias("world"),
                pl.lit(seed).alias("seed"),
            )
        )
    return pl.concat(found)


def _by_mission(chosen: pl.DataFrame, label: str, column: str) -> pl.DataFrame:
    its = chosen.filter(pl.col("rule") == label)
    return its.group_by("world", "seed", maintain_order=True).agg(pl.col(column).mean())


def _mean(chosen: pl.DataFrame, label: str, column: str) -> Estimate:
    means = _by_mission(chosen, label, column)
    return _over_worlds(means[column].to_numpy(), means["world"].to_list())


def _difference(chosen: pl.DataFrame, labels: Sequence[str], column: str) -> Estimate:
    a, b = (_by_mission(chosen, label, column) for label in (labels[1], labels[0]))
    both = a.join(b, on=["world", "seed"], suffix="_base")
    gaps = (both[column] - both[f"{column}_base"]).to_numpy()
    return _over_worlds(gaps, both["world"].to_list())


def _over_worlds(values: NDArray[np.float64], worlds: list[int]) -> Estimate:
    return mean_interval([float(unit.mean()) for unit in by_unit(values, worlds)])
