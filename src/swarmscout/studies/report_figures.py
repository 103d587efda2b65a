"""A study's figures, for the report and for papers."""

from __future__ import annotations

import math
import textwrap
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Rectangle
from numpy.typing import NDArray
from scipy import stats

from swarmscout.studies.comparison import Arm, Label, Pairs
from swarmscout.studies.formatting import number, setting_text
from swarmscout.studies.intervals import LEVEL, Estimate
from swarmscout.studies.metrics import Metric
from swarmscout.studies.ranking import Rank, Ranking

if TYPE_CHECKING:
    from matplotlib.axes import Axes

__all__ = [
    "MOST_PANELS",
    "arms_in",
    "curve_with_band",
    "curves_figure",
    "differences_figure",
    "heat_map_figure",
    "profiles_figure",
    "scaling_figure",
    "style_of",
]

# Okabe and Ito's colours, which people with colour-blindness can tell apart; then dashed once more.
_COLOURS = (
    "#000000", "#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#8c6d1f",
)  # fmt: skip
_STROKES = ("-", "--", ":", "-.")
MOST_PANELS = 12
_MOST_CELLS_WITH_TEXT = 400


def style_of(index: int) -> dict[str, Any]:
    """Colour and stroke of the i-th compared value."""
    stroke = _STROKES[(index // len(_COLOURS)) % len(_STROKES)]
    return {"color": _COLOURS[index % len(_COLOURS)], "linestyle": stroke}


def curve_with_band(
    curves: NDArray[np.float32], worlds: Sequence[Any]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Mean explored area after each step, and half the width of its 95 % interval.

    Args:
        curves: [missions, steps + 1].
        worlds: the world of each mission.

    Returns:
        Two arrays [steps + 1]; Student's t over units at each step, NaN widths for a single unit.
    """
    groups: dict[Any, list[int]] = {}
    for row, world in enumerate(worlds):
        groups.setdefault(world, []).append(row)
    if len(groups) > 1:
        units = np.stack([curves[rows].mean(axis=0, dtype=np.float64) for rows in groups.values()])
    else:
        units = curves.astype(np.float64)
    n = len(units)
    if n < 2:
        return units.mean(axis=0), np.full(units.shape[1], np.nan)
    factor = float(stats.t.ppf(0.5 + LEVEL / 2, n - 1))
    return units.mean(axis=0), factor * units.std(axis=0, ddof=1) / math.sqrt(n)


def curves_figure(
    arms: Sequence[Arm],
    areas: NDArray[np.float32],
    order: Sequence[Label],
    names: Sequence[str],
) -> Figure:
    """Explored area over steps with bands, a panel per setting.

    Args:
        arms: what is drawn.
        areas: [missions, steps + 1], explored m².
        order: the compared labels, for colours.
        names: of the axes that make a setting, for panel titles.
    """
    settings = _settings(arms)
    figure, panels = _panels(settings, (4.6, 3.3))
    for setting, axes in zip(settings, panels, strict=True):
        for arm in arms_in(arms, setting):
            its = areas[arm.rows]
            if not len(its):
                continue
            its = its[:, np.isfinite(its).all(axis=0)]
            mean, half = curve_with_band(its, arm.worlds)
            style = style_of(order.index(arm.label))
            steps = np.arange(len(mean))
            axes.plot(steps, mean, linewidth=1.6, **style)
            if np.isfinite(half).all():
                axes.fill_between(
                    steps, mean - half, mean + half, color=style["color"], alpha=0.15, linewidth=0
                )
        axes.set(xlabel="step", ylabel="explored area (m²)", xlim=(0, None), ylim=(0, None))
        _title(axes, names, setting)
    _legend_of_labels(figure, order)
    return figure


def differences_figure(
    pairs: Sequence[Pairs],
    metric: Metric,
    baseline: Label,
    order: Sequence[Label],
    names: Sequence[str],
) -> Figure:
    """Every pair's difference as a point, with the mean and its interval, a panel per setting."""
    settings = list(dict.fromkeys(p.setting for p in pairs))[:MOST_PANELS]
    rows = max(sum(p.setting == setting for p in pairs) for setting in settings)
    figure, panels = _panels(settings, (4.6, 1.0 + 0.5 * rows))
    rng = np.random.default_rng(0)  # Spreads points across the line, so that all are visible.
    for setting, axes in zip(settings, panels, strict=True):
        here = [p for p in pairs if p.setting == setting]
        for at, p in enumerate(here):
            style = style_of(order.index(p.label))
            across = at + rng.uniform(-0.28, 0.28, p.n)
            axes.plot(
                p.differences, across, linestyle="none", marker="o", markersize=2.6, alpha=0.4,
                color=style["color"], markeredgewidth=0, rasterized=p.n > 2000,
            )  # fmt: skip
            _whisker(axes, p.difference, at, style["color"])
        axes.axvline(0.0, color="#888888", linewidth=0.8, zorder=0)
        axes.set_yticks(range(len(here)), [_wrapped(p.label, 24) for p in here], fontsize="small")
        axes.set_ylim(len(here) - 0.5, -0.5)
        unit = f" ({metric.unit})" if metric.unit else ""
        axes.set_xlabel(
            _wrapped(f"{metric.label}, less that of {baseline}{unit}", 44), fontsize="small"
        )
        _title(axes, names, setting)
    return figure


def profiles_figure(
    arms: Sequence[Arm], metric: Metric, order: Sequence[Label], names: Sequence[str]
) -> Figure:
    """Share of missions that reach at least a score, over the score, a panel per setting."""
    settings = _settings(arms)
    figure, panels = _panels(settings, (4.6, 3.0))
    for setting, axes in zip(settings, panels, strict=True):
        for arm in arms_in(arms, setting):
            if not len(arm.values):
                continue
            values = np.sort(arm.values)
            share = 1.0 - np.arange(len(values)) / len(values)
            axes.step(
                np.concatenate([values, values[-1:]]), np.append(share, 0.0), where="pre",
                linewidth=1.4, **style_of(order.index(arm.label)),
            )  # fmt: skip
        axes.set(xlabel=metric.axis_label, ylabel="share of missions", ylim=(0, 1.02))
        _title(axes, names, setting)
    _legend_of_labels(figure, order)
    return figure


def scaling_figure(
    columns: Sequence[tuple[Metric, Sequence[tuple[str, Sequence[float], Sequence[Estimate]]]]],
    axis_name: str,
    styles: Sequence[int],
) -> Figure:
    """Metrics over an axis of numbers: a panel per metric, a line with intervals per series.

    Args:
        columns: a metric, and its series: label, places on the axis, estimates there.
        axis_name: name of the axis.
        styles: the style's index of each series.
    """
    across = 2 if len(columns) == 4 else min(3, len(columns))
    down = -(-len(columns) // across)
    figure = Figure(figsize=(3.9 * across, 3.1 * down), layout="constrained")
    for at, (metric, series) in enumerate(columns):
        axes = figure.add_subplot(down, across, at + 1)
        for (_, places, estimates), style in zip(series, styles, strict=True):
            mean = np.array([e.value for e in estimates])
            low = mean - np.array([e.low for e in estimates])
            high = np.array([e.high for e in estimates]) - mean
            axes.errorbar(
                places, mean, yerr=np.nan_to_num(np.clip([low, high], 0.0, None)),
                marker="o", markersize=4, linewidth=1.4, capsize=3, **style_of(style),
            )  # fmt: skip
        ticks = sorted({place for _, places, _ in series for place in places})
        if min(ticks) > 0 and max(ticks) / min(ticks) > 12:
            axes.set_xscale("log")
        axes.set_xticks(ticks, [f"{tick:g}" for tick in ticks])
        axes.minorticks_off()
        axes.set(xlabel=_plain(axis_name), ylim=(0, None))
        axes.set_ylabel(_wrapped(metric.axis_label, 28))
    labels = [label for label, _, _ in columns[0][1]]
    _legend(figure, labels, styles)
    return figure


def heat_map_figure(
    ranking: Ranking, metric: Metric, columns: Sequence[Label], rows: Sequence[Label]
) -> Figure:
    """Means of the metric over the first two axes of a ranking, a panel per value of the others.

    The best combination is framed, those that may be the best are framed with dashes.

    Args:
        ranking: of two axes or more.
        metric: the ranked metric.
        columns: labels of the first axis, from left to right.
        rows: labels of the second axis, from top to bottom.
    """
    panels = sorted({rank.labels[2:] for rank in ranking.ranks}, key=str)[:MOST_PANELS]
    across = min(2, len(panels))
    down = -(-len(panels) // across)
    longest = max(len(str(label)) for label in rows)
    wide = 1.8 + min(longest, 24) * 0.07 + 0.75 * len(columns)
    upright = max(len(str(label)) for label in columns) > 6
    high = 1.2 + 0.42 * len(rows) + (1.2 if upright else 0.2)
    figure = Figure(figsize=(max(4.0, wide) * across, high * down), layout="constrained")
    means = [rank.mean.value for rank in ranking.ranks]
    colours = ScalarMappable(
        Normalize(min(means), max(means)), "viridis" if metric.better > 0 else "viridis_r"
    )
    for at, panel in enumerate(panels):
        axes = figure.add_subplot(down, across, at + 1)
        for rank in ranking.ranks:
            if rank.labels[2:] == panel:
                place = columns.index(rank.labels[0]), rows.index(rank.labels[1])
                with_text = len(columns) * len(rows) <= _MOST_CELLS_WITH_TEXT
                _cell(axes, place, rank, colours, with_text)
                if rank.may_be_best:
                    _frame(axes, place, rank is ranking.ranks[0])
        axes.set_xticks(
            range(len(columns)), [_wrapped(label, 24) for label in columns],
            rotation=90 if upright else 0, fontsize="small",
        )  # fmt: skip
        axes.set_yticks(range(len(rows)), [_wrapped(label, 24) for label in rows], fontsize="small")
        axes.set(xlim=(-0.5, len(columns) - 0.5), ylim=(len(rows) - 0.5, -0.5))
        axes.set(xlabel=_plain(ranking.axes[0]), ylabel=_plain(ranking.axes[1]))
        _title(axes, ranking.axes[2:], panel)
    figure.colorbar(colours, ax=figure.axes, label=_wrapped(metric.axis_label, 28))
    return figure


def _cell(
    axes: Axes, place: tuple[int, int], rank: Rank, colours: ScalarMappable, with_text: bool
) -> None:
    """One combination of a heat map, as a coloured square with its mean."""
    x, y = place
    colour = colours.to_rgba(np.array([rank.mean.value]))[0]
    axes.add_patch(Rectangle((x - 0.5, y - 0.5), 1.0, 1.0, facecolor=colour))
    if with_text:
        axes.text(
            x, y, number(rank.mean.value), ha="center", va="center", fontsize="small",
            color="#010101" if colour[1] > 0.55 else "#fefefe",
        )  # fmt: skip


def _frame(axes: Axes, place: tuple[int, int], best: bool) -> None:
    """The frame round a combination that may be the best."""
    x, y = place
    axes.add_patch(
        Rectangle(
            (x - 0.46, y - 0.46), 0.92, 0.92, fill=False, edgecolor="#d55e00", zorder=3,
            linewidth=2.6 if best else 1.4, linestyle="-" if best else "--",
        )
    )  # fmt: skip


def arms_in(arms: Sequence[Arm], setting: tuple[Label, ...]) -> list[Arm]:
    """The arms of one setting."""
    return [arm for arm in arms if arm.setting == setting]


def _settings(arms: Sequence[Arm]) -> list[tuple[Label, ...]]:
    return list(dict.fromkeys(arm.setting for arm in arms))[:MOST_PANELS]


def _plain(text: Any) -> str:
    """A label as Matplotlib draws it literally: no mathematics, no hidden legend entry."""
    text = str(text).replace("$", r"\$")
    return f" {text}" if text.startswith("_") else text


def _wrapped(text: Any, width: int) -> str:
    return textwrap.fill(_plain(text), width, drop_whitespace=False)


def _title(axes: Axes, names: Sequence[str], setting: Sequence[Any]) -> None:
    axes.set_title(_wrapped(setting_text(names, setting), 48), fontsize="small")


def _panels(settings: Sequence[Any], size: tuple[float, float]) -> tuple[Figure, list[Axes]]:
    across = min(2, len(settings))
    down = -(-len(settings) // across)
    wide = size[0] if across > 1 else 1.5 * size[0]
    height = size[1] * (1.0 if across > 1 else 1.2)
    figure = Figure(figsize=(wide * across, height * down), layout="constrained")
    return figure, [figure.add_subplot(down, across, at + 1) for at in range(len(settings))]


def _legend_of_labels(figure: Figure, order: Sequence[Label]) -> None:
    _legend(figure, [str(label) for label in order], range(len(order)))


def _legend(figure: Figure, labels: Sequence[str], styles: Sequence[int]) -> None:
    """One legend below all panels, with as many columns as fit."""
    if len(labels) < 2:
        return
    handles = [Line2D([], [], linewidth=1.6, **style_of(style)) for style in styles]
    shown = [_wrapped(label, 48) for label in labels]
    longest = max(len(line) for label in shown for line in label.splitlines())
    columns = int(figure.get_figwidth() * 13 / (longest + 7))
    figure.legend(
        handles, shown, loc="outside lower center", frameon=False, fontsize="small",
        ncols=max(1, min(4, columns, len(labels))),
    )  # fmt: skip


def _whisker(axes: Axes, estimate: Estimate, at: float, colour: str) -> None:
    if math.isfinite(estimate.low):
        axes.plot([estimate.low, estimate.high], [at, at], color=colour, linewidth=2.2)
    axes.plot(
        [estimate.value], [at], marker="D", markersize=6, color=colour, markeredgecolor="white"
    )
