"""A few recorded runs side by side: what differs in them, and what they achieved."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from swarmscout.core.errors import RunError
from swarmscout.recording.run import Run
from swarmscout.recording.tables import LEVELS
from swarmscout.studies.intervals import Estimate, mean_over_units, ratio_over_units
from swarmscout.studies.study_file import PLACE_KEYS, dotted

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["ComparedRun", "Gain", "RunComparison", "compare_runs", "curves_of_runs"]

_RULES = "rules_version"


@dataclass(frozen=True)
class ComparedRun:
    """One run among those compared.

    Attributes:
        run: the run.
        path: its folder.
        keys: the values of the scenario keys that are not the same in all runs.
        explored_m2: explored area at its last step; NaN where nothing recorded it.
    """

    run: Run
    path: Path
    keys: dict[str, Any]
    explored_m2: float

    @property
    def kind(self) -> str:
        """What is different in it, besides the world and the seed."""
        return _values({k: v for k, v in self.keys.items() if k not in PLACE_KEYS})

    @property
    def label(self) -> str:
        """What distinguishes it from the others."""
        return _values(self.keys) or self.path.name

    @property
    def rules_version(self) -> Any:
        """The version of the rules that it was made by."""
        return self.run.facts.get(_RULES)


@dataclass(frozen=True)
class Gain:
    """One kind of runs against the first kind, in pairs of the same world and seed.

    Attributes:
        label: what is different in it.
        pairs: number of pairs.
        difference: difference in explored area, in m².
        ratio: ratio of explored areas.
    """

    label: str
    pairs: int
    difference: Estimate
    ratio: Estimate


@dataclass(frozen=True)
class RunComparison:
    """Runs side by side.

    Attributes:
        runs: in the given order.
        differing: scenario keys that are not the same in all runs.
        gains: every kind of run against the first kind, where there are pairs.
        rules_versions: the different versions of the rules that the runs were made by.
    """

    runs: list[ComparedRun]
    differing: list[str]
    gains: list[Gain]
    rules_versions: list[Any]


def compare_runs(paths: Sequence[str | Path]) -> RunComparison:
    """Open some runs and compare them.

    Runs that were made by other rules than the first make no pairs with it.

    Args:
        paths: two run folders or more, finished or not.

    Raises:
        RunError: there are fewer than two, or one of them cannot be read; the message names it.
    """
    if len(paths) < 2:
        raise RunError("give two runs or more to compare")
    opened = []
    for path in paths:
        with _named(path):
            run = Run.open(path)
            keys = dict(dotted(run.scenario.model_dump())) | {_RULES: run.facts.get(_RULES)}
            opened.append((run, Path(path), keys, _explored_m2(run)))
    every = list(dict.fromkeys(key for _, _, keys, _ in opened for key in keys))
    differing = [key for key in every if len({repr(keys.get(key)) for _, _, keys, _ in opened}) > 1]
    runs = [
        ComparedRun(run, path, {key: keys.get(key) for key in differing}, explored)
        for run, path, keys, explored in opened
    ]
    versions = list(dict.fromkeys(run.rules_version for run in runs))
    return RunComparison(runs, differing, _gains(runs), versions)


def curves_of_runs(comparison: RunComparison) -> Figure:
    """Explored area over steps, a line per run.

    Raises:
        RunError: a run has no curve, since its recording level is ``summary``.
    """
    from matplotlib.figure import Figure

    from swarmscout.studies.report_figures import style_of

    figure = Figure(figsize=(7.0, 4.2), layout="constrained")
    axes = figure.add_subplot()
    for at, compared in enumerate(comparison.runs):
        with _named(compared.path):
            area = compared.run.coverage
        label = compared.label.replace("$", r"\$")
        axes.plot(area["step"], area["explored_m2"], label=label, **style_of(at))
    axes.set(xlabel="step", ylabel="explored area (m²)", xlim=(0, None), ylim=(0, None))
    axes.legend(fontsize="small", frameon=False)
    return figure


@contextmanager
def _named(path: str | Path) -> Iterator[None]:
    """Errors inside name the run."""
    try:
        yield
    except RunError as error:
        if str(path) in str(error):
            raise
        raise RunError(f"run '{path}': {error}") from None


def _explored_m2(run: Run) -> float:
    if run.summary is not None:
        return float(run.summary["explored_m2"])
    if "coverage" in LEVELS[run.level] and run.coverage.height:
        return float(run.coverage["explored_m2"][-1])
    return math.nan


def _gains(runs: Sequence[ComparedRun]) -> list[Gain]:
    areas: dict[str, dict[Any, float]] = {}
    for each in runs:
        if each.rules_version == runs[0].rules_version:
            scenario = each.run.scenario
            world = each.run.facts["world"].get("name"), scenario.world_seed
            areas.setdefault(each.kind, {})[world, scenario.seed] = each.explored_m2
    first, *others = areas.items()
    found = []
    for kind, its in others:
        both = [place for place in its if place in first[1]]
        if both:
            a = np.array([its[place] for place in both])
            b = np.array([first[1][place] for place in both])
            worlds = [place[0] for place in both]
            difference = mean_over_units(a - b, worlds)
            found.append(Gain(kind, len(both), difference, ratio_over_units(a, b, worlds)))
    return found


def _values(keys: dict[str, Any]) -> str:
    return ", ".join(f"{key.rpartition('.')[2]} {value}" for key, value in keys.items())
