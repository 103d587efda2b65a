"""Paired comparison of every value of the compared axis with the baseline.

A pair is two missions that agree in world, seed and every other axis. Missions without a partner
are left out and counted.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from swarmscout.studies.intervals import (
    FEW_UNITS,
    Estimate,
    by_unit,
    holm,
    interquartile_mean,
    interquartile_value,
    mean_interval,
    mean_over_units,
    ratio_over_units,
    share_interval,
    sign_flip_p,
)
from swarmscout.studies.metrics import METRICS
from swarmscout.studies.study_file import PLACE_KEYS

if TYPE_CHECKING:
    import polars as pl

    from swarmscout.studies.study import Study

__all__ = ["Arm", "Pairs", "arms_of", "compare", "compare_arms", "metric_of", "pair_keys"]

Label = str | int | float | bool


@dataclass(frozen=True)
class Arm:
    """The finished missions of one combination: a setting and a compared value.

    Attributes:
        setting: labels of the axes that are neither compared nor a place.
        label: the compared value.
        rows: int64[n], their rows in the study's table.
        worlds: the world of each.
        values: float64[n], the metric.
    """

    setting: tuple[Label, ...]
    label: Label
    rows: NDArray[np.int64]
    worlds: list[Any]
    values: NDArray[np.float64]

    @cached_property
    def mean(self) -> Estimate:
        """Mean over units."""
        return mean_over_units(self.values, self.worlds)

    @property
    def middle(self) -> Estimate:
        """Interquartile mean of the missions; of several worlds, the mean of theirs."""
        if len(set(self.worlds)) <= 1:
            return interquartile_mean(self.values)
        units = by_unit(self.values, self.worlds)
        return mean_interval([interquartile_value(unit) for unit in units])

    @property
    def deviation(self) -> float:
        """Standard deviation over missions."""
        return float(self.values.std(ddof=1)) if len(self.values) > 1 else float("nan")


@dataclass(frozen=True)
class Pairs:
    """One value of the compared axis beside the baseline, in one setting.

    Attributes:
        setting: labels of the axes that are neither compared nor a place.
        label: the compared value.
        world: the world, or None for all worlds together.
        differences: float64[n], metric less that of the partner.
        base: float64[n], the partner's metric.
        worlds: of each pair.
        lacking: pairs left out because one of the two is not finished or has no such value.
        difference: mean difference.
        ratio: mean of the pairs' ratios; NaN where a partner's metric is not above 0.
        improvement: share of pairs in which it is better; ties count half.
        p: p-value of no difference.
        p_holm: `p` adjusted for all comparisons of the study.
    """

    setting: tuple[Label, ...]
    label: Label
    world: Any
    differences: NDArray[np.float64]
    base: NDArray[np.float64]
    worlds: list[Any]
    lacking: int
    difference: Estimate
    ratio: Estimate
    improvement: Estimate
    p: float
    p_holm: float = float("nan")

    @property
    def n(self) -> int:
        """Number of pairs."""
        return len(self.differences)

    @property
    def unit(self) -> str:
        """The independent units: ``worlds`` or ``seeds``."""
        return "worlds" if len(set(self.worlds)) > 1 else "seeds"

    @property
    def too_few(self) -> bool:
        """Whether the interval rests on fewer units than intervals should."""
        return self.difference.units < FEW_UNITS


def metric_of(study: Study, frame: pl.DataFrame, metric: str) -> NDArray[np.float64]:
    """float64[missions]: a metric, NaN where a mission has none.

    A time that was not reached counts as the mission's length, so its mean is a restricted mean;
    :mod:`swarmscout.studies.survival` treats such times as censored.
    """
    import polars as pl

    column = frame[metric].cast(pl.Float64)
    if metric.startswith("time_to_"):
        finished = frame["status"] == "finished"
        column = pl.select(
            pl.when(finished & column.is_null())
            .then(frame["planned_steps"].cast(pl.Float64))
            .otherwise(column)
        ).to_series()
    return column.fill_null(float("nan")).to_numpy()


def arms_of(study: Study, frame: pl.DataFrame, metric: str) -> list[Arm]:
    """The finished missions of each combination, in the file's order."""
    values = metric_of(study, frame, metric)
    settings = _rows(frame, study.setting_names)
    labels = frame[study.compared.name].to_list()
    worlds = _worlds(study, frame)
    groups: dict[tuple[tuple[Label, ...], Label], list[int]] = {}
    for row, label in enumerate(labels):
        rows = groups.setdefault((settings[row], label), [])
        if np.isfinite(values[row]):
            rows.append(row)
    order = {label: at for at, label in enumerate(study.compared.labels)}
    found = []
    for (setting, label), rows in groups.items():
        chosen = np.array(rows, dtype=np.int64)
        its_worlds = [worlds[row] for row in rows]
        found.append(Arm(setting, label, chosen, its_worlds, values[chosen]))
    places = {setting: at for at, setting in enumerate(dict.fromkeys(arm.setting for arm in found))}
    return sorted(found, key=lambda arm: (places[arm.setting], order[arm.label]))


