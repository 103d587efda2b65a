from __future__ import annotations

import contextlib
import inspect
import os
import pty
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from PIL import Image

from swarmscout import Run, Scenario, explore, load_scenario
from swarmscout.destinations.registry import RECOMMENDED
from swarmscout.robots.parameters import BatteryParameters

Command = Callable[..., tuple[int, str, str]]

SHORT = ("--robots", "3", "--steps", "60", "--destinations", "nearest")


def test_a_mission_with_its_summary_run_and_picture(command: Command, here: Path) -> None:
    code, out, err = command("explore", *SHORT, "--seed", "9")
    assert (code, err) == (0, "")
    folder = Path("runs/lava-tube-nearest-n3-s9")
    run = Run.open(folder)
    assert run.finished
    assert run.summary is not None
    assert (run.scenario.robots, run.scenario.steps, run.scenario.seed) == (3, 60, 9)
    for said in (
        f"{run.summary['explored_m2']:.1f} m²",
        f"{run.summary['explored_fraction']:.1%}",
        "step 50:",
        run.summary["end_reason"],
        f"run: {folder}",
        f"picture: {folder}/map.png",
    ):
        assert said in out
    with Image.open(folder / "map.png") as picture:
        assert min(picture.size) > 300
    assert (folder / "map.png").stat().st_size < 300_000


def test_piped_output_is_plain(command: Command) -> None:
    _, out, _ = command("explore", *SHORT, "--no-picture")
    assert not [character for character in out if ord(character) < 32 and character != "\n"]
    assert 5 <= out.count("\n") <= 15
    assert max(len(line) for line in out.splitlines()) <= 160


@pytest.mark.slow
def test_a_terminal_shows_a_bar_with_what_matters(start: Callable[..., Any]) -> None:
    outer, inner = pty.openpty()
    child = start("explore", *SHORT, "--out", "x", "--no-picture", stdout=inner)
    os.close(inner)
    shown = b""
    with contextlib.suppress(OSError):  # A terminal whose other side is closed.
        while more := os.read(outer, 65536):
            shown += more
    os.close(outer)
    assert child.wait() == 0, child.stderr.read()
    child.stderr.close()
    for word in ("step", "/60", "m²", "teams", "charging", "run: x"):
        assert word in shown.decode()


def test_a_reader_that_leaves_early_is_no_error(start: Callable[..., Any]) -> None:
    outer, inner = os.pipe()
    os.close(outer)
    child = start("list", "worlds", stdout=inner)
    os.close(inner)
    assert child.communicate()[1] == ""
    assert child.returncode == 128 + 13


def test_names_count_up(command: Command, here: Path) -> None:
    for _ in range(3):
        assert command("explore", *SHORT, "--no-picture")[0] == 0
    assert sorted(path.name for path in (here / "runs").iterdir()) == [
        "lava-tube-nearest-n3-s0", "lava-tube-nearest-n3-s0-2", "lava-tube-nearest-n3-s0-3",
    ]  # fmt: skip


def test_a_scenario_file_and_what_is_set_on_top(command: Command, here: Path) -> None:
    (here / "mine.toml").write_text("robots = 2\nsteps = 10\n[teams]\ndesired_size = 4\n")
    words = ["explore", "mine.toml", "--out", "x", "--no-picture", "--record", "curves"]
    words += ["--set", "teams.d_join_m=3.5", "--start", "spread", "--set", "seed = 5"]
    assert command(*words, "--robots", "4")[0] == 0
    scenario = Run.open("x").scenario
    assert (scenario.robots, scenario.steps, scenario.seed) == (4, 10, 5)
    assert (scenario.teams.desired_size, scenario.teams.d_join_m) == (4, 3.5)
    assert scenario.start == "spread"
    assert Run.open("x").level == "curves"


def test_a_run_folder_is_a_scenario(command: Command) -> None:
    assert command("explore", *SHORT, "--out", "x", "--no-picture")[0] == 0
    assert command("explore", "x", "--out", "y", "--no-picture")[0] == 0
    assert Run.open("y").steps.equals(Run.open("x").steps)
    assert Path("y/scenario.toml").read_bytes() == Path("x/scenario.toml").read_bytes()


def test_where_nothing_is_said_the_recommended_rule_decides(command: Command) -> None:
    words = ("--steps", "5", "--out", "x", "--record", "summary", "--no-picture")
    assert command("explore", *words)[0] == 0
    home_in_time = BatteryParameters(return_rule="distance")
    expected = Scenario(destinations=RECOMMENDED, steps=5, battery=home_in_time)
    assert Run.open("x").scenario == explore(steps=5).scenario == expected
    assert inspect.signature(explore).parameters["destinations"].default == RECOMMENDED
    assert Scenario().destinations == load_scenario("paper").destinations == "quantile"
    assert Scenario().battery == load_scenario("paper").battery != home_in_time


@pytest.mark.parametrize("name", ["paper", "paper-literal"])
def test_shipped_scenarios(name: str, command: Command) -> None:
    words = ("explore", name, "--steps", "5", "--out", "x", "--record", "summary", "--no-picture")
    assert command(*words)[0] == 0
    run = Run.open("x")
    assert run.scenario.robots == 15
    assert run.scenario.routes.cost == ("probability" if name == "paper-literal" else "length")


def test_a_selector_of_ones_own(command: Command, here: Path) -> None:
    (here / "mine.py").write_text(
        "from swarmscout.destinations.nearest import Nearest\nclass Mine(Nearest):\n    pass\n"
    )
    assert command("explore", *SHORT[:4], "--destinations", "mine.py:Mine", "--no-picture")[0] == 0
    assert [path.name for path in (here / "runs").iterdir()] == ["lava-tube-Mine-n3-s0"]


