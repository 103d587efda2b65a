"""The conformance check of policies passes what is sound, and names each mistake."""

from __future__ import annotations

import random
import re
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from wrong_policies import MISTAKES

from swarmscout.core.errors import PolicyError, SelectorError
from swarmscout.destinations.registry import SELECTORS
from swarmscout.robots.radio.registry import RADIOS
from swarmscout.robots.sensors.registry import SENSORS
from swarmscout.tasks.registry import TASKS
from swarmscout.teams.registry import POLICIES, policies
from swarmscout.testing import CHECKS, check_policy
from swarmscout.worlds.readers import READERS


@pytest.mark.parametrize("name", sorted(policies()))
def test_built_in_policies_are_sound(name: str) -> None:
    report = check_policy(name)
    assert report.answers > 100
    assert len(report.checks) == 7
    text = str(report)
    assert f"policy '{name}' is sound" in text
    assert "one robot" in text
    assert "maps without a frontier" in text


@pytest.mark.parametrize(("kind", "says"), MISTAKES, ids=[kind.__name__ for kind, _ in MISTAKES])
def test_each_mistake_is_named(kind: type, says: str) -> None:
    with pytest.raises(PolicyError, match=re.escape(says)) as caught:
        check_policy(kind, missions=0)
    message = str(caught.value)
    assert kind.__name__ in message
    assert "\n" not in message
    assert message.count("PolicyError") == 0


def test_a_mistake_that_shows_late_is_found_in_a_mission() -> None:
    class Late:
        def desired(self, view: Any) -> Any:
            if view.step > 50:
                raise KeyError("no such thing")
            return np.ones(len(view), dtype=int)

    with pytest.raises(PolicyError, match=r"'Late' failed: KeyError.*in step \d+ of a mission"):
        check_policy(Late())


def test_own_numbers_roles_and_the_last_answer_may_be_used(tmp_path: Path) -> None:
    file = tmp_path / "roles.py"
    file.write_text(
        "import numpy as np\n"
        "class Roles:\n"
        "    def desired(self, view):\n"
        "        size = np.where(view.robot % 3 == 0, 1, view.desired_size)\n"
        "        return np.where(view.step % 10 == 0, size, view.previous)\n"
    )
    assert check_policy(f"{file}:Roles").name == f"{file}:Roles"


def test_what_cannot_be_made_is_refused_clearly() -> None:
    class Needs:
        def __init__(self, size: int) -> None:
            self.size = size

        def desired(self, view: Any) -> Any:
            return np.full(len(view), self.size)

    with pytest.raises(PolicyError, match="give an instance"):
        check_policy(Needs)
    check_policy(Needs(2), missions=1)
    with pytest.raises(PolicyError, match="did you mean 'by-mode'"):
        check_policy("bymode")


def test_generators_and_clocks_are_left_as_they_were() -> None:
    random.seed(5)
    np.random.seed(5)  # noqa: NPY002
    clocks = time.time, time.perf_counter
    expected = random.Random(5).random(), np.random.RandomState(5).random()
    check_policy("by-mode", missions=1)
    assert (random.random(), np.random.random()) == expected  # noqa: NPY002
    assert (time.time, time.perf_counter) == clocks


def test_there_is_a_check_for_every_kind_of_plug_in() -> None:
    kinds = (POLICIES, SELECTORS, SENSORS, RADIOS, TASKS, READERS)
    assert set(CHECKS) == {kind.noun for kind in kinds}
    assert CHECKS["policy"]("by-mode").noun == "policy"
    with pytest.raises(PolicyError, match="did you mean 'by-mode'"):
        CHECKS["policy"]("bymode")
    with pytest.raises(SelectorError, match="did you mean 'nearest'"):
        CHECKS["selector"]("nearst")