def compare(study: Study, frame: pl.DataFrame, metric: str | None = None) -> list[Pairs]:
    """Every comparison of a study over all worlds, with p-values adjusted for their number.

    Args:
        study: the study.
        frame: its table.
        metric: the metric to compare; None for the declared one.
    """
    found = [pairs for pairs, _ in compare_arms(study, frame, metric, alone=False)]
    adjusted = holm([pairs.p for pairs in found])
    return [replace(pairs, p_holm=p) for pairs, p in zip(found, adjusted, strict=True)]


def compare_arms(
    study: Study, frame: pl.DataFrame, metric: str | None = None, *, alone: bool = True
) -> list[tuple[Pairs, list[Pairs]]]:
    """Every comparison: over all worlds and, of several worlds, in each one."""
    name = metric or study.declared.metric
    sign = METRICS[name].better or 1
    values = metric_of(study, frame, name)
    keys = pair_keys(study, frame)
    settings = _rows(frame, study.setting_names)
    labels = frame[study.compared.name].to_list()
    worlds = _worlds(study, frame)
    table: dict[tuple[Label, ...], dict[str, dict[Any, int]]] = {}
    for row, label in enumerate(labels):
        table.setdefault(settings[row], {}).setdefault(str(label), {})[keys[row]] = row
    baseline = str(study.declared.compare.baseline)
    found = []
    for setting, by_label in table.items():
        partners = by_label.get(baseline, {})
        for label in study.compared.labels:
            if str(label) == baseline or str(label) not in by_label:
                continue
            mine = by_label[str(label)]
            both = [key for key in mine if key in partners]
            rows = np.array([mine[key] for key in both], dtype=np.int64)
            bases = np.array([partners[key] for key in both], dtype=np.int64)
            whole = np.isfinite(values[rows]) & np.isfinite(values[bases])
            lacking = len(mine) - int(whole.sum())
            its_worlds = [worlds[row] for row in rows[whole].tolist()]
            a, b = values[rows[whole]], values[bases[whole]]
            by_world = []
            several = list(dict.fromkeys(its_worlds)) if alone and len(set(its_worlds)) > 1 else []
            for world in several:
                here = np.array([other == world for other in its_worlds])
                by_world.append(
                    _pairs(setting, label, world, a[here], b[here], [world] * int(here.sum()), sign)
                )
            everywhere = _pairs(setting, label, None, a, b, its_worlds, sign, lacking)
            found.append((everywhere, by_world))
    return found


def _pairs(
    setting: tuple[Label, ...],
    label: Label,
    world: Any,
    a: NDArray[np.float64],
    b: NDArray[np.float64],
    worlds: list[Any],
    sign: int,
    lacking: int = 0,
) -> Pairs:
    d = a - b
    units = [float(unit.mean()) for unit in by_unit(d, worlds)]
    better = np.where(d == 0.0, 0.5, (sign * d > 0.0).astype(np.float64))
    return Pairs(
        setting=setting,
        label=label,
        world=world,
        differences=d,
        base=b,
        worlds=worlds,
        lacking=lacking,
        difference=mean_interval(units),
        ratio=ratio_over_units(a, b, worlds),
        improvement=_share(better, worlds),
        p=sign_flip_p(units),
    )


def _share(better: NDArray[np.float64], worlds: Sequence[Any]) -> Estimate:
    units = by_unit(better, worlds)
    shares = [float(unit.mean()) for unit in units]
    if len(set(worlds)) <= 1 or len(set(shares)) == 1:
        # Equal shares say nothing of how shares vary: each unit counts as one trial.
        return share_interval(sum(shares), len(shares))
    mean = mean_interval(shares)
    return replace(mean, low=max(0.0, mean.low), high=min(1.0, mean.high))


def _worlds(study: Study, frame: pl.DataFrame) -> list[Any]:
    """The world of each mission, unless worlds are what is compared."""
    names = [key for key in ("world", "world_seed") if key not in study.compared.keys]
    return _rows(frame, names)


def pair_keys(study: Study, frame: pl.DataFrame) -> list[Any]:
    """World, world seed and seed of each mission: the two missions of a pair agree in them."""
    names = [key for key in PLACE_KEYS if key not in study.compared.keys]
    return _rows(frame, names)


def _rows(frame: pl.DataFrame, names: Sequence[str]) -> list[tuple[Any, ...]]:
    """The values of some columns, a tuple per row."""
    columns = [frame[name].to_list() for name in names]
    return list(zip(*columns, strict=True)) if columns else [()] * frame.height
