"""Options of a reproduction: full or quick, and the selector in the language model's place."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from importlib import resources
from pathlib import Path
from typing import Any

from swarmscout.api import record_mission
from swarmscout.mission.scenario_files import load_scenario
from swarmscout.recording.run import Run
from swarmscout.studies.study import Study

__all__ = ["LLM_LIKE", "Options", "RunStudy", "run_mission", "said_of", "study_named"]

LLM_LIKE = "llm-like"
"""The selector in the language model's place by default: a formula of the paper's reasons."""

_CONTROLS = {"llm-shortlist": ("shortlist-random",)}

RunStudy = Callable[[Study], Any]


@dataclass(frozen=True)
class Options:
    """Options of a reproduction.

    Attributes:
        out: the folder of this figure.
        run_study: runs a study to its end.
        quick: small counts, to check that everything works; the numbers mean nothing.
        caves: use the first caves of a study only; None: all.
        selector: in the place of the paper's language model.
        llm: scenario keys of the language model, for a selector that asks one.
    """

    out: Path
    run_study: RunStudy
    quick: bool = False
    caves: int | None = None
    selector: str = LLM_LIKE
    llm: Mapping[str, Any] = field(default_factory=dict)

    @property
    def keys(self) -> dict[str, Any]:
        """Scenario keys of missions by the selector."""
        return {"destinations": self.selector, **self.llm}


def said_of(options: Options) -> str:
    """Words for titles: the selector in the language model's place."""
    rule = options.selector.rpartition(":")[2]
    words = f"by {rule}"
    if options.selector == LLM_LIKE:
        words = f"by {rule}, a formula of the paper's reasons: no language model was asked"
    elif options.llm:
        words += f", asking {options.llm.get('llm.model') or options.llm['llm.provider']}"
    return words + (" (quick: small counts, no result)" if options.quick else "")


def run_mission(options: Options, name: str, keys: Mapping[str, Any]) -> Run:
    """Run a mission of the scenario "paper", or open it if it was run before.

    Args:
        options: of the reproduction.
        name: of the run's folder.
        keys: scenario keys.
    """
    scenario = load_scenario("paper", keys)
    folder = options.out / name
    if folder.is_dir():
        run = Run.open(folder)
        if run.finished and run.scenario == scenario and _same_rules(run):
            return run
        folder = _next(folder)
    return record_mission(scenario, out=folder)


def study_named(options: Options, name: str) -> Study:
    """A study of the paper, with the chosen selector in the language model's place; not run yet."""
    text = (resources.files("swarmscout.reproduction") / "studies" / f"{name}.toml").read_text(
        encoding="utf-8"
    )
    options.out.mkdir(parents=True, exist_ok=True)
    file = options.out / f"{name}.toml"
    # A random pick from the same shortlist is the control of a model that picks from one.
    arms = [options.selector, *_CONTROLS.get(options.selector, ())]
    named = ", ".join(f'"{arm}"' for arm in arms)
    file.write_text(text.replace(f'"{LLM_LIKE}"', named), encoding="utf-8")
    study = Study.load(file, options.out / "study")
    if options.llm:
        study = study.changed({"scenario": {**study.declared.scenario, **options.llm}})
    if options.caves is not None:
        study = _with_caves(study, options.caves)
    return _in_small(study) if options.quick else study


def _with_caves(study: Study, count: int) -> Study:
    axes = {
        name: values[:count] if name in ("world", "world_seed") else values
        for name, values in study.declared.axes.items()
    }
    return study.changed({"axes": axes})


def _in_small(study: Study) -> Study:
    """The same questions with two worlds, one trial, few robots and few steps."""
    small = {"world": "lava-tube-small", "robots": 6, "steps": 40}
    scenario = {**study.declared.scenario, **small}
    return _with_caves(study, 2).changed({"scenario": scenario, "trials": 1})


def _same_rules(run: Run) -> bool:
    from swarmscout.mission.mission import RULES_VERSION

    return run.facts.get("rules_version") == RULES_VERSION


def _next(folder: Path) -> Path:
    number = 2
    while (free := folder.with_name(f"{folder.name}-{number}")).exists():
        number += 1
    return free
