from __future__ import annotations

from pathlib import Path

import pytest

import swarmscout as ss


def test_exploring_in_memory() -> None:
    run = ss.explore(robots=4, steps=30, seed=3, teams={"desired_size": 2})
    assert run.path is None
    assert run.scenario.teams.desired_size == 2
    assert run.scenario.destinations == "nearest"
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
        ({"record": "all"}, ss.RunError, "recording level 'all' is unknown"),
    ],
)
def test_a_mistake_leaves_nothing_behind(
    keys: dict[str, object], error: type[Exception], message: str, tmp_path: Path
) -> None:
    with pytest.raises(error, match=message):
        ss.explore(out=tmp_path / "x", **keys)  # type: ignore[arg-type]
    assert not (tmp_path / "x").exists()
