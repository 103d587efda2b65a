"""Running a recorded mission again: what would not be the same is refused, or said."""

from __future__ import annotations

from collections.abc import Collection
from pathlib import Path

from swarmscout.core.errors import RunError
from swarmscout.mission.mission import RULES_VERSION
from swarmscout.mission.scenario_files import named_scenarios
from swarmscout.recording.json_files import RUN
from swarmscout.recording.run import Run
from swarmscout.recording.run_folder import SCENARIO

__all__ = ["check_rerun", "run_behind"]


def run_behind(scenario: str | Path) -> Path | None:
    """The run's folder that a scenario is taken from; None for any other scenario.

    Args:
        scenario: a name, a file or a folder, as :func:`swarmscout.load_scenario` takes it.
    """
    if scenario in named_scenarios():
        return None
    path = Path(scenario)
    folder = path.parent if path.name == SCENARIO else path
    return folder if (folder / RUN).is_file() else None


def check_rerun(folder: Path, overrides: Collection[str] = ()) -> list[str]:
    """Check that a run's scenario gives the mission that was recorded.

    Args:
        folder: the run's.
        overrides: dotted scenario keys that are going to be changed.

    Returns:
        What will differ nevertheless, a line each.

    Raises:
        RunError: the mission cannot be run again: the run is damaged, something was handed over
            from Python that no scenario names, or the world cannot be made again.
    """
    run = Run.open(folder)
    sections = {key.partition(".")[0] for key in overrides}
    by_hand = run.facts.get("by_hand", ())
    if "links" in by_hand:
        raise RunError(
            f"run '{folder}' cannot be run again: its links were a Python function (links=…), "
            "which is not kept; run it from Python with the same function"
        )
    if "model" in by_hand and "llm" not in sections:
        raise RunError(
            f"run '{folder}' cannot be run again: its language model was a Python object (model=…),"
            " which is not kept; say with --llm which model is to answer"
        )
    if not {"world", "world_seed"} & sections:
        run.world()
    recorded = run.facts.get("rules_version")
    if recorded == RULES_VERSION:
        return []
    return [
        f"run '{folder}' was recorded under rules version {recorded}, and this swarmscout has "
        f"{RULES_VERSION}: the mission will not be the same"
    ]
