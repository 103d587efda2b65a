"""Tasks by name: see :mod:`swarmscout.core.registry`.

Other packages register theirs under the entry point group ``swarmscout.tasks``.
"""

from __future__ import annotations

from swarmscout.core.errors import TaskError
from swarmscout.core.registry import Registry
from swarmscout.tasks.task import Task

__all__ = ["TASKS"]

TASKS: Registry[Task] = Registry(
    noun="task",
    method="candidates(map, step)",
    face=Task,  # type: ignore[type-abstract]
    error=TaskError,
    group="swarmscout.tasks",
    built_in={"exploration": "swarmscout.tasks.exploration:Exploration"},
)
