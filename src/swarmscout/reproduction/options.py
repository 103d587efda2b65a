"""How a figure is reproduced: in full or in small, and by which rule."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from importlib import resources
from pathlib import Path
from typing import Any

from swarmscout.mission.scenario_files import load_scenario
from swarmscout.recording.explore import record_mission
from swarmscout.recording.run import Run
from swarmscout.studies.study import Study

__all__ = ["LLM_LIKE", "Options", "run_mission", "said_of", "study_named"]

LLM_LIKE = "llm-like"
"""Stands for the language model where none is named: a formula of the reasons the paper reports."""

RunStudy = Callable[[Study], Any]


@dataclass(frozen=True)
class Options:
    """What is wanted.

    Attributes:
        out: the folder of this figure.
        run_study: runs a study to its end.
        quick: small counts, to see that everything works: no numbers to be shown.
        selector: in the place of the paper's language model.
    """

    out: Path
    run_study: RunStudy
    quick: bool = False
    selector: str = LLM_LIKE


def said_of(options: Options) -> str:
    """What the title of a figure must say of whoever stood in the language model's place."""
    rule = options.selector.rpartition(":")[2]
    told = f"by {rule}"
    if options.selector == LLM_LIKE:
        told = f"by {rule}, a formula of the paper's reasons: no language model was asked"
    return told + (" (quick: small counts, no result)" if options.quick else "")


def run_mission(options: Options, name: str, **keys: Any) -> Run:
    """Run a mission of the scenario "paper" and keep it whole; one that is there is opened.

    Args:
        options: where to.
        name: of its folder.
        **keys: scenario keys, ``__`` for a dot.
    """
    scenario = load_scenario("paper", {key.replace("__", "."): v for key, v in keys.items()})
    folder = options.out / name
    if folder.is_dir():
        run = Run.open(folder)
        if run.finished and run.scenario == scenario and _same_rules(run):
            return run
        folder = _next(folder)
    return record_mission(scenario, out=folder)


def study_named(options: Options, name: str) -> Study:
    """A study of this room, with the wanted rule in the language model's place, not run yet."""
    text = (resources.files("swarmscout.reproduction") / "studies" / f"{name}.toml").read_text(
        encoding="utf-8"
    )
    options.out.mkdir(parents=True, exist_ok=True)
    file = options.out / f"{name}.toml"
    file.write_text(text.replace(f'"{LLM_LIKE}"', f'"{options.selector}"'), encoding="utf-8")
    study = Study.load(file, options.out / "study")
    return _in_small(study) if options.quick else study


def _in_small(study: Study) -> Study:
    """The same questions with two worlds, one trial, few robots and few steps."""
    declared = study.declared
    axes = {
        name: values[:2] if name in ("world", "world_seed") else values
        for name, values in declared.axes.items()
    }
    scenario = {**declared.scenario, "world": "lava-tube-small", "robots": 6, "steps": 40}
    changes = {"axes": axes, "scenario": scenario, "trials": 1}
    return study.changed(changes)


def _same_rules(run: Run) -> bool:
    from swarmscout.mission.mission import RULES_VERSION

    return run.facts.get("rules_version") == RULES_VERSION


def _next(folder: Path) -> Path:
    number = 2
    while (free := folder.with_name(f"{folder.name}-{number}")).exists():
        number += 1
    return free
