"""The conformance check of tasks passes what is sound, and names each mistake."""

from __future__ import annotations

import re

import pytest
from wrong_tasks import MISTAKES

from swarmscout.core.errors import TaskError
from swarmscout.tasks.registry import TASKS
from swarmscout.testing import CHECKS, check_task


@pytest.mark.parametrize("name", sorted(TASKS.names()))
def test_built_in_tasks_are_sound(name: str) -> None:
    report = CHECKS["task"](name)
    assert report.answers > 100
    text = str(report)
    assert f"task '{name}' is sound" in text
    assert "a map of which nothing is known" in text
    assert "2 missions in small caves" in text


@pytest.mark.parametrize(("kind", "says"), MISTAKES, ids=[kind.__name__ for kind, _ in MISTAKES])
def test_each_mistake_is_named(kind: type, says: str) -> None:
    with pytest.raises(TaskError, match=re.escape(says)) as caught:
        check_task(kind, missions=0)
    message = str(caught.value)
    assert kind.__name__ in message
    assert "\n" not in message
    assert message.count("TaskError") == 0
