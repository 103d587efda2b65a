"""The section ``[task]`` of a scenario."""

from __future__ import annotations

from typing import Any

from pydantic import ConfigDict, Field

from swarmscout.core.parameters import Parameters

__all__ = ["TaskParameters", "task_parameters"]


class TaskParameters(Parameters):
    """What the swarm is to do; further keys are the parameters of the task's class."""

    model_config = ConfigDict(extra="allow")

    model: str = Field("exploration", min_length=1, description="the task, or FILE.py:NAME")


def task_parameters(given: TaskParameters) -> dict[str, Any]:
    """What a task's class is made with.

    Args:
        given: the section ``[task]``.
    """
    return given.model_dump(exclude={"model"})
