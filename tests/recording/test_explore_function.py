from __future__ import annotations

import inspect
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import swarmscout as ss
from swarmscout.destinations.registry import RECOMMENDED
from swarmscout.destinations.selector import Choice


@dataclass(frozen=True)
class First:
    """A rule that is in no file of its own."""

    skip: int = 0

    def choose(self, view: Any, memory: Any) -> Choice:
        row, col = view.frontiers[min(self.skip, len(view.frontiers) - 1)].tolist()
        return Choice((row, col))


def test_the_scenario_s_defaults_are_the_function_s() -> None:
    default = ss.Scenario()
    for name, parameter in inspect.signature(ss.explore).parameters.items():
        if name in ("world", "robots", "steps", "seed"):
            assert parameter.default == getattr(default, name)


def test_exploring_in_memory() -> None:
    run = ss.explore(robots=4, steps=30, seed=3, teams={"desired_size": 2})
    assert run.path is None
    assert run.scenario.teams.desired_size == 2
    assert run.scenario.destinations == RECOMMENDED
    assert run.coverage["explored_m2"][-1] > 0
    assert run.coverage.height == 31


def test_exploring_into_a_folder_and_opening_it(tmp_path: Path) -> None:
    run = ss.explore(robots=4, steps=30, seed=3, out=tmp_path / "x")
    again = ss.Run.open(tmp_path / "x")
    assert again.summary == run.summary
    assert again.steps.equals(run.steps)
    with pytest.raises(ss.RunError, match="not empty"):
        ss.explore(robots=4, steps=30, out=tmp_path / "x")
    assert ss.Run.open(tmp_path / "x").steps.equals(run.steps)


@pytest.mark.parametrize(
    ("keys", "error", "message"),
    [
        ({"robots": 0}, ss.ScenarioError, "robots"),
        ({"robotts": 3}, ss.ScenarioError, "did you mean 'robots'"),
        ({"world": "lava"}, ss.WorldError, "lava"),
        ({"destinations": "nearst"}, ss.SelectorError, "did you mean 'nearest'"),
        ({"seed": 1.5}, ss.ScenarioError, "seed"),
        ({"world": np.ones((9, 9))}, ss.WorldError, "float64, expected booleans"),
        ({"world": [[1, 1]]}, ss.WorldError, "world is a list"),
        ({"world": None}, ss.WorldError, "world is a NoneType"),
        ({"destinations": 3}, ss.SelectorError, "destinations is a int"),
        ({"destinations": First(), "selector": {"skip": 1}}, ss.SelectorError, "already made"),
        ({"record": "all"}, ss.RunError, "recording level 'all' is unknown"),
    ],
)
def test_a_mistake_leaves_nothing_behind(
    keys: dict[str, object], error: type[Exception], message: str, tmp_path: Path
) -> None:
    with pytest.raises(error, match=message):
        ss.explore(out=tmp_path / "x", **keys)  # type: ignore[arg-type]
    assert not (tmp_path / "x").exists()


def test_a_selector_as_an_object_or_a_class(tmp_path: Path) -> None:
    keys: dict[str, Any] = {"robots": 3, "steps": 15}
    by_object = ss.explore(destinations=First(2), out=tmp_path / "x", **keys)
    by_class = ss.explore(destinations=First, selector={"skip": 2}, **keys)
    assert by_object.decisions.equals(by_class.decisions)
    assert not by_object.decisions.equals(ss.explore(destinations=First, **keys).decisions)
    assert by_object.summary is not None
    assert by_object.summary["selector"] == "object:First"
    again = ss.Run.open(tmp_path / "x")
    with pytest.raises(ss.SelectorError, match=r"was an object in memory.*FILE\.py:First"):
        ss.Mission(again.scenario)
    with pytest.raises(ss.SelectorError, match="skip = 'two': should be a valid integer"):
        ss.explore(destinations=First, selector={"skip": "two"}, **keys)


def test_an_array_is_a_world() -> None:
    free = np.zeros((80, 60), dtype=np.bool_)
    free[5:75, 5:55] = True
    run = ss.explore(world=free, robots=2, steps=5)
    assert run.world().extent == (0.0, 6.0, 0.0, 8.0)


@pytest.mark.parametrize("out", [5, None, "", b"x"])
def test_a_folder_is_a_path(out: Any) -> None:
    with pytest.raises(ss.RunError, match="given by its path"):
        ss.Run.open(out)
    if out is not None:
        with pytest.raises(ss.RunError, match="given by its path"):
            ss.explore(out=out)


@pytest.mark.parametrize("step", ["3", 2.5, True, [1]])
def test_a_step_is_a_whole_number(step: Any) -> None:
    run = ss.explore(robots=2, steps=5)
    with pytest.raises(ss.RunError, match="expected a whole number, 0 to 5"):
        run.map_at(step)
