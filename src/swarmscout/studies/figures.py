"""A study's figures, for the report and for papers."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray
from scipy import stats

from swarmscout.studies.comparison import Arm, Label, Pairs
from swarmscout.studies.intervals import LEVEL, Estimate
from swarmscout.studies.metrics import Metric

if TYPE_CHECKING:
    from matplotlib.axes import Axes

__all__ = [
    "arms_in",
    "curve_with_band",
    "curves_figure",
    "differences_figure",
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
    arms: Sequence[Arm], curves: NDArray[np.float32], order: Sequence[Label]
) -> Figure:
    """Explored area over steps, a panel per setting, with bands."""
    settings = _settings(arms)
    figure, panels = _panels(settings, (4.6, 3.3))
    for setting, axes in zip(settings, panels, strict=True):
        for arm in arms_in(arms, setting):
            its = curves[arm.rows]
            if not len(its):
                continue
            its = its[:, np.isfinite(its).all(axis=0)]
            mean, half = curve_with_band(its, arm.worlds)
            style = style_of(order.index(arm.label))
            steps = np.arange(len(mean))
            axes.plot(steps, mean, label=str(arm.label), linewidth=1.6, **style)
            if np.isfinite(half).all():
                axes.fill_between(
                    steps, mean - half, mean + half, color=style["color"], alpha=0.15, linewidth=0
                )
        axes.set(xlabel="step", ylabel="explored area (m²)", xlim=(0, None), ylim=(0, None))
        axes.set_title(_told(setting), fontsize="small")
    _legend(figure, panels)
    return figure


def differences_figure(
    pairs: Sequence[Pairs], metric: Metric, baseline: Label, order: Sequence[Label]
) -> Figure:
    """Every pair's difference as a point, with the mean and its interval, a panel per setting."""
    settings = list(dict.fromkeys(p.setting for p in pairs))[:MOST_PANELS]
    rows = max(sum(p.setting == setting for p in pairs) for setting in settings)
    figure, panels = _panels(settings, (4.6, 0.8 + 0.5 * rows))
    rng = np.random.default_rng(0)  # Scatter across the line, so that points do not hide others.
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
        axes.set_yticks(range(len(here)), [str(p.label) for p in here], fontsize="small")
        axes.set_ylim(len(here) - 0.5, -0.5)
        unit = f" ({metric.unit})" if metric.unit else ""
        axes.set_xlabel(f"{metric.label}, less that of {baseline}{unit}", fontsize="small")
        axes.set_title(_told(setting), fontsize="small")
    return figure


def profiles_figure(arms: Sequence[Arm], metric: Metric, order: Sequence[Label]) -> Figure:
    """Share of missions that reach a score at least: a line above another is better throughout."""
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
                label=str(arm.label), linewidth=1.4, **style_of(order.index(arm.label)),
            )  # fmt: skip
        axes.set(xlabel=metric.axis_label, ylabel="share of missions", ylim=(0, 1.02))
        axes.set_title(_told(setting), fontsize="small")
    _legend(figure, panels)
    return figure


def scaling_figure(
    columns: Sequence[tuple[Metric, Sequence[tuple[str, Sequence[float], Sequence[Estimate]]]]],
    axis_name: str,
    styles: Sequence[int],
) -> Figure:
    """Metrics over an axis of numbers: a panel per metric, a line with intervals per series.

    Args:
        columns: a metric, and its series: label, places on the axis, estimates there.
        axis_name: of the axis.
        styles: a style's index for each series.
    """
    across = 2 if len(columns) == 4 else min(3, len(columns))
    down = -(-len(columns) // across)
    figure = Figure(figsize=(3.9 * across, 3.1 * down), layout="constrained")
    for at, (metric, series) in enumerate(columns):
        axes = figure.add_subplot(down, across, at + 1)
        for (label, places, estimates), style in zip(series, styles, strict=True):
            mean = np.array([e.value for e in estimates])
            low = mean - np.array([e.low for e in estimates])
            high = np.array([e.high for e in estimates]) - mean
            drawn = style_of(style)
            axes.errorbar(
                places, mean, yerr=np.nan_to_num(np.clip([low, high], 0.0, None)), label=label,
                marker="o", markersize=4, linewidth=1.4, capsize=3, **drawn,
            )  # fmt: skip
        ticks = sorted({place for _, places, _ in series for place in places})
        if min(ticks) > 0 and max(ticks) / min(ticks) > 12:
            axes.set_xscale("log")
        axes.set_xticks(ticks, [f"{tick:g}" for tick in ticks])
        axes.minorticks_off()
        axes.set(xlabel=axis_name, ylabel=metric.axis_label, ylim=(0, None))
    _legend(figure, figure.axes)
    return figure


def arms_in(arms: Sequence[Arm], setting: tuple[Label, ...]) -> list[Arm]:
    """The arms of one setting."""
    return [arm for arm in arms if arm.setting == setting]


def _settings(arms: Sequence[Arm]) -> list[tuple[Label, ...]]:
    return list(dict.fromkeys(arm.setting for arm in arms))[:MOST_PANELS]


def _told(setting: tuple[Label, ...]) -> str:
    return " · ".join(str(label) for label in setting)


def _panels(settings: Sequence[Any], size: tuple[float, float]) -> tuple[Figure, list[Axes]]:
    across = min(2, len(settings))
    down = -(-len(settings) // across)
    wide = size[0] if across > 1 else 1.5 * size[0]
    height = size[1] * (1.0 if across > 1 else 1.2)
    figure = Figure(figsize=(wide * across, height * down), layout="constrained")
    return figure, [figure.add_subplot(down, across, at + 1) for at in range(len(settings))]


def _legend(figure: Figure, panels: Sequence[Axes]) -> None:
    handles, labels = panels[0].get_legend_handles_labels()
    for axes in panels[1:]:
        for handle, label in zip(*axes.get_legend_handles_labels(), strict=True):
            if label not in labels:
                handles.append(handle)
                labels.append(label)
    if len(labels) > 1:
        columns = min(len(labels), 4)
        figure.legend(
            handles, labels, loc="outside lower center", ncols=columns, frameon=False,
            fontsize="small",
        )  # fmt: skip


def _whisker(axes: Axes, estimate: Estimate, at: float, colour: str) -> None:
    if math.isfinite(estimate.low):
        axes.plot([estimate.low, estimate.high], [at, at], color=colour, linewidth=2.2)
    axes.plot(
        [estimate.value], [at], marker="D", markersize=6, color=colour, markeredgecolor="white"
    )
