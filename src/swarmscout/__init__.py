"""Explore unknown places with swarms of robots that form teams by themselves.

Importing the package costs nothing: each public name is loaded when it is first used.

Example:
    >>> import swarmscout as ss
    >>> run = ss.explore(world="lava-tube", robots=15, steps=300, seed=0)  # doctest: +SKIP
    >>> run.coverage["explored_m2"][-1]  # doctest: +SKIP
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from swarmscout.api import explore, record_mission
    from swarmscout.core.errors import (
        ModelError,
        PolicyError,
        RunError,
        ScenarioError,
        SelectorError,
        SensorError,
        StudyError,
        SwarmscoutError,
        TaskError,
        WorldError,
    )
    from swarmscout.mission.mission import Mission
    from swarmscout.mission.scenario import Scenario
    from swarmscout.mission.scenario_files import load_scenario
    from swarmscout.recording.run import Run
    from swarmscout.recording.writer import RunWriter
    from swarmscout.studies.study import Study
    from swarmscout.viewing.map_picture import map_picture
    from swarmscout.worlds.catalogue import load_world
    from swarmscout.worlds.world import World

    __version__: str

__all__ = [
    "Mission",
    "ModelError",
    "PolicyError",
    "Run",
    "RunError",
    "RunWriter",
    "Scenario",
    "ScenarioError",
    "SelectorError",
    "SensorError",
    "Study",
    "StudyError",
    "SwarmscoutError",
    "TaskError",
    "World",
    "WorldError",
    "__version__",
    "explore",
    "load_scenario",
    "load_world",
    "map_picture",
    "record_mission",
]

_HOME = {
    "Mission": "swarmscout.mission.mission",
    "ModelError": "swarmscout.core.errors",
    "PolicyError": "swarmscout.core.errors",
    "Run": "swarmscout.recording.run",
    "RunError": "swarmscout.core.errors",
    "RunWriter": "swarmscout.recording.writer",
    "Scenario": "swarmscout.mission.scenario",
    "ScenarioError": "swarmscout.core.errors",
    "SelectorError": "swarmscout.core.errors",
    "SensorError": "swarmscout.core.errors",
    "Study": "swarmscout.studies.study",
    "StudyError": "swarmscout.core.errors",
    "SwarmscoutError": "swarmscout.core.errors",
    "TaskError": "swarmscout.core.errors",
    "World": "swarmscout.worlds.world",
    "WorldError": "swarmscout.core.errors",
    "explore": "swarmscout.api",
    "load_scenario": "swarmscout.mission.scenario_files",
    "load_world": "swarmscout.worlds.catalogue",
    "map_picture": "swarmscout.viewing.map_picture",
    "record_mission": "swarmscout.api",
}


def __getattr__(name: str) -> Any:
    """Load a public name (PEP 562)."""
    if name == "__version__":
        from swarmscout.core.version import package_version

        value: Any = package_version()
    elif name in _HOME:
        from importlib import import_module

        value = getattr(import_module(_HOME[name]), name)
    else:
        raise AttributeError(f"module 'swarmscout' has no attribute '{name}'")
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    """The public names, loaded or not."""
    return sorted(__all__)