def test_a_run_with_a_rule_of_ones_own_runs_again_from_elsewhere(
    command: Command, here: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (here / "rules").mkdir()
    (here / "rules" / "mine.py").write_text(
        "from swarmscout.destinations.nearest import Nearest\nclass Mine(Nearest):\n    pass\n"
    )
    (here / "rules" / "mine.toml").write_text('destinations = "mine.py:Mine"\n')
    words = (*SHORT[:4], "--no-picture")
    assert command("explore", "rules/mine.toml", *words, "--out", "x")[0] == 0
    (here / "rules" / "mine.py").unlink()
    (here / "elsewhere").mkdir()
    (here / "x").rename(here / "elsewhere" / "x")
    monkeypatch.chdir(here / "elsewhere")
    assert command("explore", "x", "--out", "y", "--no-picture")[0] == 0
    first, again = Run.open("x"), Run.open("y")
    assert again.steps.equals(first.steps)
    assert again.decisions.equals(first.decisions)
    assert again.summary == first.summary
    assert Path("y/scenario.toml").read_bytes() == Path("x/scenario.toml").read_bytes()


@pytest.mark.parametrize("where", ["one file", "two files of one name", "two files"])
def test_a_run_keeps_a_policy_of_ones_own_beside_a_selector(
    where: str, command: Command, here: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    selector = (
        "from swarmscout.destinations.nearest import Nearest\nclass Mine(Nearest):\n    pass\n"
    )
    policy = (
        "import numpy as np\nclass Few:\n    def __init__(self, size: int = 2):\n"
        "        self.size = size\n"
        "    def desired(self, view):\n        return np.full(len(view), self.size)\n"
    )
    one = {"one file": "a/mine.py", "two files": "a/sizes.py"}.get(where, "b/mine.py")
    for folder in ("a", "b", "elsewhere"):
        (here / folder).mkdir()
    (here / "a" / "mine.py").write_text(selector)
    with (here / one).open("a") as file:
        file.write(policy)
    words = ("--robots", "6", "--steps", "50", "--no-picture", "--destinations", "a/mine.py:Mine")
    sizes = ("--set", f"teams.policy={one}:Few", "--set", "policy.size=3")
    assert command("explore", *words, *sizes, "--out", "x")[0] == 0
    kept = {"one file": [], "two files": ["sizes.py"]}.get(where, ["policy_mine.py"])
    assert sorted(path.name for path in (here / "x").glob("*.py")) == ["mine.py", *kept]
    (here / "a" / "mine.py").unlink()
    (here / "x").rename(here / "elsewhere" / "x")
    monkeypatch.chdir(here / "elsewhere")
    assert command("explore", "x", "--out", "y", "--no-picture")[0] == 0
    first, again = Run.open("x"), Run.open("y")
    assert again.steps.equals(first.steps)
    asked = first.steps.filter(first.steps["step"] > 0)
    assert set(asked["desired"]) == {3}
    assert Path("y/scenario.toml").read_bytes() == Path("x/scenario.toml").read_bytes()


@pytest.mark.parametrize(
    ("key", "says"),
    [
        ("teams.policy=by-crowds", "unknown policy 'by-crowds': did you mean 'by-crowd'?"),
        ("teams.policy=pol.py:Fails", "failed in step 1: ZeroDivisionError: division by zero"),
        ("teams.policy=pol.py:Fail", "policy file 'pol.py' has no 'Fail': did you mean 'Fails'?"),
        ("teams.policy=nothing.py:Fails", "policy file 'nothing.py' does not exist"),
        ("policy.size=3", "policy 'by-mode' has no parameter 'size': it takes none"),
    ],
)
def test_mistakes_with_policies_are_one_line(
    key: str, says: str, command: Command, here: Path
) -> None:
    (here / "pol.py").write_text(
        "class Fails:\n    def desired(self, view):\n        return 1 / 0\n"
    )
    code, _, err = command("explore", *SHORT, "--no-picture", "--out", "x", "--set", key)
    assert code != 0
    assert says in err
    assert err.count("\n") == 1
    if "Fails" in says or "failed" in says:
        assert "pol.py" in err


def test_files_with_a_byte_order_mark(command: Command, here: Path) -> None:
    (here / "mine.toml").write_bytes(b"\xef\xbb\xbfrobots = 2\nsteps = 3\n")
    assert command("explore", "mine.toml", "--out", "x", "--no-picture")[0] == 0
    assert Run.open("x").scenario.robots == 2


def test_a_reason_that_is_no_text_is_kept_as_far_as_it_is(command: Command, here: Path) -> None:
    (here / "mine.py").write_text(
        "from swarmscout.destinations.selector import Choice\nclass Mine:\n"
        "    def choose(self, view, memory):\n"
        "        return Choice(tuple(view.frontiers[0].tolist()), reason='\\ud800 far')\n"
    )
    words = (*SHORT[:4], "--destinations", "mine.py:Mine", "--out", "x", "--no-picture")
    assert command("explore", *words)[::2] == (0, "")
    assert set(Run.open("x").decisions["reason"]) == {"? far"}


def test_the_summary_says_who_is_stranded_and_what_helps(command: Command) -> None:
    words = ("--robots", "1", "--steps", "80", "--no-picture", "--set", "battery.capacity_steps=40")
    words = (*words, "--set", "battery.return_rule=threshold")
    hint = "the only robot ran out of charge: none is left to explore; to return in time"
    _, out, _ = command("explore", *words, "--set", "battery.charge_below=0.0")
    assert f"{hint}: --set battery.return_rule=distance" in out
    assert "1 robot in lava-tube" in out
    assert "part wall, part free" in out
    _, out, _ = command("explore", "--robots", "2", "--steps", "10", "--no-picture")
    assert "ran out of charge" not in out
