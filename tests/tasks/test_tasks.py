"""Tasks in whole missions: the paper's, and those of a user's own file."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np
import polars as pl
import pytest

import swarmscout as ss
from swarmscout import Mission, Scenario
from swarmscout.cli.app import main
from swarmscout.core.enums import CHARGE, EXPLORE
from swarmscout.minds.modes import on_task
from swarmscout.mission.scenario_files import load_scenario, scenario_toml
from swarmscout.tasks.exploration import Exploration
from swarmscout.tasks.task import Task
from swarmscout.testing import check_task, small_world

PAGE = Path(__file__).parents[2] / "docs" / "tasks.md"
SEEN_PLACES = [[41.0, 17.0], [38.0, 8.5], [38.5, 3.5]]


@pytest.fixture
def own(tmp_path: Path) -> str:
    """The task on the page about tasks, in a file."""
    block = re.findall(r"```python\n(.*?)```", PAGE.read_text(encoding="utf-8"), re.DOTALL)[0]
    (tmp_path / "mine.py").write_text(block, encoding="utf-8")
    return f"{tmp_path}/mine.py:Places"


def places(own: str, given: Any = SEEN_PLACES) -> Task:
    names: dict[str, Any] = {}
    exec(Path(own.rpartition(":")[0]).read_text(encoding="utf-8"), names)
    task: Task = names["Places"](given)
    return task


def test_a_task_of_ones_own_flies_from_the_command_line_and_again_from_its_run(
    own: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    keys = ["--robots", "8", "--no-picture", "--destinations", "nearest-euclidean"]
    out = ["--set", f"task.model={own}", "--out", str(tmp_path / "run")]
    assert main(["explore", *keys, *out]) == 0
    (tmp_path / "mine.py").unlink()  # The run has its own copy.
    run = ss.Run.open(tmp_path / "run")
    assert run.summary is not None
    assert run.summary["task"] == "mine.py:Places"
    assert run.summary["end_reason"] == "all places seen"
    assert run.summary["score"] == 3.0
    assert "task" in capsys.readouterr().out
    offered = {tuple(cell) for cell in run.decisions.select("x_m", "y_m").rows()}
    assert offered <= {(41.25, 17.25), (38.25, 8.75), (38.75, 3.75)}
    mission = Mission(load_scenario(tmp_path / "run"))
    mission.run()
    assert mission.step_number == run.summary["steps"] < 300
    last = run.steps.filter(pl.col("step") == mission.step_number).select("x_m", "y_m").to_numpy()
    np.testing.assert_array_equal(mission.bodies.position, last)


@pytest.mark.parametrize(
    ("keys", "says"),
    [
        (["task.model=exploratio"], "unknown task 'exploratio': did you mean 'exploration'?"),
        (["task.radius=3"], "task 'exploration' has no parameter 'radius': it takes none"),
        (["task.model={own}", "task.place=3"], "did you mean 'places_m'?"),
        (["task.model=none.py:X"], "task file 'none.py' does not exist"),
        (["task=3"], "key 'task' = 3: it is a section, give its keys"),
    ],
)
def test_what_is_wrong_with_a_task_is_one_line(
    own: str, keys: list[str], says: str, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    given = [part for key in keys for part in ("--set", key.replace("{own}", own))]
    assert main(["explore", *given, "--out", str(tmp_path / "run"), "--steps", "3"]) == 2
    shown = capsys.readouterr().err
    assert says in shown
    assert shown.count("\n") == 1
    assert not (tmp_path / "run").exists()


def test_a_task_survives_a_file(tmp_path: Path) -> None:
    scenario = Scenario(task={"model": "x.py:Y", "places_m": [[1.0, 2.0]], "deep": 3})
    (tmp_path / "s.toml").write_text(scenario_toml(scenario), encoding="utf-8")
    assert load_scenario(tmp_path / "s.toml") == scenario
    assert Scenario(**scenario.model_dump()) == scenario


class AsExploration(Exploration):
    """The same, but asked for its candidates: the grids' own marks are not used."""


def everything(mission: Mission) -> list[Any]:
    found: list[Any] = []
    while not mission.done:
        mission.step()
        found += [mission.bodies.position.tobytes(), mission.minds.own.tobytes()]
        found += [(d.cell, d.frontiers, d.cause) for d in mission.decisions]
    return [*found, mission.end_reason]


@pytest.mark.parametrize("members", ["shared", "fan"])
@pytest.mark.parametrize("linked", [True, False])
def test_candidates_by_asking_are_the_marks_of_the_grids(members: str, linked: bool) -> None:
    keys = {"robots": 6, "steps": 60, "destinations": "nearest", "teams": {"members": members}}

    def fly(task: Task | None) -> list[Any]:
        links = None if linked else lambda step: np.eye(6, k=step % 3, dtype=np.bool_)
        given = Scenario.model_validate(keys)
        return everything(Mission(given, world=small_world(2), links=links, task=task))

    assert fly(AsExploration()) == fly(None)


def test_a_team_has_reached_what_lies_within_the_tasks_reach() -> None:
    class Far(Exploration):
        reach_m = 1.5

    def causes(task: Task, **renewal: Any) -> list[str]:
        keys = {"robots": 3, "steps": 80, "destinations": "nearest", "renewal": renewal}
        keys["sensor"] = {"range_m": 3.0}  # Farther than the reach, which is never more.
        mission = Mission(Scenario.model_validate(keys), world=small_world(1), task=task)
        return [part for part in everything(mission) if isinstance(part, tuple)]

    far = causes(Far())
    assert far == causes(AsExploration(), reach_m=1.5)
    assert far != causes(AsExploration())


