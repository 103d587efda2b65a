"""A few runs beside each other: what differs in them, and what they achieved."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from swarmscout.core.errors import RunError
from swarmscout.recording.run import Run
from swarmscout.recording.tables import LEVELS
from swarmscout.studies.intervals import Estimate, by_unit, mean_interval
from swarmscout.studies.study_file import PLACE_KEYS, dotted

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["Beside", "Gain", "curves_beside", "runs_beside"]


@dataclass(frozen=True)
class Gain:
    """One kind of runs beside the first kind, in pairs of the same world and seed.

    Attributes:
        label: what is different in it.
        pairs: how many there are.
        difference: of explored area, in m².
        ratio: of explored area.
    """

    label: str
    pairs: int
    difference: Estimate
    ratio: Estimate


@dataclass(frozen=True)
class Beside:
    """Runs beside each other.

    Attributes:
        runs: in the given order.
        names: of their folders.
        differing: keys of scenarios that are not the same everywhere.
        keys: the values of these keys, by run.
        gains: every kind of run beside the first kind; empty where nothing makes a pair.
        baseline: the first kind.
    """

    runs: list[Run]
    names: list[str]
    differing: list[str]
    keys: list[dict[str, Any]]
    gains: list[Gain]
    baseline: str

    def label(self, at: int) -> str:
        """What tells a run apart."""
        told = [f"{_tail(key)} {value}" for key, value in self.keys[at].items()]
        return ", ".join(told) or self.names[at]


def runs_beside(paths: Sequence[str | Path]) -> Beside:
    """Open some runs and put them beside each other.

    Args:
        paths: run folders, finished or not.

    Raises:
        RunError: there are fewer than two, or one of them is no run.
    """
    if len(paths) < 2:
        raise RunError("give two runs or more to compare")
    runs = [Run.open(path) for path in paths]
    flat = [dict(dotted(run.scenario.model_dump())) for run in runs]
    every = list(dict.fromkeys(key for keys in flat for key in keys))
    differing = [key for key in every if len({repr(keys.get(key)) for keys in flat}) > 1]
    keys = [{key: each.get(key) for key in differing} for each in flat]
    kinds = [", ".join(f"{_tail(k)} {v}" for k, v in _kind(each).items()) for each in keys]
    return Beside(
        runs=runs,
        names=[Path(path).name for path in paths],
        differing=differing,
        keys=keys,
        gains=_gains(runs, kinds),
        baseline=kinds[0],
    )


def curves_beside(beside: Beside) -> Figure:
    """Explored area over time, a line per run.

    Raises:
        RunError: a run has no curve, as its level is ``summary``.
    """
    from matplotlib.figure import Figure

    from swarmscout.studies.figures import style_of

    figure = Figure(figsize=(7.0, 4.2), layout="constrained")
    axes = figure.add_subplot()
    for at, run in enumerate(beside.runs):
        coverage = run.coverage
        axes.plot(coverage["step"], coverage["explored_m2"], label=beside.label(at), **style_of(at))
    axes.set(xlabel="step", ylabel="explored area (m²)", xlim=(0, None), ylim=(0, None))
    axes.legend(fontsize="small", frameon=False)
    return figure


def explored_m2(run: Run) -> float:
    """Explored area at the end of a run; NaN when nothing says it."""
    if run.summary is not None:
        return float(run.summary["explored_m2"])
    if "coverage" in LEVELS[run.level] and run.coverage.height:
        return float(run.coverage["explored_m2"][-1])
    return math.nan


def _kind(keys: Mapping[str, Any]) -> dict[str, Any]:
    return {key: value for key, value in keys.items() if key not in PLACE_KEYS}


def _gains(runs: Sequence[Run], kinds: Sequence[str]) -> list[Gain]:
    areas: dict[str, dict[Any, float]] = {kind: {} for kind in kinds}
    for run, kind in zip(runs, kinds, strict=True):
        place = (run.facts["world"].get("name"), run.scenario.world_seed), run.scenario.seed
        areas[kind][place] = explored_m2(run)
    first, *others = areas.values()
    found = []
    for kind, its in zip(list(areas)[1:], others, strict=True):
        both = [place for place in its if place in first]
        if not both:
            continue
        a = np.array([its[place] for place in both])
        b = np.array([first[place] for place in both])
        worlds = [place[0] for place in both]
        difference = mean_interval([float(unit.mean()) for unit in by_unit(a - b, worlds)])
        ratio = Estimate(math.nan)
        if (b > 0.0).all():
            ratio = mean_interval([float(unit.mean()) for unit in by_unit(a / b, worlds)])
        found.append(Gain(kind, len(both), difference, ratio))
    return found


def _tail(key: str) -> str:
    return key.rpartition(".")[2]
