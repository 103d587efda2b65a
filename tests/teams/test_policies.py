"""Policies are found by name and by file, and their mistakes reported in one line."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import swarmscout as ss
from swarmscout.core.enums import CHARGE
from swarmscout.core.errors import PolicyError, ScenarioError
from swarmscout.mission.scenario_files import load_scenario
from swarmscout.teams.by_mode import ByMode
from swarmscout.teams.registry import POLICIES, make_policy, policies
from swarmscout.testing import small_world
from swarmscout.testing.small_worlds import short_mission

PAIRS = (
    "import numpy as np\n"
    "class Pairs:\n"
    "    def __init__(self, size: int = 2):\n        self.size = size\n"
    "    def desired(self, view):\n        return np.full(len(view), self.size)\n"
)


@dataclass(frozen=True)
class Pairs:
    """Two by two."""

    size: int = 2

    def desired(self, view: Any) -> Any:
        return np.full(len(view), self.size)


def test_names() -> None:
    assert {"by-mode"} <= set(policies())
    assert all(line and "\n" not in line for line in policies().values())
    assert make_policy("by-mode") == ByMode()


@pytest.mark.parametrize(
    ("name", "parameters", "says"),
    [
        ("by-mod", None, "unknown policy 'by-mod': did you mean 'by-mode'?"),
        ("by-mode", {"size": 3}, "policy 'by-mode' has no parameter 'size': it takes none"),
        ("my.py", None, "'my.py' names a file but no class in it: write 'my.py:ClassName'"),
        ("missing.py:Rule", None, "policy file 'missing.py' does not exist"),
        ("object:Pairs", None, "put its class into a file and name it FILE.py:Pairs"),
    ],
)
def test_mistakes_with_names(name: str, parameters: Any, says: str) -> None:
    with pytest.raises(PolicyError) as caught:
        make_policy(name, parameters)
    assert says in str(caught.value)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("class Pair:\n    pass\n", "has no 'Pairs': did you mean 'Pair'?"),
        ("class Pairs:\n    pass\n", "is not a policy: it has no method desired(view)"),
        ("class Pairs\n", "pol.py' cannot be loaded: SyntaxError: expected ':' ("),
        ("1 / 0\n", "pol.py, line 1)"),
    ],
)
def test_mistakes_in_files(tmp_path: Path, text: str, says: str) -> None:
    file = tmp_path / "pol.py"
    file.write_text(text)
    with pytest.raises(PolicyError) as caught:
        make_policy(f"{file}:Pairs")
    assert says in str(caught.value)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("name", sorted(POLICIES.built_in))
def test_every_number_of_every_policy_is_checked(name: str) -> None:
    for key in getattr(POLICIES.load(name), "__dataclass_fields__", {}):
        for value in ("wide", float("nan"), None):
            with pytest.raises(PolicyError, match=f"policy '{name}': {key} = "):
                make_policy(name, {key: value})


def test_by_mode_is_the_papers() -> None:
    mission = short_mission(1, policy=ByMode())
    seen = set()
    for _ in range(60):
        mission.step()
        charging = mission.minds.mode == CHARGE
        assert (mission.minds.desired == np.where(charging, 1, 5)).all()
        seen |= set(charging.tolist())
    assert seen == {True, False}


@pytest.mark.parametrize("own_maps", [False, True])
def test_a_robot_in_chr_mode_desires_1_for_every_policy(own_maps: bool) -> None:
    mission = short_mission(1, policy=Pairs(7), own_maps=own_maps)
    for _ in range(60):
        mission.step()
        expected = np.where(mission.minds.mode == CHARGE, 1, 7)
        assert mission.minds.desired.tolist() == expected.tolist()


class Fails:
    def desired(self, view: Any) -> Any:
        return {}["size"]


class Leaves:
    def desired(self, view: Any) -> Any:
        raise SystemExit(3)


class Answers:
    def __init__(self, answer: Any) -> None:
        self.answer = answer

    def desired(self, view: Any) -> Any:
        return self.answer


@pytest.mark.parametrize(
    ("policy", "says"),
    [
        (Fails(), "policy 'object:Fails' failed in step 1: KeyError: 'size' ("),
        (Leaves(), "the code called sys.exit(3)"),
        (Answers(None), "returned None, expected int64[8], a size for each robot (step 1)"),
        (Answers(3), "returned int64[], expected int64[8], a size for each robot; the same for"),
        (Answers([1.0] * 8), "returned float64[8], expected int64[8]"),
        (Answers([1] * 7), "returned int64[7], expected int64[8]"),
        (Answers([1] * 7 + [0]), "answered 0 for robot 7 in step 1: expected 1 to 100,000"),
        (Answers([10**6] * 8), "answered 1000000 for robot 0 in step 1: expected 1 to 100,000"),
        (Answers([[1], [2, 3]]), "expected int64[8]"),
        (Answers("many"), "returned <U4[], expected int64[8]"),
        (Answers([True] * 8), "returned bool[8], expected int64[8]"),
    ],
)
def test_wrong_answers_are_reported(policy: Any, says: str) -> None:
    mission = short_mission(0, policy=policy)
    with pytest.raises(PolicyError) as caught:
        mission.step()
    assert says in str(caught.value)
    assert "\n" not in str(caught.value)


def test_lists_and_other_whole_numbers_will_do() -> None:
    for answer in ([2] * 8, np.full(8, 2, dtype=np.uint8), np.full(16, 2)[::2]):
        mission = short_mission(0, policy=Answers(answer))
        mission.step()
        assert mission.minds.desired.tolist() == [2] * 8


def test_desired_sizes_are_kept_to() -> None:
    world = small_world(1)
    for size in (1, 2, 4):
        scenario = ss.Scenario(robots=10, steps=60, destinations="nearest")
        mission = ss.Mission(scenario, world=world, policy=Pairs(size))
        largest = 1
        for _ in range(60):
            mission.step()
            _, sizes = np.unique(mission.minds.team, return_counts=True)
            largest = max(largest, *sizes)
        assert largest == size


def test_a_policy_in_memory_a_class_and_a_file_do_the_same(tmp_path: Path) -> None:
    file = tmp_path / "pol.py"
    file.write_text(PAIRS)
    keys: Any = {"robots": 6, "steps": 40, "destinations": "nearest"}
    poses = []
    for policy, more in (
        (Pairs(3), {}),
        (Pairs, {"policy": {"size": 3}}),
        (f"{file}:Pairs", {"policy": {"size": 3}}),
    ):
        teams = {"policy": policy, "d_join_m": 3.0}
        run = ss.explore(teams=teams, **more, **keys)
        assert teams["policy"] is policy
        poses.append(run.steps["x_m"].to_list())
    assert poses[0] == poses[1] == poses[2]
    with pytest.raises(PolicyError, match="this one is already made"):
        ss.explore(teams={"policy": Pairs()}, policy={"size": 3}, **keys)
    with pytest.raises(PolicyError, match=r"'teams.policy' is a float, expected a policy's name"):
        ss.explore(teams={"policy": 3.5}, **keys)
    with pytest.raises(PolicyError, match=r"policy is the class Pairs, expected an object"):
        ss.Mission(ss.Scenario(**keys), policy=Pairs)  # type: ignore[arg-type]


def test_a_scenario_finds_the_file_beside_itself(tmp_path: Path) -> None:
    (tmp_path / "pol.py").write_text(PAIRS)
    file = tmp_path / "s.toml"
    file.write_text('robots = 5\n[teams]\npolicy = "pol.py:Pairs"\n[policy]\nsize = 3\n')
    scenario = load_scenario(file)
    assert scenario.teams.policy == f"{tmp_path / 'pol.py'}:Pairs"
    assert ss.Mission(scenario).sizes.policy.size == 3  # type: ignore[attr-defined]
    with pytest.raises(ScenarioError, match=r"'teams.policy'"):
        load_scenario(file, {"teams.policy": ""})