def test_a_task_may_be_handed_over_as_an_object(own: str) -> None:
    class Never(Task):
        def candidates(self, map: Any, step: int) -> Any:
            return np.zeros(map.frame.shape, dtype=np.bool_)

    scenario = Scenario(robots=3, steps=10, destinations="nearest")
    mission = Mission(scenario, world=small_world(1), task=Never())
    mission.run()
    assert mission.scenario.task.model == "object:Never"
    assert (mission.minds.destination == -1).all()
    assert mission.end_reason == "steps used up"
    assert mission.summary()["score"] == mission.explored_m2
    with pytest.raises(ss.TaskError, match="was an object in memory"):
        Mission(mission.scenario, world=small_world(1))
    with pytest.raises(ss.TaskError, match="expected an object with a method candidates"):
        Mission(scenario, task=Never)  # type: ignore[arg-type]

    class Bare:
        def candidates(self, map: Any, step: int) -> Any:
            return None

    with pytest.raises(ss.TaskError, match=r"task is a Bare, derive its class from .*Task"):
        Mission(scenario, task=Bare())  # type: ignore[arg-type]


def test_only_the_task_says_when_it_is_done() -> None:
    class Forever(Exploration):
        def done(self, map: Any, explored_m2: float, reachable_m2: float) -> None:
            return None

    def fly(steps: int, task: Task | None) -> Mission:
        keys = {"robots": 6, "steps": steps, "destinations": "nearest"}
        scenario = Scenario.model_validate({**keys, "battery": {"enabled": False}})
        mission = Mission(scenario, world=small_world(1), task=task)
        mission.run()
        return mission

    paper = fly(2000, None)
    assert paper.end_reason in (
        "everything reachable explored",
        "no frontier left",
        "no reachable frontier left",
    )
    longer = fly(paper.step_number + 20, Forever())
    assert longer.end_reason == "steps used up"
    assert longer.judge.area_m2[: paper.step_number + 1] == paper.judge.area_m2


@pytest.mark.parametrize(
    ("name", "answer", "says"),
    [
        ("candidates", [], r"returned a list as candidates, expected bool\[rows, columns\]"),
        (
            "candidates",
            np.zeros(3, dtype=np.bool_),
            r"returned candidates of shape \(3,\), expected map",
        ),
        ("candidates", np.zeros((3, 3)), "returned an array of float64 as candidates"),
        ("done", 3, "returned 3 in done, expected the reason in words, or None"),
        ("done", "", "returned '' in done"),
        ("score", None, "returned None in score, expected a number"),
        ("score", float("nan"), "returned nan in score"),
        ("done", KeyError("here"), "failed in done: KeyError"),
        ("candidates", KeyError("here"), "failed in step 1: KeyError"),
    ],
)
def test_answers_outside_the_contract_stop_the_mission(name: str, answer: Any, says: str) -> None:
    def answering(self: Any, *given: Any) -> Any:
        if isinstance(answer, Exception):
            raise answer
        return answer

    kind = type("Wrong", (AsExploration,), {name: answering})
    mission = Mission(Scenario(robots=2, steps=2), world=small_world(1), task=kind())
    with pytest.raises(ss.TaskError, match=f"task 'Wrong' {says}"):
        mission.run()


def test_a_reach_that_is_no_distance_is_refused() -> None:
    kind = type("Wrong", (AsExploration,), {"reach_m": -1})
    with pytest.raises(ss.TaskError, match="reach_m = -1, expected metres above 0, or None"):
        Mission(Scenario(robots=2, steps=2), world=small_world(1), task=kind())


def test_a_robot_that_charges_does_not_work_on_the_task() -> None:
    assert on_task(EXPLORE)
    assert not on_task(CHARGE)
    assert on_task(np.array([CHARGE, EXPLORE])).tolist() == [False, True]


def test_the_task_on_its_page_passes_the_check(own: str) -> None:
    assert "task" in str(check_task(own))


def test_a_study_compares_tasks_by_score(own: str, tmp_path: Path) -> None:
    (tmp_path / "tasks.toml").write_text(
        'name = "tasks"\nquestion = "Which?"\nmetric = "score"\ntrials = 2\n'
        '[compare]\naxis = "task.model"\nbaseline = "exploration"\n'
        "[scenario]\nrobots = 3\nsteps = 5\n"
        '[axes]\n"task.model" = ["exploration", "mine.py:Places"]\n',
        encoding="utf-8",
    )
    study = ss.Study.load(tmp_path / "tasks.toml")
    names = [mission.name for mission in study.missions]
    assert len(set(names)) == 4
    # The file is known by its contents.
    (tmp_path / "mine.py").write_text(
        (tmp_path / "mine.py").read_text(encoding="utf-8") + "\n", encoding="utf-8"
    )
    changed = [mission.name for mission in ss.Study.load(tmp_path / "tasks.toml").missions]
    assert len(set(names) & set(changed)) == 2


def test_tasks_and_radios_are_listed(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["list", "tasks"]) == 0
    assert "exploration  Explore everything that can be reached" in capsys.readouterr().out
    assert main(["list", "radios"]) == 0
    assert "disc  Robots hear each other up to a distance" in capsys.readouterr().out
